"""What a program does to hair and reads of bodies: pins, and the impulse of the air."""

import numpy as np
import pytest

import windswept as ws


def test_pins_hold_points_where_they_go(bare):
    points = np.zeros((2, 9, 3))
    points[:, :, 1] = -np.linspace(0, 0.04, 9)
    points[1, :, 0] = 0.1
    sim = ws.Simulation(bare, groom=ws.Groom(points))
    place = points[0, 5] + [0.005, 0.002, 0.0]
    for part in np.linspace(0, 1, 50):
        sim.set_pins([5], [points[0, 5] + part * (place - points[0, 5])])
        sim.step()
    sim.run(0.1)
    assert np.allclose(sim.hair.positions[5], place, atol=1e-6)
    sim.set_pins([], [])
    sim.run(0.5)
    assert np.linalg.norm(sim.hair.positions[5] - place) > 1e-3
    for points, places, name in [([99], [place], "points"), ([9], [place], "points"), ([5], [place[:2]], "places"),
                                 ([5.5], [place], "points"), ([5, 6], [place], "places")]:
        with pytest.raises(ValueError, match=name):
            sim.set_pins(points, places)


def test_air_pushes_bodies():
    """A ball in wind of 3 m/s gets an impulse along it, near ½ ρ U² π R² C_d with C_d of 0.5 to 3, as the report says."""
    scene = ws.Scene.parse(
        """
        time = { step = 1.38e-3, duration = 1.0 }
        interaction.model = "two-way"
        [air]
        box = { min = [0, 0, 0], max = [0.12, 0.08, 0.08] }
        wind = [3, 0, 0]
        ramp = 0.0
        [[body]]
        name = "ball"
        center = [0.04, 0.04, 0.04]
        radius = 0.018
        """
    )
    sim = ws.Simulation(scene)
    sim.step(20)
    before = sim.body_impulses()
    sim.step(20)
    force = (sim.body_impulses() - before)[0] / (20 * 1.38e-3)
    drag = force[0] / (0.5 * 1.29 * 9 * np.pi * 0.018**2)
    assert before.shape == (1, 3)
    assert 0.5 < drag < 3, drag
    assert abs(force[1:]).max() < 0.5 * force[0], force
    [ball] = sim.report()["bodies"]
    assert ball["name"] == "ball"
    np.testing.assert_allclose(ball["impulse_kg_m_per_s"], sim.body_impulses()[0])
