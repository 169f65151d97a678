"""A simulation goes on with other values."""

import numpy as np
import pytest
import windswept as ws


def test_values_change_and_the_state_stays(sim: ws.Simulation) -> None:
    sim.step(2)
    before = sim.hair.positions.copy()
    sim.update(**{"gravity": [0.0, -3.0, 0.0]})
    np.testing.assert_array_equal(sim.hair.positions, before)
    assert "gravity = [0.0, -3.0, 0.0]" in sim.scene.text
    sim.update(sim.scene.replace(title="again"))
    assert sim.scene.title == "again"
    sim.step(1)
    assert sim.steps == 3 and np.isfinite(sim.hair.positions).all()


def test_what_there_is_stays(sim: ws.Simulation) -> None:
    with pytest.raises(ws.SceneError, match=r"hair.*strands.*start another simulation"):
        sim.update(**{"hair.strands": 3})
    with pytest.raises(ws.SceneError, match="did you mean"):
        sim.update(**{"gravitty": [0, 0, 0]})
