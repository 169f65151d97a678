"""Meshes of a Blender scene as bodies: a file of the mesh and keyframes where it is rigid, a file of all its poses otherwise."""

import re

import numpy as np
from mathutils import Matrix

from .axes import placed, read, rounded
from .error import Unfit

#: Largest distance of a point of a rigid mesh from where its motion has it, in parts of its size: Blender's numbers are float32.
RIGID = 2e-5


def mesh_now(body, graph, unit):
    """Points `(n, 3)` [m] in the world, Y up, and triangles `(m, 3)` of a mesh object with its modifiers."""
    evaluated = body.evaluated_get(graph)
    mesh = evaluated.to_mesh()
    try:
        mesh.calc_loop_triangles()
        points = placed(read(mesh.vertices, "co", 3), evaluated.matrix_world, unit)
        triangles = read(mesh.loop_triangles, "vertices", 3, np.int32)
    finally:
        evaluated.to_mesh_clear()
    if not len(triangles):
        raise Unfit(f"{body.name}: has no faces; expected a mesh that encloses a solid")
    # A mirrored object has its faces the wrong way round.
    return points, triangles[:, ::-1] if evaluated.matrix_world.determinant() < 0 else triangles


class Poses:
    """A mesh object, frame by frame."""

    def __init__(self, body):
        self.body = body
        #: As scenes name it: dotted keys have no blanks and dots within a name.
        self.name = re.sub(r"[^\w-]", "_", body.name)
        self.positions = []
        self.triangles = None

    def add(self, graph, unit):
        points, triangles = mesh_now(self.body, graph, unit)
        if self.triangles is None:
            self.triangles = triangles
        elif not np.array_equal(triangles, self.triangles):
            raise Unfit(
                f"{self.body.name}: its faces change with the frame, which no body can; switch off the modifier that makes or joins them"
            )
        self.positions.append(points)

    def moves(self):
        start = self.positions[0]
        return any(np.abs(now - start).max() > RIGID * extent(start) for now in self.positions)

    def written(self, folder, times):
        """The `[[body]]`, whose file is in the folder, and the origin of that file in the first frame [m].

        A rigid mesh has its middle as origin, so that it turns about that and the air which follows it stays with it.
        """
        import windswept as ws

        positions = np.stack(self.positions if self.moves() else self.positions[:1])
        motion = rigid_motion(positions, times)
        if motion is None:
            path = folder / f"{self.name}.npz"
            ws.write_frames(path, positions, self.triangles, times, meters_per_unit=1.0)
            return ws.Body(name=self.name, shape=ws.MeshFile(frames=str(path))), np.zeros(3)
        path, origin = folder / f"{self.name}.obj", motion[0].translation
        ws.write_mesh(path, positions[0] - origin, self.triangles)
        return ws.Body(name=self.name, shape=ws.MeshFile(file=str(path), scale=1.0), motion=motion), origin


def extent(points):
    return np.ptp(points, axis=0).max()


def rigid_motion(positions, times):
    """Keyframes of the first of the poses `(T, n, 3)`, about its middle; None where the others are no such motions of it.

    The rotation is the nearest one, by Kabsch's method.
    """
    import windswept as ws

    start, middles = positions[0], positions.mean(axis=1)
    u, _, vt = np.linalg.svd(np.einsum("tni,nj->tij", positions - middles[:, None], start - middles[0]))
    u[:, :, 2] *= np.linalg.det(u @ vt)[:, None]
    turns = u @ vt
    off = np.einsum("tij,nj->tni", turns, start - middles[0]) + middles[:, None] - positions
    if np.abs(off).max() > RIGID * extent(start):
        return None
    poses = zip(times, rounded(middles), rounded(rotation_vectors(turns)))
    return [ws.Keyframe(time=t, translation=s, rotation=r) for t, s, r in poses]


def rotation_vectors(turns):
    """Rotation vectors of matrices `(T, 3, 3)`, each the nearest to the one before: a spin goes on beyond a turn."""
    before, vectors = np.zeros(3), []
    for turn in turns:
        axis, angle = Matrix(turn).to_quaternion().to_axis_angle()
        axis = np.array(axis)
        if angle < 1e-6 and before.any():
            axis = before / np.linalg.norm(before)
        whole_turns = np.round((before @ axis - angle) / (2 * np.pi))
        before = axis * (angle + 2 * np.pi * whole_turns)
        vectors.append(before)
    return vectors
