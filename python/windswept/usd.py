"""Grooms from USD files, by USD's own library: `pip install usd-core` (CPython 3.11 or later).

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
from collections.abc import Iterator
from contextlib import contextmanager
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

#: The kinds of NumPy that are numbers: truth values, whole numbers with and without a sign, and real numbers.
_NUMBERS = "biuf"

#: How many prims a message names at most.
_MOST_NAMES = 5


def to_npz(path: str | PathLike[str], out: str | PathLike[str], time: float | None = None) -> int:
    """Writes the curves of a USD file as arrays of a groom file, which `hair.file` and `Groom.load` read.

    All BasisCurves of the stage are taken, those of instances too, where they are in the world: curves that go through their
    vertices ("linear", or "catmullRom" that is pinned), and Bézier curves by their points on the curve. Curves keep the order of
    the stage; `groom_id`, `groom_group_id`, `groom_root_uv` and `groom_guide` become ids, groups, root_uv and guides, where every
    prim has them. The unit comes along, and what is up becomes +Y. A `UserWarning` names prims without points, which are left
    out, says which of these and of the widths are left out since their numbers are not one for each curve or since only some prims have
    them, and says how many curves have an id that a curve before them has: those get new ids.

    usd-core reads the file, and a damaged .usdc can cost it much memory and time: one of 1 kB took 7 GB and 8 s to be refused.

    Args:
        path: the file: .usd, .usda, .usdc or .usdz.
        out: the groom file, whose name should end in .npz; one that is there is replaced.
        time: time code of the shape; None: what is there without a time, or else the first sample.

    Returns:
        How many curves there are.

    Raises:
        ModuleNotFoundError: usd-core is not installed.
        ValueError: the file cannot be read, has no curves, some that do not go through their vertices, or some of a number of vertices
            that curves of their kind cannot have.
    """
    Usd, UsdGeom, _ = _library()
    with _errors_of_usd(path):
        stage = Usd.Stage.Open(str(path))
        parts, untaken = _parts(path, stage, time)
        unit = np.array(UsdGeom.GetStageMetersPerUnit(stage))
        z_up = UsdGeom.GetStageUpAxis(stage) == UsdGeom.Tokens.z
    for primvar, prims in untaken.items():
        warnings.warn(f"{path}: {primvar} is not taken from {_listed(prims)}", stacklevel=2)
    arrays: dict[str, Any] = {
        "points": np.concatenate([part["points"] for part in parts.values()]),
        "offsets": np.concatenate([[0], np.cumsum(np.concatenate([part["counts"] for part in parts.values()]))]),
        "meters_per_unit": unit,
    }
    if z_up:
        x, y, z = arrays["points"].T
        arrays["points"] = np.stack([x, z, -y], axis=1)
    for name, called in {"radius": ("widths",), **_NAMES}.items():
        without = [prim for prim, part in parts.items() if name not in part]
        if not without:
            arrays[name] = np.concatenate([part[name] for part in parts.values()])
        elif len(without) < len(parts):
            what = " or ".join(called)
            warnings.warn(f"{path}: {_listed(without)} has no usable {what}, which is left out of the other prims too", stacklevel=2)
    if "ids" in arrays:
        arrays["ids"] = _unique(path, arrays["ids"])
    # NumPy appends .npz to a name that ends otherwise, and not to a file.
    with open(out, "wb") as file:
        np.savez(file, **arrays)
    return len(arrays["offsets"]) - 1


def _library() -> tuple[ModuleType, ModuleType, ModuleType]:
    """USD's own modules, which have no types."""
    return import_module("pxr.Usd"), import_module("pxr.UsdGeom"), import_module("pxr.Tf")


@contextmanager
def _errors_of_usd(path: Any) -> Iterator[None]:
    """Makes a `ValueError` that names the file of an error that USD raises, and of text that is not UTF-8."""
    _, _, Tf = _library()
    try:
        yield
        return
    except Tf.ErrorException as error:
        reason = _commentary(error) if os.path.exists(path) else "there is no such file"
    except UnicodeDecodeError as error:
        reason = f"its text is not UTF-8: {error.object.decode(errors='backslashreplace')}"
    raise ValueError(f"{path}: expected a USD file: {reason}") from None


def _commentary(error: Any) -> str:
    """What USD says of the first of its errors: that is the cause, and the others follow from it."""
    try:
        return str(error.args[0].commentary).strip()
    except UnicodeDecodeError as undecoded:
        # USD quotes what it found in the file.
        return undecoded.object.decode(errors="backslashreplace").strip()


def _parts(path: Any, stage: Any, time: float | None) -> tuple[dict[str, dict[str, NDArray[Any]]], dict[str, list[str]]]:
    """What each prim of curves has, those of instances too, by its path, and from which prims a primvar is not taken, with the reason.

    Prims without points are left out, and a warning names them.
    """
    Usd, UsdGeom, _ = _library()
    prims = stage.Traverse(Usd.TraverseInstanceProxies())
    found = [UsdGeom.BasisCurves(prim) for prim in prims if prim.IsA(UsdGeom.BasisCurves)]
    if not found:
        raise ValueError(f"{path}: expected BasisCurves, found none")
    parts: dict[str, dict[str, NDArray[Any]] | None] = {}
    untaken: dict[str, list[str]] = {}
    for curves in found:
        prim = str(curves.GetPath())
        parts[prim], reasons = _curves(f"{path}: {prim}", curves, time)
        for primvar, reason in reasons.items():
            untaken.setdefault(primvar, []).append(f"{prim} ({reason})")
    empty = [prim for prim, part in parts.items() if part is None]
    if len(empty) == len(found):
        raise ValueError(f"{path}: expected BasisCurves with points, found none in {_listed(empty)}")
    if empty:
        warnings.warn(f"{path}: {_listed(empty)} has no points, and is left out", stacklevel=3)
    return {prim: part for prim, part in parts.items() if part is not None}, untaken


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


def _curves(where: str, curves: Any, time: float | None) -> tuple[dict[str, NDArray[Any]] | None, dict[str, str]]:
    """What a prim has, and by the name of a primvar why it is not taken.

    It has points, each curve by its points on it, in the world, and what else is one for each curve or point; None without points.
    `where` names file and prim for an error.
    """
    Usd, UsdGeom, _ = _library()
    code = Usd.TimeCode.EarliestTime() if time is None else Usd.TimeCode(time)
    given, placed = curves.GetCurveVertexCountsAttr(), curves.GetPointsAttr()
    counts, points = _values(given, given.Get(code)), _values(placed, placed.Get(code))
    if len(counts) == 0 or len(points) == 0:
        return None, {}
    if counts.dtype.kind not in "iu" or counts.ndim != 1:
        raise ValueError(f"{where}: curveVertexCounts: expected int[], found {_described(given, counts)}")
    if points.dtype.kind != "f" or points.shape[1:] != (3,):
        raise ValueError(f"{where}: points: expected point3f[], found {_described(placed, points)}")
    counts, points = counts.astype(np.int64), points.astype(np.float64)
    if counts.sum() != len(points):
        raise ValueError(f"{where}: {len(points)} points are not the {counts.sum()} of its curves")
    kept = _on_curves(where, curves, counts)
    matrix = np.array(UsdGeom.XformCache(code).GetLocalToWorldTransform(curves.GetPrim()))
    # Rows are points: the matrix stands on the right.
    points = points @ matrix[:3, :3] + matrix[3, :3]
    ends = np.concatenate([[0], np.cumsum(counts)])
    found = {"points": points[kept], "counts": np.array([kept[a:b].sum() for a, b in zip(ends, ends[1:])], dtype=np.int64)}
    untaken: dict[str, str] = {}
    attribute = curves.GetWidthsAttr()
    widths = _values(attribute, attribute.Get(code))
    # How many points a width is for, by how many widths there are: one for each point, each curve, or all.
    repeats: dict[int, Any] = {len(kept): 1, 1: len(kept), len(counts): counts}
    if widths.ndim == 1 and widths.dtype.kind in _NUMBERS and len(widths) in repeats:
        scale = abs(np.linalg.det(matrix[:3, :3])) ** (1 / 3)
        found["radius"] = 0.5 * scale * np.repeat(widths.astype(np.float64), repeats[len(widths)])[kept]
    elif len(widths):
        expected = f"{len(kept)}, {len(counts)} or 1 numbers, for each point, each curve or all"
        untaken["widths"] = f"expected {expected}, found {_described(attribute, widths)}"
    api = UsdGeom.PrimvarsAPI(curves)
    for name, primvars in _NAMES.items():
        for primvar in (api.GetPrimvar(each) for each in primvars):
            if name in found or not primvar.HasValue():
                continue
            values = _values(primvar, primvar.ComputeFlattened(code))
            shape = (len(counts), 2) if name == "root_uv" else (len(counts),)
            if values.shape == shape and values.dtype.kind in _NUMBERS:
                found[name] = values
                continue
            expected = f"{len(counts)} {'pairs of numbers' if len(shape) == 2 else 'numbers'}, one for each curve"
            untaken[str(primvar.GetPrimvarName())] = f"expected {expected}, found {_described(primvar, values)}"
    return found, untaken


def _on_curves(where: str, curves: Any, counts: NDArray[np.int64]) -> NDArray[np.bool_]:
    """Which vertices of a prim are points on its curves: all of curves that go through them, and every third of Bézier curves.

    The numbers of vertices that a curve can have are those of `UsdGeomBasisCurves`.
    """
    kind, basis, wrap = (attribute.Get() for attribute in (curves.GetTypeAttr(), curves.GetBasisAttr(), curves.GetWrapAttr()))
    if wrap not in ("nonperiodic", "pinned"):
        raise ValueError(f"{where}: expected curves with two ends, which are nonperiodic or pinned, found {wrap} ones")
    bezier = (kind, basis) == ("cubic", "bezier")
    if kind != "linear" and not bezier and (kind, basis, wrap) != ("cubic", "catmullRom", "pinned"):
        raise ValueError(f"{where}: expected curves through their vertices, found {kind} {basis} that is {wrap}")
    # A curve of one vertex or none is a strand that cannot be simulated: the groom leaves it out, and says so.
    wrong = np.flatnonzero((counts < 0) | (bezier & (counts > 1) & (counts % 3 != 1)))
    if len(wrong):
        expected = "3 k + 1 vertices (4, 7, 10 and so on) of a Bézier curve" if bezier else "a number of vertices"
        raise ValueError(f"{where}: curve {wrong[0]}, counted from 0: expected {expected}, found {counts[wrong[0]]}")
    if not bezier:
        return np.ones(counts.sum(), dtype=bool)
    return np.concatenate([np.arange(count) % 3 == 0 for count in counts])


def _values(attribute: Any, value: Any) -> NDArray[Any]:
    """What USD gave for an attribute or a primvar, as an array with a row for each value; one without rows where that is nothing."""
    if value is None:
        return np.empty(0)
    return np.atleast_1d(np.array(value if attribute.GetTypeName().isArray else [value]))


def _described(attribute: Any, values: NDArray[Any]) -> str:
    """How many values there are, and of which type the file says that they are."""
    return f"{len(values)} of type {attribute.GetTypeName()}"
