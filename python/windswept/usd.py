"""Grooms from USD files, by USD's own library: `pip install usd-core` (CPython 3.11 or later).

    ws.usd.to_npz("groom.usdc", "groom.npz")
    groom = ws.Groom.load("groom.npz", strands=2000)
    ws.usd.mesh_to_npz("body.usdc", "body.npz")    # a mesh that deforms, for body.frames

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

from ._curves import Weights, b_spline, bezier, bezier_of_hermite, nurbs, varying
from ._curves import vertices as through
from .meshes import write_frames

__all__ = ["mesh_to_npz", "to_npz"]

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

    All BasisCurves, HermiteCurves and NurbsCurves of the stage are taken, those of instances and of point instancers too, where they
    are in the world. Strands go through the vertices of linear and Catmull-Rom curves; B-splines are evaluated at their knots, Bézier and
    Hermite curves at thirds of their segments, NURBS evenly in their parameter. Curves keep the order of the stage; `groom_id`,
    `groom_group_id`, `groom_root_uv` and `groom_guide`, of the prim or inherited, become ids, groups, root_uv and guides, where every
    prim has them; curves with the purpose "guide" are guides beside others. The unit comes along, and what is up becomes +Y. A
    `UserWarning` names prims that are left out, with the reason: without points, invisible, periodic, the stand-ins of purpose "proxy".
    It says which of these and of the widths are left out since their numbers are not one for each curve or since only some prims have
    them, and says how many curves have an id that a curve before them has: those get new ids.

    usd-core reads the file, and a damaged .usdc can cost it much memory and time: one of 1 kB took 7 GB and 8 s to be refused.

    Args:
        path: the file: .usd, .usda, .usdc or .usdz.
        out: the groom file, whose name should end in .npz; one that is there is replaced.
        time: time code of the shape; None: the first sample of what has samples, and else what is there without a time.

    Returns:
        How many curves there are.

    Raises:
        ModuleNotFoundError: usd-core is not installed.
        ValueError: the file cannot be read, has no curves that can be taken, some of an unknown kind, or some of a number of vertices that
            curves of their kind cannot have.
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


def mesh_to_npz(path: str | PathLike[str], out: str | PathLike[str], prim: str | None = None) -> int:
    """Writes the poses of a mesh of a USD file for `body.frames`: one for each time sample of its points or of where it is.

    Polygons are cut into fans of triangles, points are where they are in the world, and time codes become seconds from the first on.
    The unit comes along, and what is up becomes +Y.

    Args:
        path: the file: .usd, .usda, .usdc or .usdz.
        out: the file, whose name ends in .npz; one that is there is replaced.
        prim: path of the mesh in the stage; None: the only one.

    Returns:
        How many poses there are.

    Raises:
        ModuleNotFoundError: usd-core is not installed.
        ValueError: the file cannot be read, has no such mesh or several, or the number of the mesh's points changes.
    """
    Usd, UsdGeom, _ = _library()
    with _errors_of_usd(path):
        stage = Usd.Stage.Open(str(path))
        meshes = [own for own in stage.Traverse() if own.IsA(UsdGeom.Mesh) and prim in (None, str(own.GetPath()))]
        if len(meshes) != 1:
            found = [str(own.GetPath()) for own in stage.Traverse() if own.IsA(UsdGeom.Mesh)]
            wanted = "one mesh, or prim" if prim is None else f"a mesh {prim}"
            raise ValueError(f"{path}: expected {wanted}, found {_listed(found) if found else 'no mesh'}")
        mesh = UsdGeom.Mesh(meshes[0])
        codes = {*mesh.GetPointsAttr().GetTimeSamples()}
        own = meshes[0]
        while own:
            if own.IsA(UsdGeom.Xformable):
                codes |= {*UsdGeom.Xformable(own).GetTimeSamples()}
            own = own.GetParent()
        samples = sorted(codes) or [Usd.TimeCode.Default()]
        poses = []
        for code in samples:
            points = np.asarray(mesh.GetPointsAttr().Get(code), dtype=np.float64).reshape(-1, 3)
            place = np.asarray(UsdGeom.Xformable(meshes[0]).ComputeLocalToWorldTransform(code), dtype=np.float64)
            poses.append(points @ place[:3, :3] + place[3, :3])
        counts = np.asarray(mesh.GetFaceVertexCountsAttr().Get(samples[0]), dtype=np.int64)
        indices = np.asarray(mesh.GetFaceVertexIndicesAttr().Get(samples[0]), dtype=np.int64)
        left = mesh.GetOrientationAttr().Get() == UsdGeom.Tokens.leftHanded
        rate = stage.GetTimeCodesPerSecond()
        unit = UsdGeom.GetStageMetersPerUnit(stage)
        z_up = UsdGeom.GetStageUpAxis(stage) == UsdGeom.Tokens.z
    if len({len(points) for points in poses}) != 1:
        raise ValueError(f"{path}: {meshes[0].GetPath()} has {sorted({len(points) for points in poses})} points: expected one number")
    places = np.stack(poses)
    if z_up:
        places = np.stack([places[..., 0], places[..., 2], -places[..., 1]], axis=-1)
    starts = np.cumsum(counts) - counts
    fans = [(first, first + k, first + k + 1) for first, count in zip(starts, counts, strict=True) for k in range(1, count - 1)]
    triangles = indices[np.array(fans, dtype=np.int64).reshape(-1, 3)]
    if left:
        triangles = triangles[:, ::-1]
    times = [(float(code) - float(samples[0])) / rate for code in samples] if codes else [0.0]
    write_frames(out, places, triangles, times, unit)
    return len(poses)


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

    Prims that have nothing to take are left out, and a warning names them.
    """
    Usd, _, _ = _library()
    code = Usd.TimeCode.EarliestTime() if time is None else Usd.TimeCode(time)
    parts: dict[str, dict[str, NDArray[Any]]] = {}
    purposes: dict[str, str] = {}
    out: dict[str, list[str]] = {}
    untaken: dict[str, list[str]] = {}
    for prim, curves, matrix in _placed(stage.GetPseudoRoot(), np.identity(4), code, ""):
        part, reasons = _curves(f"{path}: {prim}", curves, matrix, code)
        if isinstance(part, str):
            out.setdefault(part, []).append(prim)
            continue
        parts[prim], purposes[prim] = part, str(curves.ComputePurpose())
        for primvar, reason in reasons.items():
            untaken.setdefault(primvar, []).append(f"{prim} ({reason})")
    stand_ins = [prim for prim, purpose in purposes.items() if purpose == "proxy"]
    if 0 < len(stand_ins) < len(parts):
        out["is a stand-in, of purpose proxy"] = stand_ins
        parts = {prim: part for prim, part in parts.items() if prim not in stand_ins}
    if not parts:
        found = "; ".join(f"{_listed(prims)} {reason}" for reason, prims in out.items())
        raise ValueError(f"{path}: expected curves with points, found none{': ' if found else ''}{found}")
    for reason, prims in out.items():
        warnings.warn(f"{path}: {_listed(prims)} {reason}, and is left out", stacklevel=3)
    guides = [prim for prim in parts if purposes[prim] == "guide"]
    if 0 < len(guides) < len(parts):
        for prim, part in parts.items():
            part.setdefault("guides", np.full(len(part["counts"]), prim in guides))
    return parts, untaken


def _placed(root: Any, world: NDArray[np.float64], code: Any, name: str) -> Iterator[tuple[str, Any, NDArray[np.float64]]]:
    """Prims of curves at and below a prim, with a name and the matrix from each one's own place to the world.

    `world` is the matrix from the place of `root` to the world, and `name` that of the instances that it is in.
    """
    Usd, UsdGeom, _ = _library()
    cache = UsdGeom.XformCache(code)
    prims = iter(Usd.PrimRange(root, Usd.TraverseInstanceProxies()))
    for prim in prims:
        # Rows are points: a matrix stands on the right, and what comes first stands first.
        here = np.array(cache.ComputeRelativeTransform(prim, root)[0]) @ world
        if prim.IsA(UsdGeom.PointInstancer):
            # Prototypes below it are there as its instances only.
            prims.PruneChildren()
            yield from _instances(UsdGeom.PointInstancer(prim), here, code, name)
            continue
        for kind in (UsdGeom.BasisCurves, UsdGeom.HermiteCurves, UsdGeom.NurbsCurves):
            if prim.IsA(kind):
                yield name + str(prim.GetPath()), kind(prim), here


def _instances(instancer: Any, world: NDArray[np.float64], code: Any, name: str) -> Iterator[tuple[str, Any, NDArray[np.float64]]]:
    """Prims of curves of all instances that an instancer shows, with a name and a matrix as those of `_placed`."""
    prototypes = instancer.GetPrototypesRel().GetForwardedTargets()
    which = _values(instancer.GetProtoIndicesAttr(), instancer.GetProtoIndicesAttr().Get(code))
    # With the transform of each prototype; without the instances that are masked.
    transforms = instancer.ComputeInstanceTransformsAtTime(code, code, applyMask=instancer.IgnoreMask) if len(which) else []
    shown = instancer.ComputeMaskAtTime(code) or [True] * len(which)
    for i, (prototype, transform) in enumerate(zip(which, transforms)):
        if shown[i] and 0 <= prototype < len(prototypes):
            prim = instancer.GetPrim().GetStage().GetPrimAtPath(prototypes[int(prototype)])
            if prim:
                yield from _placed(prim, np.array(transform) @ world, code, f"{name}{instancer.GetPath()}[{i}]")


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


def _curves(
    where: str, curves: Any, matrix: NDArray[np.float64], code: Any
) -> tuple[dict[str, NDArray[Any]] | str, dict[str, str]]:
    """What a prim has, or why it has nothing to take, and by the name of a primvar why that is not taken.

    It has points, each curve by its points on it, in the world, and what else is one for each curve or point. `where` names file and
    prim for an error.
    """
    given, placed = curves.GetCurveVertexCountsAttr(), curves.GetPointsAttr()
    counts, points = _values(given, given.Get(code)), _values(placed, placed.Get(code))
    if curves.ComputeVisibility(code) == "invisible":
        return "is invisible", {}
    if len(counts) == 0 or len(points) == 0:
        return "has no points", {}
    if counts.dtype.kind not in "iu" or counts.ndim != 1:
        raise ValueError(f"{where}: curveVertexCounts: expected int[], found {_described(given, counts)}")
    if points.dtype.kind != "f" or points.shape[1:] != (3,):
        raise ValueError(f"{where}: points: expected point3f[], found {_described(placed, points)}")
    counts, points = counts.astype(np.int64), points.astype(np.float64)
    if counts.sum() != len(points):
        raise ValueError(f"{where}: {len(points)} points are not the {counts.sum()} of its curves")
    found_on = _on_curves(where, curves, points, counts, code)
    if found_on is None:
        return "is periodic", {}
    on, vertices, ends = found_on
    found = {"points": on.of(vertices) @ matrix[:3, :3] + matrix[3, :3], "counts": on.counts}
    untaken: dict[str, str] = {}
    api = _library()[1].PrimvarsAPI(curves)

    def values_of(name: str) -> tuple[Any, NDArray[Any]]:
        primvar = api.FindPrimvarWithInheritance(name)
        return primvar, _values(primvar, primvar.ComputeFlattened(code)) if primvar.HasValue() else np.empty(0)

    attribute, widths = values_of("widths")
    if not len(widths):
        attribute = curves.GetWidthsAttr()
        widths = _values(attribute, attribute.Get(code))
    between = varying(on.counts, ends)
    # By how many widths there are: one for each vertex, each end of a segment, each curve, or all.
    spread: dict[int, Any] = {
        1: lambda: np.full(on.counts.sum(), widths[0]),
        len(counts): lambda: np.repeat(widths, on.counts),
        int(ends.sum()): lambda: between.of(widths),
        len(points): lambda: on.of(widths) if len(vertices) == len(points) else between.of(widths),
    }
    if widths.ndim == 1 and widths.dtype.kind in _NUMBERS and len(widths) in spread:
        scale = abs(np.linalg.det(matrix[:3, :3])) ** (1 / 3)
        found["radius"] = 0.5 * scale * spread[len(widths)]().astype(np.float64)
    elif len(widths):
        expected = f"{len(points)}, {ends.sum()}, {len(counts)} or 1 numbers, for each point, each end of a segment, each curve or all"
        untaken["widths"] = f"expected {expected}, found {_described(attribute, widths)}"
    for name, primvars in _NAMES.items():
        for primvar, values in map(values_of, primvars):
            if name in found or not len(values):
                continue
            shape = (len(counts), 2) if name == "root_uv" else (len(counts),)
            # One for all, as those are that come from a prim above.
            if name != "ids" and len(values) == 1 and values.dtype.kind in _NUMBERS:
                values = np.repeat(values, len(counts), axis=0)
            if values.shape == shape and values.dtype.kind in _NUMBERS:
                found[name] = values
                continue
            expected = f"{len(counts)} {'pairs of numbers' if len(shape) == 2 else 'numbers'}, one for each curve"
            untaken[str(primvar.GetPrimvarName())] = f"expected {expected}, found {_described(primvar, values)}"
    return found, untaken


def _on_curves(
    where: str, curves: Any, points: NDArray[np.float64], counts: NDArray[np.int64], code: Any
) -> tuple[Weights, NDArray[np.float64], NDArray[np.int64]] | None:
    """Points on the curves of a prim, of which vertices they are weighted sums, and how many ends of segments each curve has.

    None for curves without ends. The numbers of vertices that a curve can have are those of USD's schemas.
    """

    def check(wrong: NDArray[np.bool_], expected: str) -> None:
        if (curve := np.flatnonzero(wrong | (counts < 0))).size:
            raise ValueError(f"{where}: curve {curve[0]}, counted from 0: expected {expected}, found {counts[curve[0]]}")

    _, UsdGeom, _ = _library()
    if isinstance(curves, UsdGeom.NurbsCurves):
        return _on_nurbs(where, curves, points, counts, code, check)
    if isinstance(curves, UsdGeom.HermiteCurves):
        check(counts < 0, "a number of vertices")
        tangents = _values(curves.GetTangentsAttr(), curves.GetTangentsAttr().Get(code))
        if tangents.shape != points.shape:
            raise ValueError(f"{where}: tangents: expected {len(points)}, as many as points, found {len(tangents)}")
        vertices, their = bezier_of_hermite(points, tangents.astype(np.float64), counts)
        return bezier(their), vertices, counts
    kind, basis, wrap = (attribute.Get() for attribute in (curves.GetTypeAttr(), curves.GetBasisAttr(), curves.GetWrapAttr()))
    if wrap == "periodic":
        return None
    pinned = wrap == "pinned"
    if kind == "linear":
        check(counts < 0, "a number of vertices")
        return through(counts), points, counts
    if kind != "cubic" or basis not in ("bezier", "bspline", "catmullRom") or wrap not in ("nonperiodic", "pinned"):
        raise ValueError(f"{where}: expected curves that USD knows, found {kind} {basis} that is {wrap}")
    if basis == "bezier":
        # A curve of one vertex or none is a strand that cannot be simulated: the groom leaves it out, and says so.
        check((counts > 1) & (counts % 3 != 1), "3 k + 1 vertices (4, 7, 10 and so on) of a Bézier curve")
        return bezier(counts), points, np.where(counts > 1, (counts - 1) // 3 + 1, counts)
    check(counts < 0, "a number of vertices")
    on = b_spline(counts, pinned) if basis == "bspline" else through(counts, without_ends=not pinned)
    return on, points, on.counts


def _on_nurbs(
    where: str, curves: Any, points: NDArray[np.float64], counts: NDArray[np.int64], code: Any, check: Any
) -> tuple[Weights, NDArray[np.float64], NDArray[np.int64]]:
    """As `_on_curves`, of NURBS."""
    given = [curves.GetOrderAttr(), curves.GetKnotsAttr(), curves.GetPointWeightsAttr()]
    orders, knots, rational = (_values(attribute, attribute.Get(code)) for attribute in given)
    orders = np.broadcast_to(orders.astype(np.int64), len(counts)) if len(orders) in (1, len(counts)) else np.zeros(len(counts), np.int64)
    check((orders < 2) | (counts < orders), "an order of 2 or more and at least as many vertices")
    expected = int((counts + orders).sum())
    if len(knots) != expected or (np.diff(knots) < 0).sum() > len(counts) - 1:
        raise ValueError(f"{where}: knots: expected {expected} numbers that rise along each curve, found {len(knots)}")
    if len(rational) not in (0, len(points)):
        raise ValueError(f"{where}: pointWeights: expected {len(points)}, as many as points, found {len(rational)}")
    rational = rational.astype(np.float64) if len(rational) else np.ones(len(points))
    return nurbs(counts, orders, knots.astype(np.float64), rational), points, counts - orders + 2


def _values(attribute: Any, value: Any) -> NDArray[Any]:
    """What USD gave for an attribute or a primvar, as an array with a row for each value; one without rows where that is nothing."""
    if value is None:
        return np.empty(0)
    return np.atleast_1d(np.array(value if attribute.GetTypeName().isArray else [value]))


def _described(attribute: Any, values: NDArray[Any]) -> str:
    """How many values there are, and of which type the file says that they are."""
    return f"{len(values)} of type {attribute.GetTypeName()}"
