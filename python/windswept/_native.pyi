"""The native module. `cargo xtask stubs` writes its docstrings."""

from collections.abc import Callable, Iterable, Iterator, Sequence
from os import PathLike
from types import TracebackType
from typing import Any, ClassVar, Literal, TypeAlias, final

import numpy as np
from numpy.typing import ArrayLike, NDArray
from typing_extensions import Self

from windswept.report import Report
from windswept.scene import Scene

#: What arrays come in as: floats, `(n, 3)` or as documented.
_Array: TypeAlias = ArrayLike
_End: TypeAlias = Literal["clamped", "pinned", "free"]
_Rest: TypeAlias = Literal["hanging", "weightless"]
_Path: TypeAlias = str | PathLike[str]

__all__ = [
    "__version__",
    "SceneError",
    "GpuError",
    "RunError",
    "ExportError",
    "CheckedScene",
    "Groom",
    "Simulation",
    "HairState",
    "AirState",
    "Followers",
    "Frame",
    "FrameHair",
    "FrameAir",
    "Frames",
    "Writer",
    "VtkHdfWriter",
    "formats",
    "adapters",
    "command",
    "_keys",
    "write_png",
    "contact_sheet",
    "_measure_file",
    "_measure_frames",
    "ops_density",
    "ops_vorticity",
    "ops_band_velocity",
    "ops_viscosity",
    "ops_solve_density",
]
__version__: str

class SceneError(ValueError):
    """A fault in a scene or a groom: `key`, `line` and `help` say where and what to do."""
    key: str | None
    line: int | None
    help: str | None

class GpuError(RuntimeError):
    """No adapter, no device, a device that is lost or too small."""
class RunError(RuntimeError):
    """A run that cannot go on: what blew up, in which step."""
class ExportError(RuntimeError):
    """A file or a picture that cannot be made."""

def write_png(path: _Path, picture: NDArray[np.uint8]) -> None:
    """Writes a picture, as `sim.render()` returns it, as PNG: `(height, width, 4)` uint8, without its alpha.

    Raises:
        ExportError: it cannot be written.
    """
def contact_sheet(pictures: Sequence[_Path], path: _Path) -> None:
    """Puts pictures of one size side by side into one, in rows of up to four.

    Args:
        pictures: files.
        path: of the sheet, a PNG.

    Raises:
        ExportError: one cannot be read, their sizes differ, they have more than 134 million pixels in all, the sheet
            cannot be written.
    """
def _measure_file(
    path: _Path, wind: Sequence[float] | None, gravity: Sequence[float] | None, start: float | None, end: float | None
) -> str: ...
def _measure_frames(
    frames: Iterable[Frame],
    wind: Sequence[float] | None,
    gravity: Sequence[float] | None,
    start: float | None,
    end: float | None,
) -> str: ...
def formats() -> dict[str, str]:
    """Every format that `Writer` writes: its name, and what that writes."""
def adapters() -> list[dict[str, str]]:
    """Every adapter of Vulkan, Metal and DX12, the one that would be taken first.

    Returns:
        A list of {"name", "backend", "driver", "kind"}; kind is "discrete", "integrated", "virtual", "software" or
        "other". Empty without a driver.
    """
def command(arguments: Sequence[str]) -> int:
    """The `windswept` command with these arguments, the program's name first; returns its exit status."""
def _keys() -> str:
    """Every key of a scene as JSON, for `python/generate.py`."""

@final
class CheckedScene:
    """The checked scene of a `windswept.Scene`."""
    @staticmethod
    def load(path: _Path) -> CheckedScene:
        """Reads a scene file."""
    @staticmethod
    def parse(text: str) -> CheckedScene:
        """Reads a scene from text."""
    @staticmethod
    def made(values: dict[str, Any]) -> CheckedScene:
        """The scene of the values of a dict."""
    def replaced(self, changes: dict[str, Any]) -> CheckedScene:
        """The scene with other values under dotted keys."""
    def values(self, every: bool) -> dict[str, Any]:
        """Values of the scene as it was written, without those that follow from others; with `every`, those too."""
    def to_toml(self) -> str:
        """The scene as TOML, every table with its heading."""
    @property
    def text(self) -> str:
        """The text that it was read from, or `to_toml`."""
    def text_in(self, folder: _Path) -> str:
        """`text` with paths of files that start from the folder, which is there."""
    def __reduce__(self) -> tuple[Any, tuple[str]]: ...

@final
class Groom:
    """Strands of your own, or of a groom file (`Groom.load`): they replace the scene's [hair] wholly.

    Each value is a scalar or an array `(strands,)`. Where only some strands are guides, those are simulated, and all
    strands are the simulation's `followers`, which go with them.

    Args:
        points: `(strands, n, 3)` or, with offsets, `(points, 3)` floats, root to tip [m].
        offsets: `(strands + 1,)` first point of each strand, and the number of points.
        group: number of a strand's group, for your own use.
        radius: of a fibre [m]; of a flat one the semi-major axis, along d2.
        density: of a fibre [kg/m³].
        youngs_modulus: E [Pa].
        poissons_ratio: above -1, at most 0.5.
        rest_curvature: rest Darboux vector (kappa1, kappa2, tau) [1/m] in the material frame: `(3,)`, `(strands, 3)`,
            `(strands, n - 1, 3)` or, with offsets, `(segments, 3)`: one a joint, joint 0 the clamp. A clamped tip's
            joint is as the last. None: the given shape is the rest shape, tip_frame included; frames go from segment to
            segment by the smallest rotation.
        root_frame: `(4,)` or `(strands, 4)` quaternion x, y, z, w of the clamp, of any length but 0; its d3 need not be
            along the first segment. None: d3 along the first segment, d1 by the smallest rotation from +x (from +z if
            parallel).
        root: "clamped", "pinned" or "free".
        tip: the same; "clamped" with the direct solver only.
        fibres_per_strand: real hairs that a strand stands for.
        point_mass: of every point [kg]. None: from density, radius and lengths.
        aspect: semi-minor over semi-major axis of the cross-section, above 0, at most 1.
        tip_frame: `(4,)` or `(strands, 4)` quaternion of a clamped tip; other tips have none. None: turned on by half a
            joint from the last segment.
        friction: Coulomb's coefficient of the strands on other strands, at least 0; model two-way only.
        rest: "weightless": the given shape is the rest shape, and weight bends strands from it. "hanging": gravity
            alone leaves strands with a clamped root as they are given; those of another root are warned of. Not with
            rest_curvature.
        guides: `(strands,)` bool, which strands are simulated; the others follow the three of those whose roots are
            nearest. None: all are simulated.
        stiffness: factor of the stiffness to bend and twist along each strand: `(pairs, 2)` floats, parts of the length
            from the root, from 0 to 1, with the factors there, linear between. None: 1.

    Raises:
        ValueError: a wrong shape or dtype, a NaN; names the argument.
        SceneError: points that coincide, a strand of one point, values out of range; `key` is `groom.` and the
            argument.
    """
    def __new__(
        cls,
        points: _Array,
        offsets: _Array | None = None,
        group: _Array | None = None,
        radius: _Array = 4e-5,
        density: _Array = 1320.0,
        youngs_modulus: _Array = 4e9,
        poissons_ratio: _Array = 0.38,
        rest_curvature: _Array | None = None,
        root_frame: _Array | None = None,
        root: _End | Sequence[_End] = "clamped",
        tip: _End | Sequence[_End] = "free",
        fibres_per_strand: _Array = 1.0,
        point_mass: _Array | None = None,
        aspect: _Array = 1.0,
        tip_frame: _Array | None = None,
        friction: _Array = 0.3,
        rest: _Rest = "weightless",
        guides: _Array | None = None,
        stiffness: _Array | None = None,
    ) -> Self: ...
    @staticmethod
    def load(
        path: _Path,
        scale: float | None = None,
        up: Literal["y", "z", "x", "yzx", "zxy", "xzy", "yxz", "zyx"] = "y",
        points: int | None = None,
        strands: int | None = None,
        radius: _Array | None = None,
        points_per_strand: int | None = None,
        seed: int = 1,
        rest: _Rest = "hanging",
        file_guides: bool = True,
    ) -> Groom:
        """Reads strands from a groom file, as `hair.file` of a scene does.

        The ending of the name says the format: .hair, .data, .bin, .npz, .npy or .ply. All strands of the file are the
        groom's, but for those that cannot be simulated. Where the file marks guides (`guides` of a .npz), or `strands`
        asks for fewer than there are, only those are simulated, and the others follow them: `guides` says which. A
        `UserWarning` says how many strands are left out, and how many follow.

        Args:
            path: the file.
            scale: metres per unit of the file; needed, unless the file says its unit.
            up: axis of the file that points up ("y", "z" or "x"), or its axes that become x, y and z ("yzx").
            points: points per strand; they are placed anew, evenly along each. None: the file's.
            strands: how many are simulated, of the file's guides, or of all its strands, those whose roots are far from
                one another.
                None: all guides, or all strands where the file marks none.
            radius: of a fibre [m]. None: the file's, where it has one that is a hair's, 15 to 150 µm on average; else
                40 µm.
            points_per_strand: of a file that does not say where a strand ends.
            seed: draws the first of the strands that are kept.
            rest: "hanging": gravity alone leaves the strands as the file has them. "weightless": it bends them from
                there.
            file_guides: whether the file's marks count; False: as if it marked no guides.

        Raises:
            SceneError: a file that cannot be read, with the byte and what was expected there; no strand that can be
                simulated.
            ValueError: a number out of range; names the argument.
        """
    def save(self, path: _Path) -> None:
        """Writes all strands to a groom file, in metres; the ending of its name says the format: .hair, .data, .npz, .npy,
        .ply.

        A .npz file keeps everything: `points`, `offsets`, `ids`, `radius`, `groups`, `root_uv`, `guides` and
        `meters_per_unit`. A `UserWarning` says what of it another format cannot hold. A file that is there is replaced.

        Raises:
            SceneError: a format that cannot hold the strands; a file that cannot be written.
        """
    @property
    def points(self) -> NDArray[np.float64]:
        """Points of all strands, strand by strand, root to tip: `(points, 3)` float64 [m]."""
    @property
    def offsets(self) -> NDArray[np.int64]:
        """First point of each strand, and the number of points: `(strands + 1,)` int64."""
    @property
    def ids(self) -> NDArray[np.int64]:
        """Number of each strand in the file that it came from, or its index: `(strands,)` int64."""
    @property
    def guides(self) -> NDArray[np.bool_]:
        """Which strands are simulated; the others follow them: `(strands,)` bool."""
    def __len__(self) -> int: ...

@final
class Simulation:
    """Hair and air of one scene on a GPU.

        sim = ws.Simulation(ws.Scene.load("examples/scenes/quick.toml"))
        sim.step(100)
        sim.hair.positions          # (points, 3) float32, m
        for frame in sim.frames(60):
            frame.time, frame.hair.positions
        sim.report()["max_stretch"]

    SI, right-handed, Y up. Between steps, `set_body`, `set_roots`, `set_pins`, `set_wind`, `set_force`, `set_hair` and
    `set_air` drive it; `run` calls back for that. `render` draws it, `VtkHdfWriter` writes it.

    Args:
        scene: what to simulate.
        groom: strands of your own in place of the scene's [hair].
        adapter: "software", or part of an adapter's name; None: WGPU_ADAPTER_NAME, else the best. Simulations on the
            same adapter share its device; each may be stepped from a thread of its own.

    A `UserWarning` for each of the state's warnings, which `report()["warnings"]` has too, says what `windswept check`
    would: strands of a file that are left out or do not hang as given, hair inside bodies, a step that is too long for
    the wind.

    Raises:
        SceneError: the scene's initial state cannot be made.
        GpuError: there is no such adapter, or it has too little room.
    """
    def __new__(cls, scene: Scene, groom: Groom | None = None, adapter: str | None = None) -> Self: ...
    def step(self, n: int = 1) -> None:
        """Runs n steps of dt. Ctrl-C stops between steps.

        Raises:
            RunError: names what ended the run; the state is that of the last good step.
        """
    def run(
        self, duration: float, callback: Callable[[Simulation], object] | None = None, *, every: int = 1
    ) -> None:
        """Runs for a time, in whole steps.

        Args:
            duration: [s], rounded to steps.
            callback: called with the simulation after every `every` steps, e.g. to set roots or wind for the next; the
                run ends early if it returns False.
            every: steps between two calls.

        Raises:
            RunError: as `step`; and what the callback raises.
        """
    def frames(self, n: int | None = None) -> Frames:
        """The next n frames of the scene's frame rate, stepping as they are asked for; None: all that its duration has
        left.

        Frame k is the state after step round(k / (frame_rate dt)). `len()` of it is n: `for frame in
        tqdm(sim.frames(240))`.
        """
    def frame(self) -> Frame:
        """The state now, with the scalar of the air that the scene's `picture.air` names."""
    @property
    def time(self) -> float:
        """Time since the start [s]."""
    @property
    def steps(self) -> int:
        """Steps since the start."""
    @property
    def dt(self) -> float:
        """The time step [s], `time.step`."""
    @property
    def scene(self) -> Scene:
        """The scene as it runs: without its [hair] where a groom replaced it, with the wind that `set_wind` set. A
        copy: `update` takes a changed one.
        """
    def recorded(self) -> Scene:
        """The scene that the simulation began with, with each `update` since as a `Change`: a run of it goes the same way."""
    @property
    def adapter(self) -> str:
        """The adapter that runs it: name, backend, driver, kind."""
    @property
    def hair(self) -> HairState:
        """The strands now."""
    @property
    def air(self) -> AirState:
        """The air particles now."""
    @property
    def followers(self) -> Followers:
        """All hairs that the strands stand for, now: those of the groom, or of the scene's groom file, where it has more
        than are simulated, or fibres_per_strand to each strand. The strands are among them.

        Raises:
            ExportError: a groom file that cannot be read any more.
        """
    def report(self) -> Report:
        """The report of the run so far: the command's report.json as a dict. Values that were not measured are missing."""
    def keep_trace(self) -> None:
        """Keeps from now on when each pass of a timed step began and ended on the GPU, for `write_trace`."""
    def write_trace(self, path: _Path) -> None:
        """Writes what was kept since `keep_trace` as a trace in Chrome's format, for chrome://tracing or Perfetto: a bar
        for each run of a pass. About one step in eight is timed, from the second on; none where the adapter has no
        timestamps.

        Raises:
            OSError: the file cannot be written.
        """
    def spectrum(self, scales: _Array) -> NDArray[np.float64]:
        """Energy of the air's eddies now, by their size: the mean of ½ |û|² over the air, about the mean wind.

        û is `ops.band_velocity` of the scene's filter. A scale s stands for waves of about 4.44 s.

        Args:
            scales: s of each band, `(n,)` [m].

        Returns:
            `(n,)` float64 [m²/s²]; empty without air particles.

        Raises:
            ValueError: a scale is not above 0, or too small for a grid on this adapter.
        """
    def body_impulses(self) -> NDArray[np.float64]:
        """Impulse that the air has given each body so far, by its pressure and by friction, in the order of the scene:
        `(bodies, 3)` float64 [kg m/s]; no rows without air particles. The change over a step, divided by it, is the
        force on the body.
        """
    def set_body(
        self,
        name: str,
        translation: _Array | None = None,
        rotation: _Array | None = None,
        *,
        velocity: _Array | None = None,
        angular_velocity: _Array | None = None,
        vertices: _Array | None = None,
    ) -> None:
        """Moves a body of the scene, in place of its keyframes: at the end of the next step it has this pose, and keeps it
        until it is moved again. A mesh may deform instead, by the places of its points. Hair on the body goes with it.

        Args:
            name: of the body.
            translation: `(3,)` [m], at most 1e18, from where the scene has the body without a motion; None: none.
            rotation: quaternion x, y, z, w of a length above 1e-6, about the body's centre, a mesh's the origin of its
                file;
                None: none.
            velocity: `(3,)` [m/s]; with it the body jumps there instead of coming evenly from where it is.
            angular_velocity: `(3,)` [rad/s], as `velocity`.
            vertices: `(n, 3)` [m], in place of all these: where the points of a mesh are, in the order of its file. It
                comes there evenly.

        Raises:
            ValueError: there is no such body, or names the argument that does not fit.
        """
    def set_roots(self, positions: _Array, frames: _Array | None = None) -> None:
        """Where the root of each strand goes in the next step, and stays.

        Args:
            positions: `(strands, 3)` [m].
            frames: `(strands, 4)` quaternions x, y, z, w of the clamps; None: as they are.

        A root that jumps farther than its strand is long takes the strand along as it is, at rest.

        Raises:
            ValueError: names the argument that does not fit; or the scene's hair.motion moves the roots.
        """
    def set_pins(self, points: _Array, places: _Array) -> None:
        """Pins points of hair to places, in place of all pins before. Each goes there within the next step, and stays.

        Args:
            points: `(n,)` rows of `frame().hair.positions`.
            places: `(n, 3)` [m].

        A pinned point is where its pin is; of several pins on a strand, those nearer to the root give by less than 0.1
        mm. Empty arrays release all points; tips that the scene holds go back to where it has them.

        Raises:
            ValueError: names the argument that does not fit: a point that does not exist, is given twice, or is a root
                that is held; or rods.solver is gauss-seidel, or hair.motion moves a tip.
        """
    def set_wind(self, wind: _Array) -> None:
        """The mean wind from the next step on, in place of the scene's wind, ramp and gusts. All air takes the change
        alike in that step; the inflow's eddies stay.

        Args:
            wind: `(3,)` [m/s].

        Raises:
            ValueError: it is not three finite numbers, it is above 1e4 m/s, or the scene has no [air].
        """
    def update(self, scene: Scene | None = None, /, **changes: Any) -> None:
        """Goes on with another scene, or with other values under dotted keys, from the next step on; the state stays.

            sim.update(**{"turbulence.scale": 0.012, "gravity": [0, -3, 0]})
            sim.update(scene)

        Wind, gusts, fields, bands, viscosity, gravity, damping, stiffness and radius of fibres, motions and the camera
        may change; strands, points, bodies, the box of air, the step, model and solvers may not. With `sim.scene` as it
        is now the values are those of a new simulation. Roots, pins and a force that were set stay, and so does a wind
        that was set, unless the scene's wind changes.

        Changes go on top of a scene that is given. Buffers on the device are made anew, strands that sleep wake, and
        new warnings are `UserWarning`s.

        Raises:
            SceneError: a fault of the scene, or the key of a value that a simulation keeps.
        """
    def set_force(
        self,
        hair: _Array | None = None,
        air: _Array | None = None,
        *,
        callback: Callable[[Frame], _Array | tuple[_Array | None, _Array | None] | None] | None = None,
    ) -> None:
        """A force of your own, from the next step on until another one is set: accelerations of hair points and air
        particles. Without arguments nothing is pushed any more.

            sim.set_force(hair=np.broadcast_to(np.float32([0, 9.81, 0]), sim.hair.positions.shape))
            sim.set_force(callback=lambda frame: 50 * (center - frame.hair.positions))

        Held points ignore it, and sleeping strands wake when it changes. The air does not lose what hair gets from it,
        and pressure takes out of it what would compress the air. Checkpoints and pickles hold the accelerations that
        were set last, and not a callback.

        Args:
            hair: `(points, 3)` [m/s²]; None: hair is not pushed.
            air: `(n, 3)` [m/s²], in the order of `sim.air.positions`; None: air is not pushed.
            callback: called with the frame as it is before each step, in place of arrays; it returns the array of hair,
                or a tuple (hair, air) in which either may be None. An exception of it ends the stepping there.

        Raises:
            ValueError: names the argument that has not a row for each point or particle, or numbers beyond 1e18.
        """
    def set_air(self, positions: _Array | None = None, velocities: _Array | None = None) -> None:
        """Puts air somewhere else; what is not given stays.

        Args:
            positions: `(n, 3)` [m], wrapped into the box.
            velocities: `(n, 3)` [m/s].

        Raises:
            ValueError: names the argument that has not a row for each particle, or numbers beyond 1e18.
        """
    def set_hair(
        self, positions: _Array | None = None, velocities: _Array | None = None, orientations: _Array | None = None
    ) -> None:
        """Puts hair somewhere else; what is not given stays, and so do the places of held points.

        Args:
            positions: `(points, 3)` [m].
            velocities: `(points, 3)` [m/s].
            orientations: `(segments, 4)` quaternions x, y, z, w.

        Raises:
            ValueError: names the argument that has not a row for each point or segment, or numbers beyond 1e18.
        """
    def render(
        self,
        width: int | None = None,
        height: int | None = None,
        *,
        camera: str | None = None,
        eye: _Array | None = None,
        target: _Array | None = None,
        fov: float | None = None,
    ) -> NDArray[np.uint8]:
        """A picture of the hair now, as the command draws it: `(height, width, 4)` uint8, sRGB, opaque.

        The scene's [camera] and [picture] say from where and what, unless these arguments do.

            sim.render(eye=[0.3, 0.1, 0.2], target=[0, 0, 0])
            sim.render(camera="side")

        Args:
            width, height: [px]; None: those of the scene's camera.
            camera: name of one of the scene's cameras; None: the first.
            eye, target: `(3,)` [m], place and aim of the camera; None: those of the scene's camera.
            fov: vertical field of view [degrees]; None: that of the scene's camera.

        Raises:
            ValueError: there is no such camera, or an argument is no such value.
            ExportError: there is no strand to draw, or the adapter cannot.
        """
    def save(self, path: _Path) -> None:
        """Saves the simulation to a file, from which `load` goes on with the same bits.

        The file is written beside `path`, flushed to the disk and renamed: whatever becomes of the process, `path` is a
        whole checkpoint or what it was before. A simulation can be pickled and copied too.

        Raises:
            OSError: the file cannot be written.
        """
    @staticmethod
    def load(path: _Path, adapter: str | None = None) -> Simulation:
        """Goes on with a simulation that `save` wrote, or `windswept run --checkpoint-every`. Timings start anew.

        On the adapter that it was saved on it has the same bits as if it had never been saved. On another one, or with
        another version of windswept, it goes on with a warning.

        Args:
            path: the file.
            adapter: as `Simulation`'s; None: `WGPU_ADAPTER_NAME`, else the one that it was saved on if it is there.

        Raises:
            OSError: the file cannot be read.
            ValueError: it is no checkpoint, of another version, cut off or damaged; says what, and where.
            GpuError: as `Simulation`.
        """
    def _repr_html_(self) -> str: ...

@final
class HairState:
    """The strands of a simulation: points root to tip, one strand after the other.

    Every array is a copy of the state now; write with `sim.set_hair`.
    """
    @property
    def positions(self) -> NDArray[np.float32]:
        """`(points, 3)` float32 [m]."""
    @property
    def velocities(self) -> NDArray[np.float32]:
        """`(points, 3)` float32 [m/s]."""
    @property
    def orientations(self) -> NDArray[np.float32]:
        """`(segments, 4)` float32: quaternions x, y, z, w, material frame to world; d3 is the tangent. A strand of n
        points has n - 1.
        """
    @property
    def offsets(self) -> NDArray[np.int64]:
        """`(strands + 1,)` int64: first point of each strand, and the number of points."""
    @property
    def ids(self) -> NDArray[np.int64]:
        """`(strands,)` int64: number of each strand in the groom file that it comes from, or its index."""
    @property
    def root_frames(self) -> NDArray[np.float32]:
        """`(strands, 4)` float32: quaternions x, y, z, w of the frames that clamp the roots."""
    @property
    def drag(self) -> NDArray[np.float32]:
        """`(points, 3)` float32 [N]: force of the air on each point in the last step, drag and lift, of all fibres that
        the strand stands for.
        """
    @property
    def air_velocity(self) -> NDArray[np.float32]:
        """`(points, 3)` float32 [m/s]: velocity of the air at each point, that its drag was found with. Zero with
        interaction.model particles and none.
        """
    @property
    def root_force(self) -> NDArray[np.float32]:
        """`(strands, 3)` float32 [N]: force of each strand's first segment on its clamp in the last step, with the
        pressure of other strands in it. Not a number where something else holds the strand too: a held tip, a pin, a
        body that it touches; zero with interaction.model particles.

        Raises:
            RunError: there was no step since an update, a load, or a force that was set; so for drag and the others.
        """
    @property
    def root_moment(self) -> NDArray[np.float32]:
        """`(strands, 3)` float32 [N m]: moment of each strand on its clamp, about the root; not a number, and zero, where
        `root_force` is.
        """

@final
class AirState:
    """The air particles of a simulation, in the order of their stable ids; none without air particles.

    Every array is a copy of the state now; write with `sim.set_air`.
    """
    @property
    def positions(self) -> NDArray[np.float32]:
        """`(n, 3)` float32 [m], wrapped into the box."""
    @property
    def velocities(self) -> NDArray[np.float32]:
        """`(n, 3)` float32 [m/s]."""
    @property
    def box(self) -> NDArray[np.float64]:
        """`(2, 3)` float64: lower and upper corner of the box of air [m]; zeros without air particles."""
    @property
    def density_ratio(self) -> NDArray[np.float32]:
        """ρ/ρ0 of every particle now: `(n,)` float32; empty when particles do not meet."""
    @property
    def vorticity(self) -> NDArray[np.float32]:
        """|ω| of every particle now, plain SPH sum [1/s]: `(n,)` float32; empty when particles do not meet."""
    @property
    def band_energy(self) -> NDArray[np.float32]:
        """½ |û|² of the first of the scene's turbulence.bands at every particle now [m²/s²]: `(n,)` float32; empty when no
        band is strengthened. See `Simulation.spectrum` for its mean.
        """
    def sample(self, points: _Array) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
        """The air at any places; the periodic box repeats it.

        Args:
            points: `(n, 3)` [m].

        Returns:
            Velocity [m/s], `(n, 3)` float32, the kernel's mean over the particles around, and density [kg/m³], `(n,)`
            float32.

        Raises:
            ValueError: a point is not finite, or the scene has no air particles.
        """

@final
class Followers:
    """Hairs that go with the strands of a simulation at one time: points root to tip, one hair after the other. Its arrays
    are its own.
    """
    @property
    def positions(self) -> NDArray[np.float32]:
        """`(points, 3)` float32 [m]."""
    @property
    def velocities(self) -> NDArray[np.float32]:
        """`(points, 3)` float32 [m/s]."""
    @property
    def offsets(self) -> NDArray[np.int64]:
        """`(hairs + 1,)` int64: first point of each hair, and the number of points."""
    @property
    def ids(self) -> NDArray[np.int64]:
        """`(hairs,)` int64: number of each hair in the groom file that it comes from, or its index."""
    @property
    def guides(self) -> NDArray[np.int64]:
        """`(hairs, 3)` int64: indices of the strands that each hair goes with."""
    @property
    def weights(self) -> NDArray[np.float32]:
        """`(hairs, 3)` float32: how much it goes with each of them."""

@final
class Frame:
    """The state at one time. Its arrays are its own."""
    @property
    def step(self) -> int:
        """Steps since the start."""
    @property
    def time(self) -> float:
        """Time since the start [s]."""
    @property
    def hair(self) -> FrameHair:
        """The strands."""
    @property
    def air(self) -> FrameAir:
        """The air particles."""
    @property
    def bodies(self) -> NDArray[np.float64]:
        """`(bodies, 7)` float64: translation [m] and rotation, quaternion x, y, z, w, of each body in the scene's order,
        as `Simulation.set_body` takes them.
        """

@final
class FrameHair:
    """The strands of a frame: points root to tip, one strand after the other."""
    @property
    def positions(self) -> NDArray[np.float32]:
        """`(points, 3)` float32 [m]."""
    @property
    def velocities(self) -> NDArray[np.float32]:
        """`(points, 3)` float32 [m/s]."""
    @property
    def orientations(self) -> NDArray[np.float32]:
        """`(segments, 4)` float32: quaternions x, y, z, w, material frame to world."""
    @property
    def offsets(self) -> NDArray[np.int64]:
        """`(strands + 1,)` int64: first point of each strand, and the number of points."""

@final
class FrameAir:
    """The air particles of a frame, in the order of their stable ids."""
    @property
    def positions(self) -> NDArray[np.float32]:
        """`(n, 3)` float32 [m], wrapped into the box."""
    @property
    def velocities(self) -> NDArray[np.float32]:
        """`(n, 3)` float32 [m/s]."""
    @property
    def vorticity(self) -> NDArray[np.float32]:
        """`(n,)` float32: |ω| [1/s]; empty unless the scene's `picture.air` is "vorticity"."""
    @property
    def band_energy(self) -> NDArray[np.float32]:
        """`(n,)` float32: ½ |û|² of the first of turbulence.bands [m²/s²]; empty unless `picture.air` is "band_energy"."""

@final
class Frames(Iterator[Frame]):
    """An iterator over the frames of a run; `len()` is how many are left."""
    def __iter__(self) -> Self: ...
    def __next__(self) -> Frame: ...
    def __len__(self) -> int: ...

@final
class Writer:
    """Writes frames of a simulation into a folder, with the files of `windswept run` but for the report and the
    checkpoint.

        with ws.Writer("out", sim) as writer:
            writer.append(sim)
            for frame in sim.frames(240):
                writer.append(sim)

    Every frame that `append` returned from is in the files, whatever becomes of the process. scene.toml is the scene of
    `sim`, with which `windswept render`, `export`, `measure` and `spectrum` read the films. `sim.report()` is what
    `windswept run` writes into report.json.

    One writer or run at a time writes into a folder; `close` lets the next one in.

    Args:
        folder: made if it is not there.
        sim: whose frames are written.
        formats: names of `windswept.formats()`; None: those that the command writes.
        frames: the most it has room for; None: as many as the scene's duration has, at least 256.
        overwrite: removes what an earlier run or writer left in the folder, and what was made of it; other files stay.

    Raises:
        ExportError: a format cannot be written, or the simulation has nothing for it; the folder has files of an
            earlier run, without `overwrite`; another run or writer has the folder, or a file in it is in the way, as a
            link called frames.
        ValueError: there is no such format.
    """
    def __new__(
        cls,
        folder: _Path,
        sim: Simulation,
        *,
        formats: Sequence[str] | None = None,
        frames: int | None = None,
        overwrite: bool = False,
    ) -> Self: ...
    def append(self, sim: Simulation) -> None:
        """Writes the state of `sim` as the next frame.

        Raises:
            ExportError: it is not later than the last one, and no format has it; or it is of other strands or
                particles, or a file has no room or cannot be written, and all other formats have it and go on.
            ValueError: the writer is closed.
        """
    def close(self) -> None:
        """Ends the files."""
    def __enter__(self) -> Self: ...
    def __exit__(
        self,
        kind: type[BaseException] | None = None,
        value: BaseException | None = None,
        traceback: TracebackType | None = None,
    ) -> bool: ...

@final
class VtkHdfWriter:
    """Writes frames of a simulation into one VTKHDF file, for ParaView, VTK and h5py.

        with ws.VtkHdfWriter("hair.vtkhdf", sim) as writer:
            for frame in sim.frames(240):
                writer.append(sim)

    Every frame that `append` returned from is in the file, whatever becomes of the process. Its arrays are those of the
    command's file of that kind.

    Args:
        path: a file of that name is replaced.
        sim: whose strands or air particles are written.
        kind: "hair" or "air"; a file holds one of them.
        frames: the most it has room for; None: as many as the scene's duration has, at least 256.

    Raises:
        ExportError: it cannot be written, or the simulation has nothing of this kind.
    """
    def __new__(
        cls, path: _Path, sim: Simulation, *, kind: Literal["hair", "air"] = "hair", frames: int | None = None
    ) -> Self: ...
    def append(self, sim: Simulation) -> None:
        """Writes the state of `sim` as the next frame.

        Raises:
            ExportError: it is not later than the last one, or of other strands or particles; the file has no room, or
                cannot be written.
            ValueError: the writer is closed.
        """
    def close(self) -> None:
        """Closes the file."""
    def __enter__(self) -> Self: ...
    def __exit__(
        self,
        kind: type[BaseException] | None = None,
        value: BaseException | None = None,
        traceback: TracebackType | None = None,
    ) -> bool: ...

def ops_density(positions: _Array, mass: float, radius: float, box: _Array | None) -> NDArray[np.float32]: ...
def ops_vorticity(
    positions: _Array, velocities: _Array, mass: float, rest_density: float, radius: float, box: _Array | None
) -> NDArray[np.float32]: ...
def ops_band_velocity(
    positions: _Array,
    velocities: _Array,
    mass: float,
    rest_density: float,
    scale: float,
    filter: str,
    cutoff: float | None,
    box: _Array | None,
) -> NDArray[np.float32]: ...
def ops_viscosity(
    positions: _Array, velocities: _Array, mass: float, radius: float, coefficient: float, box: _Array | None
) -> NDArray[np.float32]: ...
def ops_solve_density(
    positions: _Array,
    mass: float,
    rest_density: float,
    radius: float,
    iterations: int,
    relaxation: float,
    box: _Array | None,
) -> NDArray[np.float32]: ...
