"""Grooms from USD files, by USD's own library: `pip install 'windswept[usd]'` (CPython 3.11 or later).

    ws.usd.to_npz("groom.usdc", "groom.npz")
    groom = ws.Groom.load("groom.npz", strands=2000)

Blender makes USD of an Alembic file, without a window:

    blender --background --python-expr 'import bpy
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.wm.alembic_import(filepath="groom.abc")
    bpy.ops.wm.usd_export(filepath="groom.usdc", export_animation=False)'
"""

import os
import warnings
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

#: How many prims a message names at most.
_MOST_NAMES = 5


def to_npz(path: str | PathLike[str], out: str | PathLike[str], time: float | None = None) -> int:
    """Writes the curves of a USD file as arrays of a groom file, which `hair.file` and `Groom.load` read.

    All BasisCurves of the stage are taken, those of instances too, where they are in the world: curves that go through their
    vertices ("linear", or "catmullRom" that is pinned), and Bézier curves by their points on the curve. Curves keep the order of
    the stage; `groom_id`, `groom_group_id`, `groom_root_uv` and `groom_guide` become ids, groups, root_uv and guides, where every
    prim has them. The unit comes along, and what is up becomes +Y. A `UserWarning` names prims without points, which are left
    out, says which of these and of the widths are left out since only some prims have them, and says how many curves have an id that a
    curve before them has: those get new ids.

    usd-core reads the file, and a damaged .usdc can cost it much memory and time: one of 1 kB took 7 GB and 8 s to be refused.

    Args:
        path: the file: .usd, .usda, .usdc or .usdz.
        out: the groom file, whose name should end in .npz; one that is there is replaced.
        time: time code of the shape; None: what is there without a time, or else the first sample.

    Returns:
        How many curves there are.

    Raises:
        ModuleNotFoundError: usd-core is not installed.
        ValueError: the file cannot be read, has no curves, or some that do not go through their vertices.
    """
    Usd, UsdGeom, Tf = _library()
    try:
        stage = Usd.Stage.Open(str(path))
        parts = _parts(path, stage, time)
    except Tf.ErrorException as error:
        # The first of USD's errors is the cause, and the others follow from it.
        reason = error.args[0].commentary.strip() if os.path.exists(path) else "there is no such file"
        raise ValueError(f"{path}: expected a USD file: {reason}") from None
    arrays: dict[str, Any] = {
        "points": np.concatenate([part["points"] for part in parts.values()]),
        "offsets": np.concatenate([[0], np.cumsum(np.concatenate([part["counts"] for part in parts.values()]))]),
        "meters_per_unit": np.array(UsdGeom.GetStageMetersPerUnit(stage)),
    }
    if UsdGeom.GetStageUpAxis(stage) == UsdGeom.Tokens.z:
        x, y, z = arrays["points"].T
        arrays["points"] = np.stack([x, z, -y], axis=1)
    for name, called in {"radius": ("widths",), **_NAMES}.items():
        without = [prim for prim, part in parts.items() if name not in part]
        if not without:
            arrays[name] = np.concatenate([part[name] for part in parts.values()])
        elif len(without) < len(parts):
            what = " or ".join(called)
            warnings.warn(f"{path}: {_listed(without)} has no {what}, which is left out of the other prims too", stacklevel=2)
    if "ids" in arrays:
        arrays["ids"] = _unique(path, arrays["ids"])
    # NumPy appends .npz to a name that ends otherwise, and not to a file.
    with open(out, "wb") as file:
        np.savez(file, **arrays)
    return len(arrays["offsets"]) - 1


def _library() -> tuple[ModuleType, ModuleType, ModuleType]:
    """USD's own modules, which have no types."""
    return import_module("pxr.Usd"), import_module("pxr.UsdGeom"), import_module("pxr.Tf")


def _parts(path: Any, stage: Any, time: float | None) -> dict[str, dict[str, NDArray[Any]]]:
    """What each prim of curves has, those of instances too, by its path; prims without points are left out, and a warning names them."""
    Usd, UsdGeom, _ = _library()
    prims = stage.Traverse(Usd.TraverseInstanceProxies())
    found = [UsdGeom.BasisCurves(prim) for prim in prims if prim.IsA(UsdGeom.BasisCurves)]
    if not found:
        raise ValueError(f"{path}: expected BasisCurves, found none")
    try:
        parts = {str(curves.GetPath()): _curves(curves, time) for curves in found}
    except ValueError as error:
        raise ValueError(f"{path}: {error}") from None
    empty = [prim for prim, part in parts.items() if part is None]
    if len(empty) == len(found):
        raise ValueError(f"{path}: expected BasisCurves with points, found none in {_listed(empty)}")
    if empty:
        warnings.warn(f"{path}: {_listed(empty)} has no points, and is left out", stacklevel=3)
    return {prim: part for prim, part in parts.items() if part is not None}


def _listed(names: list[str]) -> str:
    """The first of the names, and how many more there are."""
    more = len(names) - _MOST_NAMES
    return ", ".join(names[:_MOST_NAMES]) + (f" and {more} more" if more > 0 else "")


def _unique(path: Any, ids: NDArray[Any]) -> NDArray[Any]:
    """The ids, with new ones above all others where a curve has one that a curve before it has."""
    _, first = np.unique(ids, return_index=True)
    if len(first) == len(ids):
        return ids
    again = np.ones(len(ids), dtype=bool)
    again[first] = False
    unique = ids.astype(np.int64)
    unique[again] = unique.max() + 1 + np.arange(again.sum())
    warnings.warn(
        f"{path}: {again.sum()} of {len(ids)} curves have the groom_id of a curve before them, and get ids from {unique[again][0]} on",
        stacklevel=3,
    )
    return unique


def _curves(curves: Any, time: float | None) -> dict[str, NDArray[Any]] | None:
    """Points and what else a prim has, each curve by its points on it, in the world; None without points."""
    Usd, UsdGeom, _ = _library()
    path = curves.GetPath()
    code = Usd.TimeCode.EarliestTime() if time is None else Usd.TimeCode(time)
    given = [attribute.Get(code) for attribute in (curves.GetCurveVertexCountsAttr(), curves.GetPointsAttr())]
    if any(values is None or len(values) == 0 for values in given):
        return None
    counts = np.array(given[0], dtype=np.int64)
    points = np.array(given[1], dtype=np.float64).reshape(-1, 3)
    if counts.min() < 0:
        raise ValueError(f"{path}: expected curves of 0 or more points, found one of {counts.min()}")
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
