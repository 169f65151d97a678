"""Scenes: read, written, changed, refused."""

import pickle
from pathlib import Path

import numpy as np
import pytest

import windswept as ws

QUICK = Path(__file__).parents[2] / "examples/scenes/quick.toml"


def test_a_file_and_its_text_are_the_same_scene(tmp_path):
    scene = ws.Scene.load(QUICK)
    assert scene == ws.Scene.load(str(QUICK)) == ws.Scene.parse(QUICK.read_text())
    assert ws.Scene.parse(scene.to_toml()) == scene
    assert pickle.loads(pickle.dumps(scene)) == scene
    assert scene.title in repr(scene) and "60 strands" in repr(scene)


def test_replace_changes_its_keys_and_leaves_the_scene(scene):
    changed = scene.replace(
        title='a "storm"\n',
        **{
            "turbulence.bands": [{"scale": 0.018, "strength": 1.0}],
            "air.wind": np.array([6.0, 0.0, 0.0], dtype=np.float32),
            "hair.strands": np.int64(5),
            "hair.radius": np.float64(5e-5),
            "rods.sleep": False,
            "hair.hair.roots.center": (0.02, 0.03, 0.02),
        },
    )
    assert scene.title == "Small" and changed.title == 'a "storm"\n'
    text = changed.to_toml()
    for line in ("scale = 0.018", "wind = [6.0, 0.0, 0.0]", "strands = 5", "radius = 5e-5", "sleep = false"):
        assert line in text
    tables = scene.replace(
        **{
            "air.inflow": {"intensity": 0.1, "scale": 0.009},
            "air.gust": [{"time": 0.0, "velocity": [0, 0, 0]}, {"time": 0.1, "velocity": (1.0, 0, 0)}],
            "body": [{"center": [0.02, 0.03, 0.0225], "radius": 0.004, "motion": [{"time": 0.0}]}],
            "hair.motion": [{"time": 0.0}, {"time": 0.02, "translation": np.array([0.0, 0.0, 1e-3])}],
        }
    )
    assert tables.replace(**{"air.inflow.scale": 0.009}) == tables != tables.replace(**{"body.0.radius": 0.005})
    assert changed.replace(title="Small") != scene
    assert scene.replace() == scene


def test_faults_name_key_and_line_and_the_nearest_key(scene):
    with pytest.raises(ws.SceneError, match="did you mean hair.length") as caught:
        scene.replace(**{"hair.lenght": 0.1})
    assert isinstance(caught.value, ValueError)
    assert (caught.value.key, caught.value.line) == ("hair.lenght", None)
    assert "--set" not in str(caught.value)
    copied = pickle.loads(pickle.dumps(caught.value))
    assert (str(copied), copied.key, copied.help) == (str(caught.value), caught.value.key, caught.value.help)
    assert ws.SceneError("of one's own").key is None
    with pytest.raises(ws.SceneError) as caught:
        ws.Scene.parse("time = { step = 1e-3, duration = 1.0 }\nseed = -1\n")
    assert (caught.value.key, caught.value.line) == ("seed", 2)
    with pytest.raises(ws.SceneError, match="cannot be read"):
        ws.Scene.load("/nowhere/scene.toml")
    for key, value in [
        ("air.wind", [1.0, float("nan"), 0.0]),
        ("air.wind", [1.0, float("inf"), 0.0]),
        ("air.wind", "fast"),
        ("time.step", -1.0),
        ("hair.points", 1),
        ("hair.points", 10**30),
        ("body", [{"radius": 0.0}]),
    ]:
        with pytest.raises(ws.SceneError):
            scene.replace(**{key: value})


def test_values_that_no_scene_has_are_refused(scene):
    endless: list = []
    endless.append(endless)
    for value in (None, object(), 1j, b"bytes", endless, {1: 2}, {"a": {"b": {"c": {"d": {"e": {"f": {"g": {"h": 1}}}}}}}}):
        with pytest.raises(ValueError, match="air.wind"):
            scene.replace(**{"air.wind": value})


def test_a_scene_without_anything_cannot_start(bare):
    with pytest.raises(ws.SceneError, match="neither hair nor air"):
        ws.Simulation(bare)
