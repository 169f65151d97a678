"""Hair in turbulent wind, on the GPU.

    import windswept as ws

    scene = ws.Scene.load("examples/scenes/quick.toml")
    sim = ws.Simulation(scene)
    sim.step(100)
    sim.hair.positions      # (points, 3) float32, m

SI everywhere, right-handed, Y up; quaternions are x, y, z, w. Arrays come in as any float dtype, and go out as float32 in
C order. `help(ws.Simulation)` is a place to start.
"""

from types import ModuleType as _ModuleType
from typing import TYPE_CHECKING as _TYPE_CHECKING

from windswept import ops
from windswept._native import (
    Air,
    ExportError,
    Followers,
    Frame,
    FrameAir,
    FrameHair,
    Frames,
    GpuError,
    Groom,
    Hair,
    RunError,
    Scene,
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
from windswept.measures import measure
from windswept.meshes import write_mesh

if _TYPE_CHECKING:
    from windswept import plot, sweep, usd

__all__ = [
    "Air",
    "ExportError",
    "Followers",
    "Frame",
    "FrameAir",
    "FrameHair",
    "Frames",
    "GpuError",
    "Groom",
    "Hair",
    "RunError",
    "Scene",
    "SceneError",
    "Simulation",
    "VtkHdfWriter",
    "Writer",
    "__version__",
    "adapters",
    "contact_sheet",
    "formats",
    "measure",
    "ops",
    "plot",
    "sweep",
    "usd",
    "write_mesh",
    "write_png",
]


def __getattr__(name: str) -> _ModuleType:
    # What most programs need not import: NumPy's and Matplotlib's start-up is longer than ours.
    if name in ("plot", "sweep", "usd"):
        import importlib

        return importlib.import_module(f"windswept.{name}")
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return [*__all__, *(name for name in globals() if name.startswith("__"))]
