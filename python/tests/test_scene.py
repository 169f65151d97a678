"""Scenes: read, written, changed, refused."""

import copy
import inspect
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
    assert eval(repr(scene), vars(ws)) == scene and "strands=60" in repr(scene)


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


@pytest.fixture
def made() -> ws.Scene:
    return ws.Scene(
        time=ws.Time(step=1.38e-3, duration=1.0),
        hair=ws.Hair(
            strands=60, points=11, length=0.10, roots=ws.Disc(center=[0.056, 0.065, 0.035], radius=0.017, direction=[1, 0.1, 0])
        ),
        air=ws.Air(box=[0.16, 0.12, 0.07], wind=[3, 0, 0]),
        turbulence=ws.Turbulence(scale=0.006),
    )


def test_a_scene_made_in_code_is_the_one_of_its_text(made):
    assert ws.Scene.from_dict(made.to_dict()) == made == ws.Scene.parse(made.to_toml()) == ws.Scene.parse(made.text)
    assert pickle.loads(pickle.dumps(made)) == made == copy.deepcopy(made) and eval(repr(made), vars(ws)) == made
    np.testing.assert_array_equal(made.air.wind, [3.0, 0.0, 0.0])
    np.testing.assert_array_equal(made.air.box.max, [0.16, 0.12, 0.07])
    other = copy.deepcopy(made)
    other.air.wind = np.float32([4, 0, 0])
    assert other != made and other == made.replace(**{"air.wind": [4, 0, 0]}) and "wind = [4.0, 0.0, 0.0]" in other.text
    other.air = None
    assert "air" not in other.to_dict()
    with pytest.raises(ValueError, match="read-only"):
        made.air.wind[0] = 5.0


def test_a_scene_of_a_file_keeps_its_text_until_it_is_changed():
    scene = ws.Scene.load(QUICK)
    assert "# A small brush" in scene.text and "# A small brush" in pickle.loads(pickle.dumps(scene)).text
    scene.turbulence.scale = 0.018
    assert "#" not in scene.text and "scale = 0.018" in scene.text
    assert scene == ws.Scene.load(QUICK).replace(**{"turbulence.scale": 0.018})


def test_values_that_follow_are_those_of_the_checked_scene(made):
    assert made.turbulence.speed is None and made.turbulence.bands == []
    checked = made.checked()
    assert checked.turbulence.speed == 3.0 and checked.air.fringe == pytest.approx(4 * 9.3e-3)
    assert (checked.interaction.model, checked.air.inflow.scale) == ("two-way", 0.006)
    assert checked.checked() == checked and made.checked() == checked
    assert made["turbulence.speed"] == 3.0 and made["turbulence.bands.0.scale"] == 0.006
    made.method = "published"
    assert made.checked().interaction.model == "particles"


def test_dotted_paths_read_and_write(made):
    made.body = [ws.Body(name="ball", shape=ws.Sphere(center=[0.1, 0.02, 0.03], radius=0.01)), ws.Body(name="pole")]
    made["body.pole.shape"] = ws.Capsule(start=[0, 0, 0.03], end=[0.1, 0, 0.03], radius=0.002)
    made["body.ball.radius"] = 0.012
    made["hair.hair.radius"] = made["hair.0.taper"] = 5e-5
    made["air.inflow.scale"] = made["air.inflow.intensity"] = 0.1
    made["fluid.relaxation"] = 0.4
    assert made.body[0].radius == 0.012 and made.body[1].shape == made["body.1.shape"] == "capsule"
    assert made.hair[0].radius == made["hair.radius"] == made["hair.hair.taper"] == 5e-5
    assert made["hair.roots.shape"] == "disc" and made["hair.hair.roots.radius"] == 0.017
    assert (made.air.inflow.scale, made.fluid.relaxation) == (0.1, 0.4)


def test_wrong_names_and_values_are_told_of_by_their_keys(made):
    for path, value, words in [
        ("air.wind", "fast", "air.wind: expected three numbers"),
        ("air.wind", [1, 2], "air.wind: expected three numbers"),
        ("air.wind", [1, float("nan"), 2], "air.wind: expected three numbers.* in y nan"),
        ("air.box", ws.Time(step=1, duration=1), "air.box: expected windswept.Bounds"),
        ("time.step", -1.0, "time.step: expected a number greater than 0"),
        ("time.step", None, "^time.step: is missing"),
        ("hair", 5, "hair: expected windswept.Hair"),
        ("hair.roots", {"shape": "ball"}, "hair.roots.shape: expected one of disc, .*found 'ball'"),
        ("hair.points", 1, "hair.points: expected a whole number of at least 2"),
        ("hair.roots", ws.Scalp(body="head"), "hair.roots.body: .*head"),
        ("turbulence.law", "strong", 'turbulence.law: expected one of "band"'),
        ("air.wnid", 1, "air.wnid: unknown key; did you mean wind"),
        ("body.0.radius", 1, "body.0: there is no 0"),
    ]:
        wrong = copy.deepcopy(made)
        with pytest.raises(ws.SceneError, match=words) as caught:
            wrong[path] = value
            wrong.checked()
        assert caught.value.key.startswith(path.rpartition(".")[0]), caught.value
    with pytest.raises(AttributeError, match="Air has no key 'wnid'; did you mean wind"):
        made.air.wnid = 3
    with pytest.raises(TypeError, match="no argument 'wnid'; did you mean wind"):
        ws.Air(wnid=3)
    with pytest.raises(TypeError, match="needs duration"):
        ws.Time(step=1e-3)
    with pytest.raises(ws.SceneError, match="air.wnid: unknown key; did you mean wind"):
        ws.Scene.from_dict({"air": {"wnid": 3}})
    with pytest.raises(TypeError, match="expected a windswept.Scene"):
        ws.Simulation("quick.toml")
    # All faults at once.
    made.time.step, made.hair[0].points = -1.0, 0
    with pytest.raises(ws.SceneError, match="time.step: .*\n.*hair.points: "):
        made.checked()


def test_every_key_is_documented():
    for name in ws.scene.__all__:
        table = getattr(ws, name)
        assert table.__doc__ and list(inspect.signature(table).parameters) == list(table._keys), name
        for key, own in table._keys.items():
            assert len(own.__doc__) > 10 and own.__doc__.endswith("."), f"{name}.{key}"
    assert "[m/s]" in ws.Air.wind.__doc__ and "Default 60.0" in ws.Time.frame_rate.__doc__


def test_a_scene_without_anything_cannot_start(bare):
    with pytest.raises(ws.SceneError, match="neither hair nor air"):
        ws.Simulation(bare)


def test_a_scene_says_what_it_has():
    scene = ws.Scene(time=ws.Time(step=1e-3, duration=1), interaction=ws.Interaction(model="none"))
    scene.hair = [ws.Hair(name=name, strands=2, points=3, length=0.1, roots=ws.Disc(center=[0, 0, 0], radius=0.01)) for name in "ab"]
    assert "time.step" in scene and "hair.b.length" in scene and "air.wind" not in scene and "time.stp" not in scene
    with pytest.raises(TypeError):
        list(scene)
    with pytest.raises(ws.SceneError, match="there is no c among a, b"):
        scene["hair.c.length"]
    for path in ("", "hair.a."):
        with pytest.raises(ws.SceneError):
            scene[path]
