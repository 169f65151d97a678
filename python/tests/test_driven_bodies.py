"""Bodies that the program moves, forces on hair, and samples of the air."""

import numpy as np
import pytest

import windswept as ws


@pytest.fixture(scope="module")
def scene():
    roots = ws.Disc(center=[0.03, 0.035, 0.025], radius=0.008, direction=[1, -0.4, 0])
    scene = ws.Scene(time=ws.Time(step=1.38e-3, duration=1.0))
    scene.hair = ws.Hair(strands=8, points=6, length=0.04, roots=roots)
    scene.body = ws.Body(name="ball", shape=ws.Sphere(center=[0.07, 0.01, 0.025], radius=0.008))
    scene.air = ws.Air(box=[0.1, 0.05, 0.05], wind=[2, 0, 0], ramp=0)
    return scene


def test_a_body_goes_where_it_is_set(scene):
    sim, still = ws.Simulation(scene), ws.Simulation(scene)
    for k in range(10):
        sim.set_body("ball", [0, 0.002 * k, 0], [0, 0, np.sin(0.05 * k), np.cos(0.05 * k)])
        sim.step()
    still.step(10)
    assert np.abs(sim.hair.positions - still.hair.positions).max() > 1e-5
    pose = next(sim.frames(1)).bodies
    assert pose.shape == (1, 7) and np.allclose(pose, [[0, 0.018, 0, 0, 0, np.sin(0.45), np.cos(0.45)]])
    sim.set_body("ball", [0, 0, 0], velocity=[0, 1, 0], angular_velocity=[0, 0, 3])
    sim.step()
    for arguments, words in [
        (("bal", [0, 0, 0]), 'name: expected a body of the scene, found "bal": ball'),
        (("ball", [0, 0]), "translation"),
        (("ball", [0, 0, 0], [0, 0, 1]), r"rotation: expected shape \(4,\), found \(3,\)"),
        (("ball", [0, 0, 0], [0, 0, 0, 0]), "rotation: expected a quaternion"),
        (("ball", [np.nan, 0, 0]), "translation"),
    ]:
        with pytest.raises(ValueError, match=words):
            sim.set_body(*arguments)


def test_a_mesh_deforms(scene, tmp_path):
    corners = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]])
    points = np.array([[0.06, 0, 0.01], [0.09, 0, 0.01], [0.06, 0.03, 0.01], [0.06, 0, 0.04]])
    grown = points + [[0, 0, 0], [0.003, 0, 0], [0, 0.002, 0], [0, 0, 0]]
    ws.write_mesh(tmp_path / "stone.obj", points, corners)
    ws.write_frames(tmp_path / "stone.npz", [points, grown], corners, [0, 10 * scene.time.step])

    def with_body(**keys):
        mesh = ws.MeshFile(scale=1.0, resolution=1e-3, **keys)
        return scene.replace(body=ws.Body(name="stone", shape=mesh))

    by_hand = ws.Simulation(with_body(file=str(tmp_path / "stone.obj")))
    for k in range(1, 11):
        by_hand.set_body("stone", vertices=points + 0.1 * k * (grown - points))
        by_hand.step()
    by_file = ws.Simulation(with_body(frames=str(tmp_path / "stone.npz")))
    by_file.step(10)
    # Measured 1.3e-4 m: ten poses are baked of the one, two of the other, on a grid of 1 mm with sharp edges.
    assert np.abs(by_hand.hair.positions - by_file.hair.positions).max() < 2e-4
    for arguments, words in [
        (dict(vertices=points[:3]), "vertices: expected 4 rows, found 3"),
        (dict(vertices=points, translation=[0, 0, 0]), "vertices: expected no pose"),
        (dict(translation=[0, 0, 0]), "deforms: expected vertices"),
    ]:
        with pytest.raises(ValueError, match=words):
            by_hand.set_body("stone", **arguments)
    for poses, times, words in [
        ([points, grown[:3]], [0, 1], "positions: expected"),
        ([points, grown], [0, 0], "times: expected"),
        ([points], [0, 1], "times: expected"),
    ]:
        with pytest.raises(ValueError, match=words):
            ws.write_frames(tmp_path / "bad.npz", poses, corners, times)


def test_forces_on_hair(scene):
    sim = ws.Simulation(scene)
    sim.step(5)
    points, strands = sim.hair.positions.shape[0], len(sim.hair.ids)
    hair = sim.hair
    assert hair.drag.shape == hair.air_velocity.shape == (points, 3)
    assert hair.root_force.shape == hair.root_moment.shape == (strands, 3) and hair.root_frames.shape == (strands, 4)
    assert all(array.dtype == np.float32 for array in (hair.drag, hair.root_force, hair.root_frames))
    # Wind blows along x, and weight pulls down.
    assert hair.drag[:, 0].sum() > 0 and hair.air_velocity[:, 0].mean() > 0.5
    assert np.allclose(np.linalg.norm(hair.root_frames, axis=1), 1, atol=1e-5)


def test_air_is_sampled(scene):
    sim = ws.Simulation(scene)
    sim.step(2)
    velocity, density = sim.air.sample(np.array([[0.02, 0.03, 0.02], [0.12, 0.03, 0.02]]))
    assert velocity.shape == (2, 3) and density.shape == (2,)
    assert np.allclose(velocity[0], velocity[1]) and 1.2 < density[0] < 1.4 and 1 < velocity[0, 0] < 3
    with pytest.raises(ValueError, match="points: expected finite numbers"):
        sim.air.sample([[0.0, np.inf, 0.0]])
    with pytest.raises(ValueError, match="the scene has no air particles"):
        bare = ws.Scene(time=ws.Time(step=1e-3, duration=1.0), interaction=ws.Interaction(model="none"), hair=scene.hair)
        ws.Simulation(bare).air.sample([[0.0, 0.0, 0.0]])


@pytest.mark.parametrize("library", ["numpy", "torch", "jax.numpy"])
def test_arrays_go_to_other_libraries(scene, library):
    """Arrays are copies on the CPU, which DLPack hands on: wgpu shares no memory with CUDA."""
    other = pytest.importorskip(library)
    positions = ws.Simulation(scene).hair.positions
    taken = other.from_dlpack(positions)
    assert tuple(taken.shape) == positions.shape and np.array_equal(np.asarray(taken), positions)
