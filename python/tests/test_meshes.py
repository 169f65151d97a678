"""Mesh files from arrays."""

import numpy as np
import pytest

import windswept as ws

#: A cube of 40 mm, in millimetres: corners, and two triangles a face, the lowest face last.
POINTS = 20.0 * np.array([[x, y, z] for z in (-1, 1) for y in (-1, 1) for x in (-1, 1)])
TRIANGLES = np.array(
    [[0, 2, 1], [1, 2, 3], [4, 5, 6], [5, 7, 6], [0, 4, 2], [2, 4, 6], [1, 3, 5], [3, 7, 5], [2, 6, 3], [3, 6, 7], [0, 1, 4], [1, 5, 4]]
)
SCENE = """
time = { step = 1e-3, duration = 0.01 }
interaction.model = "none"
hair = { strands = 200, points = 4, length = 0.01, roots = { shape = "mesh", body = "cube", group = "top" } }
body = [{ name = "cube", shape = "mesh", file = "FILE", scale = 1e-3, resolution = 2e-3 }]
"""


def test_a_scene_reads_what_arrays_gave(tmp_path):
    """Hair grows on the group that was said, and nowhere else."""
    file = tmp_path / "cube.obj"
    ws.write_mesh(file, POINTS, TRIANGLES, groups={"top": [8, 9], "bottom": [10, 11]})
    sim = ws.Simulation(ws.Scene.parse(SCENE.replace("FILE", file.as_posix())))
    roots = sim.hair.positions.reshape(-1, 4, 3)[:, 0]
    assert np.abs(roots[:, 1] - 0.02).max() < 1e-6
    assert np.abs(roots[:, [0, 2]]).max() <= 0.02


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("cube.stl", POINTS, TRIANGLES), "ends in .obj"),
        (("cube.obj", POINTS[:, :2], TRIANGLES), r"points: .*\(8, 2\)"),
        (("cube.obj", POINTS * np.nan, TRIANGLES), "points: expected finite"),
        (("cube.obj", POINTS, TRIANGLES.astype(float)), "triangles: expected whole numbers"),
        (("cube.obj", POINTS, TRIANGLES + 1), "triangles: expected indices from 0 to 7, found 1 to 8"),
        (("cube.obj", POINTS, TRIANGLES, {"a b": [0]}), "names without blanks"),
        (("cube.obj", POINTS, TRIANGLES, {"a": [12]}), "a: expected indices from 0 to 11"),
        (("cube.obj", POINTS, TRIANGLES, {"a": [1], "b": [0, 1]}), "a triangle of b is in a too"),
    ],
)
def test_other_arrays_are_refused(tmp_path, arguments, words):
    """An error names the argument, and no file is begun."""
    file, *rest = arguments
    with pytest.raises(ValueError, match=words):
        ws.write_mesh(tmp_path / file, *rest)
    assert not list(tmp_path.iterdir())
