"""A simulation that runs while a browser looks on, by viser."""

from __future__ import annotations

import math
import time
from collections.abc import Mapping
from queue import SimpleQueue
from threading import Thread
from typing import TYPE_CHECKING

import numpy as np

from windswept._native import GpuError, RunError, SceneError, Simulation

if TYPE_CHECKING:
    from numpy.typing import NDArray
    from viser import GuiSliderHandle

#: Keys that most scenes have, each with the ends of its slider.
_DIALS = {
    "air.wind": (-10.0, 10.0),
    "turbulence.scale": (0.004, 0.04),
    "turbulence.intensity": (0.0, 2.0),
    "gravity": (-20.0, 20.0),
    "rods.damping": (0.0, 20.0),
}
#: Pictures a second, segments and particles of a picture: at most.
_RATE, _SEGMENTS, _PARTICLES = 30.0, 100_000, 20_000


def live(
    sim: Simulation, port: int = 8080, *, dials: Mapping[str, tuple[float, float]] | None = None, play: bool = True
) -> Live:
    """Runs a simulation in a thread of its own, and serves a page that shows it and changes it. Needs viser:
    `pip install 'windswept[live]'`.

        page = ws.live(sim)             # in a notebook; page.stop() ends it
        ws.live(sim).wait()             # in a program, until Ctrl-C

    The page has strands as lines, air particles as points, no bodies, and sliders that call `sim.update`. It is served
    to this machine alone; to see that of a server, forward the port: `ssh -L 8080:127.0.0.1:8080 SERVER`.

    Args:
        sim: is stepped, at most as fast as time passes.
        port: on 127.0.0.1, 0 to 65535; the next free one if it is taken, any for 0.
        dials: dotted keys of numbers and vectors that `sim.update` takes, each with the ends of its slider; None: wind,
            eddies, gravity and damping, as far as the scene has them.
        play: whether it runs at once.

    Raises:
        ImportError: viser is not installed.
        SceneError: there is no such key.
        ValueError: another port; a dial without a number or with wrong ends.
    """
    if not isinstance(sim, Simulation):
        raise TypeError(f"sim: expected a windswept.Simulation, found {type(sim).__name__}")
    if not 0 <= port <= 65535:
        raise ValueError(f"port: expected 0 to 65535, found {port!r}")
    scene = sim.scene
    if dials is None:
        dials = {key: ends for key, ends in _DIALS.items() if key in scene}
    for key, ends in dials.items():
        if not (len(ends) == 2 and all(map(math.isfinite, ends)) and ends[0] < ends[1]):
            raise ValueError(f"dials: expected the lowest and the highest value of {key}, found {ends!r}")
        if isinstance(scene[key], bool) or not isinstance(scene[key], (int, float, np.ndarray)):
            raise ValueError(f"dials: expected keys of numbers and vectors, found {key}, which is {scene[key]!r}")
    return Live(sim, port, dials, play)


class Live:
    """What `live` serves, until `stop`."""

    def __init__(self, sim: Simulation, port: int, dials: Mapping[str, tuple[float, float]], play: bool) -> None:
        try:
            import viser
        except ImportError as error:
            raise ImportError("windswept.live needs viser: pip install 'windswept[live]'") from error
        self._sim, self._asked = sim, SimpleQueue[str]()
        hair, air = sim.hair.positions, sim.air.positions
        self._segments = _segments(sim.hair.offsets)
        self._particles = slice(None, None, 1 + len(air) // _PARTICLES)
        self._server = server = viser.ViserServer("127.0.0.1", port, label="windswept", verbose=False)
        self.url = f"http://127.0.0.1:{server.get_port()}"
        server.gui.configure_theme(show_share_button=False)
        server.scene.set_up_direction("+y")
        seen = hair if len(hair) else air
        center, size = seen.mean(axis=0), float(np.ptp(seen, axis=0).max())
        server.initial_camera.near = 0.01 * size
        server.initial_camera.look_at = center
        server.initial_camera.position = center + size * np.array([0.3, 0.3, 1.2])
        self._lines = server.scene.add_line_segments(
            "/hair", hair[self._segments], (70, 45, 25), thickness=1.5, thickness_units="screen"
        )
        self._points = server.scene.add_point_cloud(
            "/air", air[self._particles], (150, 190, 230), point_size=0.004 * size, precision="float32"
        )

        self._status = server.gui.add_markdown("")
        self._play = server.gui.add_checkbox("Play", play)
        self._play.on_update(lambda _: self._asked.put("play"))
        server.gui.add_button("Step").on_click(lambda _: self._asked.put("step"))
        self._pace = server.gui.add_slider("Speed", 0.02, 1.0, 0.02, 1.0, hint="at most, over that of real time")
        shown = server.gui.add_checkbox("Air", True)
        shown.on_update(lambda _: setattr(self._points, "visible", shown.value))
        self._dials = {key: self._sliders(key, low, high) for key, (low, high) in dials.items()}
        self._said = server.gui.add_markdown("")
        self._rate, self._shown = 0.0, -math.inf
        self._show()
        self._thread = Thread(target=self._work, name="windswept.live", daemon=True)
        self._thread.start()

    def stop(self) -> None:
        """Ends the thread after its step, and frees the port. The simulation stays as it is then."""
        self._asked.put("stop")
        self._thread.join()
        self._server.stop()

    def wait(self) -> None:
        """Returns after `stop`, or stops at Ctrl-C."""
        try:
            while self._thread.is_alive():
                self._thread.join(0.2)
        except KeyboardInterrupt:
            self.stop()

    def _sliders(self, key: str, low: float, high: float) -> list[GuiSliderHandle[float]]:
        """A slider for a number, three for a vector."""
        value = self._sim.scene[key]
        sliders = []
        for name, part in [("", value)] if np.ndim(value) == 0 else zip((" x", " y", " z"), value.tolist()):
            least, most = min(low, part), max(high, part)
            step = 10.0 ** math.floor(math.log10((most - least) / 100))
            sliders.append(self._server.gui.add_slider(key + name, least, most, step, part))
            sliders[-1].on_update(lambda _: self._asked.put(key))
        return sliders

    def _work(self) -> None:
        while True:
            # Paused it waits here.
            asked = set() if self._play.value else {self._asked.get()}
            while not self._asked.empty():
                asked.add(self._asked.get())
            if "stop" in asked:
                return
            try:
                changes = {key: [slider.value for slider in self._dials[key]] for key in asked & self._dials.keys()}
                if changes:
                    self._sim.update(**{key: parts if len(parts) == 3 else parts[0] for key, parts in changes.items()})
                    self._said.content = ""
                if self._play.value:
                    self._run()
                elif "step" in asked:
                    self._sim.step()
                    self._show()
            except (SceneError, RunError, GpuError) as error:
                if not isinstance(error, SceneError):
                    self._play.value = False  # type: ignore[misc]
                self._said.content = str(error)

    def _run(self) -> None:
        """Steps for the time of a picture, or as far as the simulation may come in it, and shows that."""
        begun, pace, before = time.monotonic(), self._pace.value, self._sim.time
        while True:
            self._sim.step()
            passed, ran = time.monotonic() - begun, self._sim.time - before
            if passed > 1 / _RATE or ran >= pace / _RATE:
                break
        self._show()
        time.sleep(max(0.0, begun + max(1 / _RATE, ran / pace) - time.monotonic()))

    def _show(self) -> None:
        hair, air = self._sim.hair.positions, self._sim.air.positions
        self._lines.points = hair[self._segments]
        if self._points.visible:
            self._points.points = air[self._particles]
        now = time.monotonic()
        self._rate += 0.1 * (1 / max(now - self._shown, 1e-3) - self._rate)
        self._shown = now
        self._status.content = f"{self._sim.time:.3f} s, {self._sim.steps} steps, {self._rate:.1f} FPS"

    def _repr_html_(self) -> str:
        return f'<iframe src="{self.url}" style="border: 0; width: 100%; height: 600px"></iframe>'

    def __repr__(self) -> str:
        return f"<windswept.Live: {self.url}>"


def _segments(offsets: NDArray[np.int64]) -> NDArray[np.int64]:
    """`(n, 2)` points at the ends of the segments of all strands, or of evenly chosen ones where they are many."""
    points = np.arange(offsets[-1])
    strand = np.repeat(np.arange(len(offsets) - 1), np.diff(offsets))
    drawn = strand % (1 + len(points) // _SEGMENTS) == 0
    drawn[offsets[1:] - 1] = False
    return np.stack([points[drawn], points[drawn] + 1], axis=1)
