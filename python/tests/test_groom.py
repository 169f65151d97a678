"""Grooms: both ways to give points, every argument, every fault by its name."""

import numpy as np
import pytest

import windswept as ws


def level(strands=3, n=6, length=0.05):
    points = np.zeros((strands, n, 3))
    points[..., 0] = np.linspace(0.0, length, n)
    points[..., 2] = 0.01 * np.arange(strands)[:, None]
    return points


def rest(scene, groom, seconds=0.5):
    sim = ws.Simulation(scene.replace(**{"rods.damping": 30.0}), groom=groom)
    sim.run(seconds)
    return sim.hair.positions.reshape(len(groom), -1, 3)


def test_points_by_shape_and_by_offsets_are_the_same(bare):
    points = level()
    by_shape = ws.Simulation(bare, groom=ws.Groom(points))
    by_offsets = ws.Simulation(bare, groom=ws.Groom(points.reshape(-1, 3), offsets=[0, 6, 12, 18]))
    for sim in (by_shape, by_offsets):
        sim.step(20)
    assert np.array_equal(by_shape.hair.positions, by_offsets.hair.positions)
    assert by_shape.hair.offsets.tolist() == [0, 6, 12, 18]
    assert by_shape.hair.orientations.shape == (15, 4)
    lone = ws.Groom(np.concatenate([level(1, 3)[0], level(1, 4)[0]]), offsets=np.array([0, 3, 7]))
    assert len(lone) == 2 and ws.Simulation(bare, groom=lone).hair.offsets.tolist() == [0, 3, 7]


def test_a_groom_replaces_the_hair_of_the_scene(scene):
    sim = ws.Simulation(scene, groom=ws.Groom(level(2) + [0.01, 0.03, 0.02]))
    sim.step(3)
    assert sim.hair.positions.shape == (12, 3)
    assert sim.report()["particles"]["hair"] == 12
    assert "[[hair]]" not in sim.scene.text
    assert sim.render(64, 48).shape == (48, 64, 4)


def test_values_are_scalars_or_one_for_each_strand(bare):
    soft = rest(bare, ws.Groom(level(), youngs_modulus=[4e9, 4e8, 4e9], radius=np.full(3, 4e-5, np.float32)))
    drop = -soft[:, -1, 1]
    assert drop[1] > 1.5 * drop[0] and np.isclose(drop[0], drop[2], rtol=1e-3)
    # A flat fibre bends easily about d2; by default its d1 is level here, and weight bends it about that, the hard way.
    wide = rest(bare, ws.Groom(level(1), radius=4e-5, aspect=0.5))
    turned = rest(bare, ws.Groom(level(1), radius=4e-5, aspect=0.5, root_frame=[0.5, 0.5, 0.5, 0.5]))
    assert -turned[0, -1, 1] > 1.5 * -wide[0, -1, 1]


def test_rest_curvature_curls(bare):
    still = bare.replace(gravity=[0, 0, 0])
    kappa = (0.0, 20.0, 0.0)
    one = rest(still, ws.Groom(level(), rest_curvature=kappa))
    strands = rest(still, ws.Groom(level(), rest_curvature=np.tile(kappa, (3, 1))))
    joints = rest(still, ws.Groom(level(), rest_curvature=np.tile(kappa, (3, 5, 1))))
    flat = rest(still, ws.Groom(level().reshape(-1, 3), offsets=[0, 6, 12, 18], rest_curvature=np.tile(kappa, (15, 1))))
    # A radian of a circle of 50 mm: its chord is 2 r sin(1/2) = 47.9 mm.
    assert np.allclose(np.linalg.norm(one[:, -1] - one[:, 0], axis=-1), 0.0479, atol=3e-4)
    for other in (strands, joints, flat):
        assert np.allclose(one, other, atol=1e-6)


def test_stiffer_roots_hang_less(bare):
    """A beam of constant stiffness is a factor of 1; one that is four times as stiff sags a quarter as far."""
    sag = lambda stiffness: 0.0 - rest(bare, ws.Groom(level(1, 11, 0.02), stiffness=stiffness))[0, -1, 1]
    plain, stiff = sag(None), sag([[0.3, 4.0]])
    assert plain == sag([[0.0, 1.0]]) and stiff == pytest.approx(plain / 4, rel=0.05)


def test_ends_are_held_as_they_say(bare):
    points = level()
    held = rest(bare, ws.Groom(points, root=["clamped", "pinned", "free"], tip=np.array(["free", "free", "pinned"])), 2.0)
    assert np.allclose(held[:2, 0], points[:2, 0], atol=1e-6) and np.allclose(held[2, -1], points[2, -1], atol=1e-6)
    # A pinned end lets its strand hang; a clamp holds this one up, nearly.
    assert held[1, -1, 1] < -0.0499 and held[2, 0, 1] < -0.0499 and held[0, -1, 1] > -0.03
    with pytest.raises(ws.SceneError, match="direct solver"):
        ws.Simulation(bare.replace(**{"rods.solver": "gauss-seidel"}), groom=ws.Groom(points, tip="clamped"))


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("points", np.zeros((3, 6, 2))),
        ("points", np.zeros((3, 6, 3))),
        ("points", np.zeros(3)),
        ("points", np.zeros((3, 6, 3), dtype=object)),
        ("points", np.zeros((3, 6, 3), dtype=complex)),
        ("points", np.zeros((3, 6, 3), dtype=int)),
        ("points", level() * np.nan),
        ("points", "hair"),
        ("points", None),
        ("points", level(n=1)),
        ("points", [[[0, 0, 0], [1]]]),
        ("points", np.zeros((0, 6, 3))),
        ("offsets", [0, 6, 17]),
        ("offsets", [1, 6, 18]),
        ("offsets", [0, 12, 6, 18]),
        ("offsets", [0, 6, 6, 18]),
        ("offsets", [0.0, 18.0]),
        ("offsets", [[0, 18]]),
        ("offsets", []),
        ("offsets", -1),
        ("offsets", [0.5]),
        ("radius", 0.0),
        ("radius", [4e-5, 4e-5]),
        ("radius", np.ones((3, 1))),
        ("density", "heavy"),
        ("density", -1.0),
        ("youngs_modulus", float("inf")),
        ("poissons_ratio", 1.0),
        ("fibres_per_strand", 0),
        ("point_mass", 0.0),
        ("aspect", 1.5),
        ("friction", -0.1),
        ("group", 0.5),
        ("group", [-1, 0, 0]),
        ("rest_curvature", np.zeros((2, 3))),
        ("rest_curvature", np.zeros((3, 6, 3))),
        ("rest_curvature", [0.0, np.nan, 0.0]),
        ("root_frame", [0.0, 0.0, 0.0, 0.0]),
        ("root_frame", [1.0, 0.0, 0.0]),
        ("tip_frame", np.zeros((2, 4))),
        ("root", "glued"),
        ("root", ["free"]),
        ("tip", 3),
        ("stiffness", 2.0),
        ("stiffness", [[0.5, -1.0]]),
        ("stiffness", [[0.5, 1.0], [0.2, 1.0]]),
    ],
)
def test_faults_name_their_argument(name, value):
    arguments = {"points": level(), name: value}
    if name == "offsets":
        arguments["points"] = level().reshape(-1, 3)
    with pytest.raises(ValueError, match=rf"^(groom\.)?{name}:") as caught:
        ws.Groom(**arguments)
    assert getattr(caught.value, "key", f"groom.{name}") == f"groom.{name}"


@pytest.mark.parametrize("fill", [0.0, np.nan, None])
def test_padding_of_unlike_strands_is_cut_off(fill):
    points = np.zeros((3, 8, 3))
    for s, count in enumerate([8, 5, 2]):
        points[s, :, 0] = 0.1 + s
        points[s, :, 1] = -0.01 * np.minimum(np.arange(8), count - 1)
        points[s, count:] = points[s, count:] if fill is None else fill
    with pytest.warns(UserWarning, match="2 of the 3 strands had padding behind their tips, which is cut off"):
        groom = ws.Groom(points)
    assert groom.offsets.tolist() == [0, 8, 13, 15]
    assert np.array_equal(groom.points[8:13], points[1, :5])
