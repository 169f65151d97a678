"""Grooms from USD files, by USD's own library: `pip install 'windswept[usd]'` (CPython 3.11 or later).

    ws.usd.to_npz("groom.usdc", "groom.npz")
    groom = ws.Groom.load("groom.npz", strands=2000)

Alembic files become USD by Blender: see the README.
"""

from importlib import import_module
from os import PathLike
from types import ModuleType
from typing import Any

import numpy as np
from numpy.typing import NDArray

__all__ = ["to_npz"]

#: What other programs call what a curve has; of several the first.
_NAMES = {
    "ids": ("groom_id",),
    "groups": ("groom_group_id",),
    "root_uv": ("groom_root_uv", "surface_uv_coordinate"),
    "guides": ("groom_guide",),
}


def to_npz(path: str | PathLike[str], out: str | PathLike[str], time: float | None = None) -> int:
    """Writes the curves of a USD file as arrays of a groom file, which `hair.file` and `Groom.load` read.

    All BasisCurves of the stage are taken, where they are in the world: curves that go through their vertices ("linear", or
    "catmullRom" that is pinned), and Bézier curves by their points on the curve. Curves keep the order of the stage; `groom_id`,
    `groom_group_id`, `groom_root_uv` and `groom_guide` become ids, groups, root_uv and guides, where every prim has them. The unit
    comes along, and what is up becomes +Y.

    Args:
        path: the file: .usd, .usda, .usdc or .usdz.
        out: the .npz file; one that is there is replaced.
        time: time code of the shape; None: what is there without a time, or else the first sample.

    Returns:
        How many curves there are.

    Raises:
        ModuleNotFoundError: usd-core is not installed.
        ValueError: the file has no curves, or some that do not go through their vertices.
    """
    Usd, UsdGeom = _library()
    stage = Usd.Stage.Open(str(path))
    prims = [UsdGeom.BasisCurves(prim) for prim in stage.Traverse() if prim.IsA(UsdGeom.BasisCurves)]
    if not prims:
        raise ValueError(f"{path}: expected BasisCurves, found none")
    parts = [_curves(curves, time) for curves in prims]
    arrays: dict[str, Any] = {
        "points": np.concatenate([part["points"] for part in parts]),
        "offsets": np.concatenate([[0], np.cumsum(np.concatenate([part["counts"] for part in parts]))]),
        "meters_per_unit": np.array(UsdGeom.GetStageMetersPerUnit(stage)),
    }
    if UsdGeom.GetStageUpAxis(stage) == UsdGeom.Tokens.z:
        x, y, z = arrays["points"].T
        arrays["points"] = np.stack([x, z, -y], axis=1)
    for name in ("radius", *_NAMES):
        if all(name in part for part in parts):
            arrays[name] = np.concatenate([part[name] for part in parts])
    np.savez(out, **arrays)
    return len(arrays["offsets"]) - 1


def _library() -> tuple[ModuleType, ModuleType]:
    """USD's own modules, which have no types."""
    return import_module("pxr.Usd"), import_module("pxr.UsdGeom")


def _curves(curves: Any, time: float | None) -> dict[str, NDArray[Any]]:
    """Points and what else a prim has, each curve by its points on it, in the world."""
    Usd, UsdGeom = _library()
    path = curves.GetPath()
    code = Usd.TimeCode.EarliestTime() if time is None else Usd.TimeCode(time)
    counts = np.array(curves.GetCurveVertexCountsAttr().Get(code), dtype=np.int64)
    points = np.array(curves.GetPointsAttr().Get(code), dtype=np.float64).reshape(-1, 3)
    if counts.sum() != len(points):
        raise ValueError(f"{path}: {len(points)} points are not the {counts.sum()} of its curves")
    kind, basis, wrap = (attribute.Get() for attribute in (curves.GetTypeAttr(), curves.GetBasisAttr(), curves.GetWrapAttr()))
    if wrap == "periodic":
        raise ValueError(f"{path}: expected curves with two ends, found periodic ones")
    kept = np.ones(len(points), dtype=bool)
    if kind == "cubic" and basis == "bezier":
        # Every third vertex is on the curve, the others are handles.
        kept = np.concatenate([np.arange(count) % 3 == 0 for count in counts])
    elif kind == "cubic" and not (basis == "catmullRom" and wrap == "pinned"):
        raise ValueError(f"{path}: expected curves through their vertices, found {basis} that is {wrap}")
    matrix = np.array(UsdGeom.XformCache(code).GetLocalToWorldTransform(curves.GetPrim()))
    # Rows are points: the matrix stands on the right.
    points = points @ matrix[:3, :3] + matrix[3, :3]
    ends = np.concatenate([[0], np.cumsum(counts)])
    found = {"points": points[kept], "counts": np.array([kept[a:b].sum() for a, b in zip(ends, ends[1:])], dtype=np.int64)}
    widths = curves.GetWidthsAttr().Get(code)
    if widths is not None and len(widths):
        scale = abs(np.linalg.det(matrix[:3, :3])) ** (1 / 3)
        radius = _per_point(np.array(widths, dtype=np.float64), counts, len(kept))
        if radius is not None:
            found["radius"] = 0.5 * scale * radius[kept]
    api = UsdGeom.PrimvarsAPI(curves)
    for name, primvars in _NAMES.items():
        present = (api.GetPrimvar(primvar) for primvar in primvars)
        values = (np.array(primvar.ComputeFlattened(code)) for primvar in present if primvar.HasValue())
        found.update((name, value) for value in values if len(value) == len(counts) and name not in found)
    return found


def _per_point(values: NDArray[np.float64], counts: NDArray[np.int64], points: int) -> NDArray[np.float64] | None:
    """Values per point, curve or prim as one for each point; None where they are something else."""
    if len(values) == points:
        return values
    if len(values) == len(counts):
        return np.repeat(values, counts)
    return np.repeat(values, points) if len(values) == 1 else None
