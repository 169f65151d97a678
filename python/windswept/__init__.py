"""Hair in turbulent wind, on the GPU.

    import windswept as ws

    scene = ws.Scene.load("examples/scenes/quick.toml")
    scene.air.wind = [4, 0, 0]
    sim = ws.Simulation(scene)
    sim.step(100)
    sim.hair.positions      # (points, 3) float32, m

SI everywhere, right-handed, Y up; quaternions are x, y, z, w. Arrays come in as any float dtype, and go out as float32 in
C order. `help(ws.Simulation)` is a place to start.
"""

from typing import TYPE_CHECKING as _TYPE_CHECKING
from typing import Any as _Any

from windswept import ops, scene
from windswept._native import (
    AirState,
    ExportError,
    Followers,
    Frame,
    FrameAir,
    FrameHair,
    Frames,
    GpuError,
    Groom,
    HairState,
    RunError,
    SceneError,
    Simulation,
    VtkHdfWriter,
    Writer,
    __version__,
    adapters,
    contact_sheet,
    formats,
    write_png,
)
from windswept._player import Player, show
from windswept.measures import measure
from windswept.meshes import write_frames, write_mesh
from windswept.report import Report
from windswept.scene import *

if _TYPE_CHECKING:
    from windswept import plot, sweep, usd
    from windswept._live import Live, live
    from windswept.sweep import ensemble

__all__ = [
    "AirState",
    "ExportError",
    "Followers",
    "Frame",
    "FrameAir",
    "FrameHair",
    "Frames",
    "GpuError",
    "Groom",
    "HairState",
    "Live",
    "Player",
    "Report",
    "RunError",
    "SceneError",
    "Simulation",
    "VtkHdfWriter",
    "Writer",
    "__version__",
    "adapters",
    "contact_sheet",
    "ensemble",
    "formats",
    "live",
    "measure",
    "ops",
    "plot",
    "scene",
    "show",
    "sweep",
    "usd",
    "write_frames",
    "write_mesh",
    "write_png",
]
__all__ += scene.__all__


def __getattr__(name: str) -> _Any:
    # What most programs need not import: NumPy's and Matplotlib's start-up is longer than ours.
    if name == "ensemble":
        from windswept.sweep import ensemble

        return ensemble
    if name in ("Live", "live"):
        from windswept import _live

        return getattr(_live, name)
    if name in ("plot", "sweep", "usd"):
        import importlib

        return importlib.import_module(f"windswept.{name}")
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return [*__all__, *(name for name in globals() if name.startswith("__"))]
