"""Pictures of a simulation in a notebook, and films with a slider there or in a browser."""

from __future__ import annotations

import base64
import html
from collections.abc import Iterable
from os import PathLike, fspath
from pathlib import Path
from string import Template
from typing import TYPE_CHECKING, Any

from windswept._native import ExportError, GpuError, Simulation, write_png
from windswept.scene import Scene

if TYPE_CHECKING:
    from numpy import uint8
    from numpy.typing import NDArray

_PAGE = Template("""<!doctype html>
<meta charset="utf-8">
<title>Hair</title>
<style>
body { margin: 0; font: 13px sans-serif; max-width: min(${width}px, calc((100vh - 32px) * $width / $height)) }
#film { position: relative; aspect-ratio: $width / $height }
#film img { position: absolute; width: 100% }
#film img + img:not(.shown) { visibility: hidden }
#bar { display: flex; gap: 8px; align-items: center; height: 32px }
#at { flex: 1 }
</style>
<div id="film">
$pictures
</div>
<div id="bar">
<button id="play">Play</button>
<input id="at" type="range" min="0" max="$last" value="0">
<output id="time"></output>
</div>
<script>
const [pictures, play, at, time] = [document.images, ...["play", "at", "time"].map(id => document.getElementById(id))];
let shown = 0, timer;
function show(index) {
  pictures[shown].className = "";
  shown = at.value = Number(index);
  pictures[shown].className = "shown";
  time.value = (shown / $fps).toFixed(2) + " s";
}
play.onclick = () => {
  timer = timer ? void clearInterval(timer) : setInterval(() => show((shown + 1) % pictures.length), 1000 / $fps);
  play.textContent = timer ? "Pause" : "Play";
};
at.oninput = () => {
  if (timer) play.onclick();
  show(at.value);
};
show(0);
</script>
""")


class Player:
    """A film with a play button and a slider, as `show` makes it: the last value of a notebook's cell shows it."""

    def __init__(self, pictures: list[bytes], fps: float) -> None:
        #: PNG files.
        self.pictures = pictures
        #: Pictures a second.
        self.fps = fps
        #: Width and height [px].
        self.size = _size(pictures[0])

    def html(self) -> str:
        """A page that needs no other file: the pictures are in it, with a third more bytes than as PNG files."""
        pictures = "\n".join(f'<img src="{_uri(picture)}">' for picture in self.pictures)
        width, height = self.size
        last = len(self.pictures) - 1
        return _PAGE.substitute(width=width, height=height, pictures=pictures, last=last, fps=self.fps)

    def save(self, path: str | PathLike[str]) -> None:
        """Writes `html` to a file, for any browser.

        Raises:
            OSError: it cannot be written.
        """
        Path(path).write_text(self.html(), encoding="utf-8")

    def _repr_html_(self) -> str:
        # A frame of its own keeps its names and style out of the notebook's.
        width, height = self.size
        style = f"border: 0; width: 100%; max-width: {width}px; aspect-ratio: {width} / {height + 32}"
        return f'<iframe style="{style}" srcdoc="{html.escape(self.html())}"></iframe>'

    def __repr__(self) -> str:
        width, height = self.size
        return (
            f"<windswept.Player: {len(self.pictures)} pictures of {width} x {height}, {self.fps:g} a second; "
            "save('film.html') writes it for a browser>"
        )


def show(
    film: Simulation | str | PathLike[str] | Iterable[NDArray[uint8]],
    duration: float | None = None,
    *,
    fps: float | None = None,
    **view: Any,
) -> Player:
    """A film as a player for a notebook; elsewhere its `save` writes a page for a browser.

        ws.show("out/quick")                            # the pictures of a run
        ws.show(sim, 0.5, width=480, height=270)        # what comes next
        ws.show(sim.render(camera="side") for _ in sim.frames(30)).save("side.html")

    Args:
        film: a folder with PNG pictures, or with such a folder `frames`; pictures, each `(height, width, 4)` uint8, as
            `sim.render()` returns them; or a simulation, which is stepped.
        duration: of a simulation, how long it is stepped [s]; None: what its scene's duration has left.
        fps: pictures a second; None: the frame rate of the simulation's scene, or of the folder's scene.toml, else 30.
        view: of a simulation, arguments of `sim.render`.

    Raises:
        ValueError: there is no picture, one has another shape, dtype or size, or an argument is out of range.
        TypeError: `film` is something else; `duration` or `view` for what is not a simulation.
        OSError: a picture cannot be read.
        RunError: as `sim.step`.
    """
    if fps is not None and not 0 < fps <= 1000:
        raise ValueError(f"fps: expected pictures a second, above 0 and at most 1000, found {fps!r}")
    if isinstance(film, Simulation):
        rate = float(film.scene["time.frame_rate"])
        if duration is not None and not 0 <= duration < 1e6:
            raise ValueError(f"duration: expected a time of at least 0 [s], found {duration!r}")
        frames = film.frames(None if duration is None else round(duration * rate))
        pictures = [_png(film.render(**view)), *(_png(film.render(**view)) for _ in frames)]
        return Player(pictures, fps or rate)
    if duration is not None or view:
        names = ", ".join([*(["duration"] if duration is not None else []), *view])
        raise TypeError(f"{names}: for a simulation only, found {type(film).__name__}")
    rate = 30.0
    if isinstance(film, (str, PathLike)):
        folder = Path(film)
        found = sorted(folder.glob("frames/*.png")) or sorted(folder.glob("*.png"))
        if not found:
            raise ValueError(f"{folder}: expected a folder of PNG pictures; `windswept render` draws those of a run")
        pictures = [path.read_bytes() for path in found]
        if fps is None and (folder / "scene.toml").is_file():
            rate = float(Scene.load(folder / "scene.toml")["time.frame_rate"])
    elif isinstance(film, Iterable):
        pictures = [_png(picture) for picture in film]
    else:
        raise TypeError(f"film: expected a simulation, a folder or pictures, found {type(film).__name__}")
    if not pictures:
        raise ValueError("film: expected pictures, found none")
    for picture in pictures:
        if _size(picture) != _size(pictures[0]):
            raise ValueError(f"film: expected pictures of one size, found {_size(pictures[0])} and {_size(picture)}")
    return Player(pictures, fps or rate)


def _png(picture: NDArray[uint8]) -> bytes:
    from tempfile import TemporaryDirectory

    with TemporaryDirectory() as folder:
        path = Path(folder) / "picture.png"
        write_png(path, picture)
        return path.read_bytes()


def _uri(png: bytes) -> str:
    return f"data:image/png;base64,{base64.b64encode(png).decode()}"


def _size(png: bytes) -> tuple[int, int]:
    """Width and height, from the first chunk of a PNG file."""
    return int.from_bytes(png[16:20], "big"), int.from_bytes(png[20:24], "big")


_facts = Simulation._repr_html_


# Notebooks take HTML before any picture: the table of the native module has the picture above it.
def _repr_html_(self: Simulation) -> str:
    try:
        picture = f'<img src="{_uri(_png(self.render()))}">'
    except (ExportError, GpuError) as error:
        picture = f"<p>{html.escape(str(error))}</p>"
    return picture + _facts(self)


Simulation._repr_html_ = _repr_html_  # type: ignore[method-assign]
