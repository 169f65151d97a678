"""Groom files: what NumPy writes we read, what we write NumPy reads, and a file that a script writes comes back as it was."""

import struct
import warnings

import numpy as np
import pytest

import windswept as ws


def strands(count, seed=5):
    """Strands of 3 to 39 points about a head, in metres, as float32."""
    rng = np.random.default_rng(seed)
    roots = rng.normal(size=(count, 3))
    roots *= 0.1 / np.linalg.norm(roots, axis=1, keepdims=True)
    lengths = rng.integers(3, 40, count)
    along = 0.005 * np.arange(40)[:, None]
    wave = np.concatenate([0.002 * np.sin(400 * along), -along, 0.002 * np.cos(300 * along)], axis=1)
    return [(root + wave[:n]).astype(np.float32) for root, n in zip(roots, lengths)]


def hair_file(given):
    """A .hair file by the description of the format; segments and points only."""
    points = np.concatenate(given)
    header = struct.pack("<4sIIIIff3f88s", b"HAIR", len(given), len(points), 0b11, 0, 0.1, 0, 1, 1, 1, b"a script's")
    assert len(header) == 128
    segments = np.array([len(strand) - 1 for strand in given], "<u2")
    return header + segments.tobytes() + points.astype("<f4").tobytes()


def test_ten_thousand_strands_of_a_script_come_back_as_they_were(tmp_path):
    given = strands(10_001)
    (tmp_path / "in.hair").write_bytes(hair_file(given))
    groom = ws.Groom.load(tmp_path / "in.hair", scale=1)
    assert len(groom) == 10_001
    for ending in ["hair", "npz", "ply", "data"]:
        path = tmp_path / f"out.{ending}"
        groom.save(path)
        back = ws.Groom.load(path, scale=1, radius=4e-5)
        np.testing.assert_array_equal(back.ids, np.arange(10_001))
        np.testing.assert_array_equal(np.diff(back.offsets), [len(strand) for strand in given])
        # Measured 0: the files hold 32 bits, as the script did.
        np.testing.assert_allclose(back.points, np.concatenate(given), rtol=0, atol=1e-6)


def test_numpy_reads_what_we_write(tmp_path):
    given = np.array([[[0, 0, 0], [0, -0.1, 0.1 / 3]], [[0.1, 0, 0], [0.1, -0.2, 0]]])
    groom = ws.Groom(given, radius=[3e-5, 6e-5])
    groom.save(tmp_path / "two.npz")
    with np.load(tmp_path / "two.npz") as file:
        assert sorted(file.files) == ["ids", "meters_per_unit", "offsets", "points", "radius"]
        np.testing.assert_array_equal(file["points"], given.reshape(-1, 3))
        assert file["offsets"].tolist() == [0, 2, 4] and file["ids"].tolist() == [0, 1]
        np.testing.assert_array_equal(file["radius"], [3e-5, 3e-5, 6e-5, 6e-5])
        assert file["meters_per_unit"] == 1.0
    groom.save(tmp_path / "two.npy")
    np.testing.assert_array_equal(np.load(tmp_path / "two.npy"), given)
    with pytest.warns(UserWarning, match="the radius that .*two.npz says"):
        back = ws.Groom.load(tmp_path / "two.npz")
    np.testing.assert_array_equal(back.points, groom.points)


@pytest.mark.parametrize("dtype", ["<f4", "<f8", ">f4", ">f8"])
@pytest.mark.parametrize("order", ["C", "F"])
def test_we_read_what_numpy_writes(tmp_path, dtype, order):
    given = np.asarray(np.cumsum(np.random.default_rng(1).normal(size=(5, 7, 3)), axis=1), dtype, order)
    np.save(tmp_path / "some.npy", given)
    np.savez(tmp_path / "some.npz", positions=given, root_uv=np.zeros((5, 2)))
    np.savez_compressed(tmp_path / "packed.npz", positions=given)
    for name in ["some.npy", "some.npz", "packed.npz"]:
        groom = ws.Groom.load(tmp_path / name, scale=0.5)
        np.testing.assert_array_equal(groom.points, 0.5 * given.reshape(-1, 3).astype(float))
        assert groom.offsets.tolist() == [0, 7, 14, 21, 28, 35]


def test_strands_of_unlike_lengths_by_offsets(tmp_path):
    points = np.cumsum(np.random.default_rng(2).normal(size=(9, 3)), axis=0)
    np.savez(tmp_path / "s.npz", points=points, offsets=np.array([0, 2, 9], np.int32), ids=[70, 3], meters_per_unit=0.01)
    groom = ws.Groom.load(tmp_path / "s.npz", up="z")
    np.testing.assert_allclose(groom.points, 0.01 * points[:, [0, 2, 1]] * [1, 1, -1], rtol=1e-15)
    assert groom.offsets.tolist() == [0, 2, 9] and groom.ids.tolist() == [70, 3]
    fewer = ws.Groom.load(tmp_path / "s.npz", strands=1, points=4)
    assert fewer.guides.sum() == 1 and fewer.ids.tolist() == [70, 3] and fewer.points.shape == (8, 3)
    np.savez(tmp_path / "s.npz", points=points, offsets=[0, 2, 10])
    with pytest.raises(ws.SceneError, match="offsets: expected rising numbers from 0 to 9"):
        ws.Groom.load(tmp_path / "s.npz", scale=1)


def test_what_is_left_out_is_said(tmp_path):
    given = strands(4)
    given[1][2, 0] = np.nan
    given[2] = given[2][:1]
    (tmp_path / "in.hair").write_bytes(hair_file(given))
    with pytest.warns(UserWarning, match="2 of the 4 strands .* 1 not finite, 1 of fewer than two points"):
        groom = ws.Groom.load(tmp_path / "in.hair", scale=1)
    assert groom.ids.tolist() == [0, 3]


def test_strands_that_are_left_to_followers_are_said(tmp_path):
    points = np.cumsum(np.random.default_rng(1).normal(size=(9, 7, 3)), axis=1)
    np.savez(tmp_path / "nine.npz", points=points, ids=[0, 1, 2, 3, 3, 3, 6, 7, 8], guides=[0, 1, 1, 0, 0, 0, 0, 0, 0], meters_per_unit=1.0)
    with pytest.warns(UserWarning) as caught:
        groom = ws.Groom.load(tmp_path / "nine.npz")
    assert groom.ids[groom.guides].tolist() == [1, 2] and repr(groom) == "<windswept.Groom: 9 strands, 2 of them guides, 63 points>"
    said = [str(warning.message) for warning in caught]
    assert any("marks 2 of its 9 strands as guides" in words and "7 left to followers" in words for words in said)
    assert any("2 of the 9 strands of" in words and "have the id of a strand before them" in words for words in said)


def test_a_groom_keeps_its_followers(tmp_path, bare):
    strand = 0.01 * np.arange(6)[:, None] * [0.0, -1.0, 0.2]
    roots = np.random.default_rng(4).uniform(-0.1, 0.1, (301, 1, 3)) * [1, 0, 1]
    marked = np.isin(np.arange(301), [7, 100, 250])
    given = dict(points=(roots + strand).astype(np.float32), ids=np.arange(301)[::-1], meters_per_unit=1.0)
    np.savez(tmp_path / "all.npz", guides=marked, **given)
    with pytest.warns(UserWarning, match="marks 3 of its 301 strands as guides: strands are taken of these, and 298 left to followers"):
        groom = ws.Groom.load(tmp_path / "all.npz")
    assert len(groom) == 301 and groom.guides.dtype == bool
    np.testing.assert_array_equal(groom.guides, marked)

    # What is simulated and what follows is what a scene makes of the file.
    (tmp_path / "scene.toml").write_text(bare.text + '[hair]\nfile = "all.npz"\n')
    with pytest.warns(UserWarning):
        sims = [ws.Simulation(ws.Scene.load(tmp_path / "scene.toml")), ws.Simulation(bare, groom=groom)]
    for sim in sims:
        assert sim.hair.ids.tolist() == [293, 200, 50]
        sim.step(20)
    of_scene, of_groom = (sim.followers for sim in sims)
    np.testing.assert_array_equal(of_groom.ids, given["ids"])
    for name in ["positions", "velocities", "offsets", "ids", "guides", "weights"]:
        np.testing.assert_array_equal(getattr(of_groom, name), getattr(of_scene, name), err_msg=name)
    sims[1].save(tmp_path / "now.windswept")
    np.testing.assert_array_equal(ws.Simulation.load(tmp_path / "now.windswept").followers.positions, of_groom.positions)
    # Pictures draw them: another follower is another picture.
    shifted = ws.Groom(groom.points.reshape(301, 6, 3) + 0.05 * ~marked[:, None, None], guides=marked)
    pictures = [ws.Simulation(bare, groom=g).render(160, 120) for g in [ws.Groom(groom.points.reshape(301, 6, 3), guides=marked), shifted]]
    assert (pictures[0] != pictures[1]).any()

    # All of it is saved and comes back, and the marks can be left aside.
    groom.save(tmp_path / "again.npz")
    with np.load(tmp_path / "again.npz") as file:
        np.testing.assert_array_equal(file["guides"].astype(bool), marked)
        np.testing.assert_array_equal(file["points"].reshape(301, 6, 3), given["points"])
    unmarked = ws.Groom.load(tmp_path / "all.npz", file_guides=False)
    assert unmarked.guides.all() and len(unmarked) == 301
    assert len(ws.Simulation(bare, groom=unmarked).hair.ids) == 301
    few = ws.Groom.load(tmp_path / "all.npz", file_guides=False, strands=5)
    assert len(few) == 301 and few.guides.sum() == 5
    with pytest.warns(UserWarning, match="again.npy has no ids, guides"):
        groom.save(tmp_path / "again.npy")


def test_guides_are_truth_values():
    points = np.zeros((3, 2, 3)) + [[[0, 0, 0], [0, 1, 0]]]
    assert ws.Groom(points, guides=[0, 1, 0]).guides.tolist() == [False, True, False]
    for guides, words in [([0, 2, 1], "found 2"), ([0.5, 1, 0], "array of booleans"), ([True], "expected 3 values"), (True, "shape"), ([False] * 3, "at least one")]:
        with pytest.raises(ValueError, match=rf"guides: .*{words}"):
            ws.Groom(points, guides=guides)


def test_what_a_format_cannot_hold_is_said(tmp_path):
    np.savez(tmp_path / "two.npz", points=np.random.default_rng(1).normal(size=(2, 7, 3)), ids=[7, 3], groups=[1, 2], meters_per_unit=1.0)
    groom = ws.Groom.load(tmp_path / "two.npz")
    for ending in ["hair", "data", "ply", "npy"]:
        with pytest.warns(UserWarning, match=rf"two.{ending} has no ids, groups: a .npz file holds them"):
            groom.save(tmp_path / f"two.{ending}")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        groom.save(tmp_path / "again.npz")


def test_faults_name_the_argument_or_the_file(tmp_path):
    (tmp_path / "in.hair").write_bytes(hair_file(strands(3))[:-1])
    with pytest.raises(ws.SceneError, match=r"in\.hair: at byte 134: expected the points, .* ends at byte"):
        ws.Groom.load(tmp_path / "in.hair", scale=1)
    (tmp_path / "in.hair").write_bytes(hair_file(strands(3)))
    with pytest.raises(ws.SceneError, match="does not say its unit.*if that is the metre"):
        ws.Groom.load(tmp_path / "in.hair")
    for name, value in [("points", 1), ("points", -1), ("strands", 0), ("scale", -1.0), ("up", "w"), ("radius", -1.0), ("seed", -1)]:
        with pytest.raises(ValueError, match=name):
            ws.Groom.load(tmp_path / "in.hair", **{"scale": 1, name: value})
    with pytest.raises(ws.SceneError, match="cannot be read"):
        ws.Groom.load(tmp_path / "none.hair", scale=1)
    with pytest.raises(ws.SceneError, match=r"\.hair, \.data, \.bin"):
        ws.Groom.load(tmp_path / "none.abc", scale=1)
    with pytest.raises(ws.SceneError, match="files are read, not written"):
        ws.Groom(np.array([[[0, 0, 0], [0, 1, 0.0]]])).save(tmp_path / "out.bin")
    np.save(tmp_path / "objects.npy", np.array([None]), allow_pickle=True)
    with pytest.raises(ws.SceneError, match="array of numbers"):
        ws.Groom.load(tmp_path / "objects.npy", scale=1)


def test_a_groom_from_a_file_is_simulated(tmp_path, bare):
    (tmp_path / "in.hair").write_bytes(hair_file(strands(6)))
    sim = ws.Simulation(bare, groom=ws.Groom.load(tmp_path / "in.hair", scale=1, points=9, strands=5))
    sim.step(5)
    assert sim.hair.positions.shape == (45, 3) and np.isfinite(sim.hair.positions).all()
    (tmp_path / "scene.toml").write_text(bare.text + '[hair]\nfile = "in.hair"\nscale = 1.0\npoints = 9\nstrands = 5\n')
    scene = ws.Scene.load(tmp_path / "scene.toml").replace(title="elsewhere")
    same = ws.Simulation(scene)
    same.step(5)
    np.testing.assert_array_equal(same.hair.positions, sim.hair.positions)
