"""Simulations that were saved, pickled or copied go on with the same bits; what is no checkpoint is refused."""

import copy
import pickle
import zlib

import numpy as np
import pytest

import windswept as ws


def same(one, other):
    pairs = [
        (one.hair.positions, other.hair.positions),
        (one.hair.velocities, other.hair.velocities),
        (one.air.positions, other.air.positions),
        (one.air.velocities, other.air.velocities),
    ]
    return all(np.array_equal(a.view(np.uint32), b.view(np.uint32)) for a, b in pairs)


def test_a_saved_simulation_goes_on_with_the_same_bits(sim, tmp_path):
    sim.step(5)
    sim.set_wind([0, 2, 0])
    sim.save(tmp_path / "now.windswept")
    assert [path.name for path in tmp_path.iterdir()] == ["now.windswept"]
    loaded = ws.Simulation.load(tmp_path / "now.windswept")
    assert (loaded.steps, loaded.time, loaded.scene, loaded.adapter) == (sim.steps, sim.time, sim.scene, sim.adapter)
    assert same(sim, loaded)
    before = sim.hair.positions
    for simulation in (sim, loaded):
        simulation.step(10)
    assert same(sim, loaded) and not np.array_equal(before, sim.hair.positions)
    assert np.array_equal(sim.render(64, 64), loaded.render(64, 64))


def test_a_simulation_can_be_pickled_and_copied(scene):
    points = np.zeros((3, 5, 3))
    points[..., 1] = -0.005 * np.arange(5)
    points[..., 0] = [[0.02], [0.03], [0.04]]
    sim = ws.Simulation(scene, groom=ws.Groom(points + [0, 0.03, 0.02], radius=[4e-5, 6e-5, 8e-5]))
    sim.step(3)
    others = [pickle.loads(pickle.dumps(sim)), copy.deepcopy(sim)]
    for simulation in (sim, *others):
        simulation.step(4)
    assert all(same(sim, other) for other in others)


def test_a_groom_can_be_pickled(bare):
    points = np.zeros((2, 6, 3))
    points[..., 0] = 0.004 * np.arange(6)
    points[1, :, 2] = 0.01
    turned = [0, 0, np.sin(0.2), np.cos(0.2)]
    groom = ws.Groom(points, radius=[4e-5, 6e-5], aspect=0.5, rest_curvature=[0, 20, 0], root_frame=turned, tip=["free", "pinned"])
    copied = pickle.loads(pickle.dumps(groom))
    assert repr(copied) == repr(groom) and len(copied) == 2
    sims = [ws.Simulation(bare, groom=groom) for groom in (groom, copied)]
    for sim in sims:
        sim.step(5)
    assert same(*sims)
    function, (version, content) = groom.__reduce__()
    with pytest.raises(ValueError, match="found one of 9.9"):
        function("9.9", content)
    with pytest.raises(ValueError, match="pickled groom"):
        function(version, content[:10])


def test_what_is_no_checkpoint_is_refused(sim, tmp_path):
    path = tmp_path / "now.windswept"
    sim.save(path)
    whole = path.read_bytes()
    damaged = bytearray(whole)
    damaged[len(whole) // 2] ^= 1
    newer = whole[:8] + (99).to_bytes(4, "little") + whole[12:]
    for content, words in [
        (whole[:-9], "is cut off"),
        (bytes(damaged), "is damaged: bytes"),
        (newer, "is damaged: bytes 0 to 12"),
        (b"", "no checkpoint"),
        (b"PK\x03\x04" * 9, "no checkpoint"),
    ]:
        path.write_bytes(content)
        with pytest.raises(ValueError, match=words) as caught:
            ws.Simulation.load(path)
        assert str(path) in str(caught.value)
    with pytest.raises(FileNotFoundError, match="nowhere"):
        ws.Simulation.load(tmp_path / "nowhere")
    with pytest.raises(OSError, match="cannot be written"):
        sim.save(tmp_path / "nowhere" / "now.windswept")
    with pytest.raises(ws.GpuError, match="no such thing"):
        path.write_bytes(whole)
        ws.Simulation.load(path, adapter="no such thing")


def test_another_adapter_is_warned_of(sim, tmp_path):
    path = tmp_path / "now.windswept"
    sim.save(path)
    content = path.read_bytes()
    name = next(adapter["name"] for adapter in ws.adapters() if adapter["name"] in sim.adapter)
    # A section: length of the name, name, length of the content, checksum; the content; its checksum.
    start = 16 + 4 + len("about") + 8 + 4
    length = int.from_bytes(content[start - 12 : start - 4], "little")
    about = content[start : start + length].replace(name.encode(), (len(name) * "x").encode())
    changed = content[:start] + about + zlib.crc32(about).to_bytes(4, "little") + content[start + length + 4 :]
    path.write_bytes(changed)
    with pytest.warns(UserWarning, match="goes on with another adapter") as caught:
        loaded = ws.Simulation.load(path)
    assert str(caught[0].message) in [warning["text"] for warning in loaded.report()["warnings"]]
