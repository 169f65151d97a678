"""Mesh files from arrays: what a scene's body of `shape = "mesh"` is read from.

    ws.write_mesh("head.obj", points, triangles, groups={"scalp": range(400)})
    scene = ws.Scene.load("scene.toml").replace(**{"body.file": "head.obj"})
    ws.write_frames("head.npz", poses, triangles, times)    # of a mesh that deforms, for body.frames
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from os import PathLike

    from numpy.typing import ArrayLike

__all__ = ["write_frames", "write_mesh"]


def write_mesh(
    path: str | PathLike[str],
    points: ArrayLike,
    triangles: ArrayLike,
    groups: Mapping[str, Sequence[int]] | None = None,
) -> None:
    """Writes triangles to a Wavefront file, for `body.file` of a scene; a file that is there is replaced.

    A scene is text, so that its meshes are files: runs, pictures and other processes read them again.

    Args:
        path: the file; its name ends in .obj.
        points: `(n, 3)` numbers, in the unit that `body.scale` says the metres of: 1 for metres.
        triangles: `(m, 3)` whole numbers, the indices of each triangle's corners, counter-clockwise as seen from outside.
        groups: indices of triangles by the name of their group, for `hair.roots.group`; others are in none.

    Raises:
        ValueError: arrays of other shapes, a number that is not finite, an index that is not there, a triangle in two groups, a
            name with blanks, a file name that ends otherwise.
    """
    if not str(path).lower().endswith(".obj"):
        raise ValueError(f"path: expected a name that ends in .obj, found {path}")
    import numpy as np

    places = np.asarray(points, dtype=np.float64)
    corners = np.asarray(triangles)
    if places.ndim != 2 or places.shape[1] != 3 or not np.isfinite(places).all():
        raise ValueError(f"points: expected finite numbers of shape (n, 3), found shape {places.shape}")
    if corners.ndim != 2 or corners.shape[1] != 3 or not np.issubdtype(corners.dtype, np.integer):
        raise ValueError(f"triangles: expected whole numbers of shape (m, 3), found {corners.dtype} of shape {corners.shape}")
    if corners.size and not (0 <= corners.min() and corners.max() < len(places)):
        raise ValueError(f"triangles: expected indices from 0 to {len(places) - 1}, found {corners.min()} to {corners.max()}")
    group = np.full(len(corners), -1)
    names = list(groups or {})
    for number, name in enumerate(names):
        if not name or name.split() != [name]:
            raise ValueError(f"groups: expected names without blanks, found {name!r}")
        own = np.asarray((groups or {})[name], dtype=np.int64)
        if own.size and not (0 <= own.min() and own.max() < len(corners)):
            raise ValueError(f"groups: {name}: expected indices from 0 to {len(corners) - 1}, found {own.min()} to {own.max()}")
        if (group[own] >= 0).any():
            raise ValueError(f"groups: a triangle of {name} is in {names[group[own].max()]} too")
        group[own] = number
    with open(path, "w", encoding="utf-8") as file:
        for x, y, z in places.tolist():
            file.write(f"v {x!r} {y!r} {z!r}\n")
        for number in range(-1, len(names)):
            own = corners[group == number]
            if number >= 0 and len(own):
                file.write(f"g {names[number]}\n")
            for a, b, c in (own + 1).tolist():
                file.write(f"f {a} {b} {c}\n")


def write_frames(
    path: str | PathLike[str],
    positions: ArrayLike,
    triangles: ArrayLike,
    times: ArrayLike,
    meters_per_unit: float | None = None,
) -> None:
    """Writes the poses of a mesh that deforms, for `body.frames` of a scene; a file that is there is replaced.

    Args:
        path: the file; its name ends in .npz.
        positions: `(T, n, 3)` numbers, where the points are in each pose.
        triangles: `(m, 3)` whole numbers, the indices of each triangle's corners, counter-clockwise as seen from outside.
        times: `(T,)` numbers that rise, when the mesh is in each pose [s].
        meters_per_unit: metres per unit of the positions; None: `body.scale` says them.

    Raises:
        ValueError: arrays of other shapes, a number that is not finite, an index that is not there, times that do not rise, a file
            name that ends otherwise.
    """
    if not str(path).lower().endswith(".npz"):
        raise ValueError(f"path: expected a name that ends in .npz, found {path}")
    import numpy as np

    try:
        places = np.asarray(positions, dtype=np.float64)
    except ValueError as error:
        raise ValueError(f"positions: expected an array of shape (T, n, 3): {error}") from None
    corners, moments = np.asarray(triangles), np.asarray(times, dtype=np.float64)
    if places.ndim != 3 or places.shape[2] != 3 or not np.isfinite(places).all():
        raise ValueError(f"positions: expected finite numbers of shape (T, n, 3), found shape {places.shape}")
    if corners.ndim != 2 or corners.shape[1] != 3 or not np.issubdtype(corners.dtype, np.integer):
        raise ValueError(f"triangles: expected whole numbers of shape (m, 3), found {corners.dtype} of shape {corners.shape}")
    if corners.size and not (0 <= corners.min() and corners.max() < places.shape[1]):
        most = places.shape[1] - 1
        raise ValueError(f"triangles: expected indices from 0 to {most}, found {corners.min()} to {corners.max()}")
    if moments.shape != places.shape[:1] or not np.isfinite(moments).all() or (np.diff(moments) <= 0).any():
        raise ValueError(f"times: expected {len(places)} finite numbers that rise, found {moments.tolist()[:8]}")
    arrays: dict[str, Any] = {"positions": places, "triangles": corners.astype(np.int64), "times": moments}
    if meters_per_unit is not None:
        arrays["meters_per_unit"] = np.array(float(meters_per_unit))
    np.savez(path, **arrays)
