"""Blender opens our films, and what it exports again is the same strands.

`cargo xtask test --long` installs Blender as a Python module and names its Python by WINDSWEPT_BLENDER.
"""

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import windswept as ws

#: Opens a film, says what each frame has, and exports the film again.
PROGRAM = """
import sys, bpy, numpy as np
film, said, again = sys.argv[-3:]
bpy.ops.wm.read_factory_settings(use_empty=True)
bpy.ops.wm.usd_import(filepath=film)
(hair,) = [found for found in bpy.data.objects if found.type == "CURVES"]
scene = bpy.context.scene
shapes = []
for frame in range(scene.frame_start, scene.frame_end + 1):
    scene.frame_set(frame)
    now = hair.evaluated_get(bpy.context.evaluated_depsgraph_get())
    position = np.empty(3 * len(now.data.points), np.float32)
    now.data.attributes["position"].data.foreach_get("vector", position)
    matrix = np.array(now.matrix_world)
    shapes.append(position.reshape(-1, 3) @ matrix[:3, :3].T + matrix[:3, 3])
counts = [curve.points_length for curve in now.data.curves]
ids = np.empty(len(counts), np.int32)
now.data.attributes["groom_id"].data.foreach_get("value", ids)
np.savez(said, positions=shapes, counts=counts, ids=ids, frames=[scene.frame_start, scene.frame_end])
bpy.ops.wm.usd_export(filepath=again, export_animation=True)
"""


#: Says where in each frame hair, head and camera are, and how the camera sees the scene.
TOGETHER = """
import sys, bpy, numpy as np
film, said = sys.argv[-2:]
bpy.ops.wm.read_factory_settings(use_empty=True)
bpy.ops.wm.usd_import(filepath=film, set_frame_range=True)
of = lambda kind: next(found for found in bpy.data.objects if found.type == kind)
scene = bpy.context.scene
hair, heads, cameras = [], [], []
for frame in range(scene.frame_start, scene.frame_end + 1):
    scene.frame_set(frame)
    for kind, all in [("CURVES", hair), ("MESH", heads)]:
        now = of(kind).evaluated_get(bpy.context.evaluated_depsgraph_get())
        position = np.empty(3 * len(now.data.attributes["position"].data), np.float32)
        now.data.attributes["position"].data.foreach_get("vector", position)
        matrix = np.array(now.matrix_world)
        all.append(position.reshape(-1, 3) @ matrix[:3, :3].T + matrix[:3, 3])
    cameras.append(np.array(of("CAMERA").matrix_world))
lens = of("CAMERA").data
np.savez(said, hair=hair, heads=heads, cameras=cameras, angle=[lens.angle_x, lens.angle_y])
"""


@pytest.fixture
def blender():
    python = os.environ.get("WINDSWEPT_BLENDER")
    if python is None:
        pytest.skip("WINDSWEPT_BLENDER names no Python with Blender: cargo xtask test --long does, where it has Python 3.11")
    return python


@pytest.mark.long
@pytest.mark.parametrize(
    "film, followers",
    [("hair.usda", []), ("film.usda", []), ("film.usda", ["--followers"]), ("film.usdc", []), ("film.usdc", ["--followers"])],
)
def test_a_film_goes_through_blender(tmp_path, blender, film, followers):
    rng = np.random.default_rng(3)
    roots = rng.uniform(-0.05, 0.05, (61, 1, 3))
    points = roots + 0.01 * np.arange(7)[:, None] * [1.0, 0.2, 0.1]
    np.savez(tmp_path / "groom.npz", points=points.astype(np.float32), ids=rng.permutation(61) + 100, meters_per_unit=1.0)
    # Ten steps a frame: Blender shows whole frames only.
    (tmp_path / "scene.toml").write_text(
        "time = { step = 0.0016666666666666668, duration = 0.1, frame_rate = 60 }\n"
        'interaction.model = "none"\n[hair]\nfile = "groom.npz"\nstrands = 23\nrest = "weightless"\n'
    )
    out = tmp_path / "out"
    command = [sys.executable, "-m", "windswept"]
    done([*command, "run", tmp_path / "scene.toml", "--out", out, "--formats", "vtkhdf,usd"])
    done([*command, "export", out, "--format", "npz", *followers])
    if film != "hair.usda":
        done([*command, "export", out, "--format", {"usda": "usd", "usdc": "usdc"}[film.split(".")[1]], *followers])
    done([blender, "-c", PROGRAM, out / film, tmp_path / "said.npz", tmp_path / "again.usdc"])

    with np.load(out / "film.npz") as ours, np.load(tmp_path / "said.npz") as said:
        strands = 61 if followers else 23
        assert len(said["counts"]) == strands and said["frames"].tolist() == [0, 6]
        np.testing.assert_array_equal(said["counts"], np.diff(ours["offsets"]))
        np.testing.assert_array_equal(said["ids"], ours["ids"])
        # Blender has Z up.
        x, y, z = np.moveaxis(ours["positions"], -1, 0)
        np.testing.assert_allclose(said["positions"], np.stack([x, -z, y], axis=-1), rtol=0, atol=1e-6)
        assert np.abs(ours["positions"][-1] - ours["positions"][0]).max() > 1e-3
        for frame, positions in enumerate(ours["positions"]):
            assert ws.usd.to_npz(tmp_path / "again.usdc", tmp_path / "again.npz", time=frame) == strands
            with np.load(tmp_path / "again.npz") as again:
                np.testing.assert_array_equal(again["offsets"], ours["offsets"])
                np.testing.assert_array_equal(again["ids"], ours["ids"])
                # Strands, order and places to 1e-6, as the unit says.
                np.testing.assert_allclose(again["points"] * again["meters_per_unit"], positions, rtol=0, atol=1e-6)


@pytest.mark.long
@pytest.mark.parametrize("film, units", [("hair.usda", []), ("film.usdc", []), ("film.usdc", ["--up", "z", "--scale", "0.01"])])
def test_hair_head_and_camera_move_together(tmp_path, blender, film, units):
    radius, centre, turn = 0.03, np.array([0.01, 0.02, -0.01]), 1.2
    (tmp_path / "scene.toml").write_text(f"""
time = {{ step = 0.0016666666666666668, duration = 0.1, frame_rate = 60 }}
interaction.model = "none"
gravity = [0, 0, 0]
camera = {{ eye = [0.1, 0.2, 0.4], target = [0.0, 0.01, 0.0], fov = 40, width = 640, height = 400 }}
[hair]
body = "head"
strands = 40
points = 8
length = 0.05
roots = {{ shape = "sphere_cap", center = {centre.tolist()}, radius = {radius} }}
[[body]]
name = "head"
center = {centre.tolist()}
radius = {radius}
motion = [{{ time = 0 }}, {{ time = 0.1, translation = [0.05, 0.02, -0.03], rotation = [0, {turn}, 0] }}]
""")
    out = tmp_path / "out"
    command = [sys.executable, "-m", "windswept"]
    done([*command, "run", tmp_path / "scene.toml", "--out", out, "--formats", "vtkhdf,usd"])
    done([*command, "export", out, "--format", "npz"])
    if film != "hair.usda":
        done([*command, "export", out, "--format", "usdc", *units])
    done([blender, "-c", TOGETHER, out / film, tmp_path / "said.npz"])

    def to_blender(x):
        return np.stack([x[..., 0], -x[..., 2], x[..., 1]], axis=-1)

    with np.load(out / "film.npz") as ours, np.load(tmp_path / "said.npz") as said:
        assert len(said["hair"]) == 7
        np.testing.assert_allclose(said["hair"], to_blender(ours["positions"]), rtol=0, atol=1e-6)
        roots = ours["offsets"][:-1]
        for frame in range(7):
            part = frame / 6
            middle = to_blender(centre + part * np.array([0.05, 0.02, -0.03]))
            off = np.linalg.norm(said["heads"][frame] - middle, axis=1) - radius
            assert np.abs(off).max() < 1e-6
            # Roots stay where they are on the head: in its own axes both are at rest.
            cos, sin = np.cos(turn * part), np.sin(turn * part)
            back = np.array([[cos, sin, 0], [-sin, cos, 0], [0, 0, 1]])
            for all in (said["heads"], said["hair"][:, roots]):
                still = (all[frame] - middle) @ back.T
                np.testing.assert_allclose(still, all[0] - to_blender(centre), rtol=0, atol=2e-6)
        eye, aim = np.array([0.1, 0.2, 0.4]), np.array([-0.1, -0.19, -0.4])
        for camera in said["cameras"]:
            np.testing.assert_allclose(camera[:3, 3], to_blender(eye), rtol=0, atol=1e-6)
            np.testing.assert_allclose(-camera[:3, 2] / np.linalg.norm(camera[:3, 2]), to_blender(aim / np.linalg.norm(aim)), atol=1e-6)
        half = np.tan(np.radians(40) / 2) * np.array([640 / 400, 1])
        np.testing.assert_allclose(np.tan(said["angle"] / 2), half, rtol=1e-5)


@pytest.mark.long
def test_the_head_that_walks_opens(tmp_path, blender):
    example = Path(__file__).parents[2] / "examples/07_walking_head.py"
    subprocess.run([sys.executable, example, "--small"], check=True, cwd=tmp_path)
    walk = tmp_path / "walk"
    done([sys.executable, "-m", "windswept", "export", walk / "run", "--format", "npz", "--followers", "--up", "z"])
    done([blender, "-c", TOGETHER, walk / "film.usda", tmp_path / "said.npz"])
    with np.load(walk / "run/film.npz") as ours, np.load(tmp_path / "said.npz") as said:
        assert len(ours["offsets"]) == 401 and len(said["hair"]) == 2
        np.testing.assert_allclose(said["hair"], ours["positions"], rtol=0, atol=1e-6)
        # From the first keyframe to the next in 0.05 s, of which 0.02 s have passed; z is up, and y back.
        way = 0.4 * np.array([0.0, -0.06, 0.015 * np.sin(0.2 * np.pi)])
        for all in (said["heads"], said["hair"][:, ours["offsets"][:-1]]):
            np.testing.assert_allclose(all[1], all[0] + way, rtol=0, atol=2e-6)


def done(command):
    ran = subprocess.run(command, capture_output=True, text=True)
    assert ran.returncode == 0, ran.stdout + ran.stderr
