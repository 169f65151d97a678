"""ws.measure on films of runs, files and frames."""

import json
import subprocess
import sys
from types import SimpleNamespace

import numpy as np
import pytest

import windswept as ws

FREQUENCY, SWING = 5.0, 0.01


def frame(time):
    """Three straight strands whose tips swing together across the wind, 0.01 m at 5 Hz."""
    along = np.linspace(0.0, 1.0, 5)[:, None] * [0.1, 0.0, 0.0]
    across = np.linspace(0.0, 1.0, 5)[:, None] * [0.0, 0.0, SWING * np.sin(2 * np.pi * FREQUENCY * time)]
    positions = np.concatenate([along + across + [0.0, k, 0.0] for k in range(3)]).astype(np.float32)
    hair = SimpleNamespace(positions=positions, velocities=np.zeros_like(positions), offsets=np.arange(0, 16, 5))
    return SimpleNamespace(time=time, hair=hair)


def test_frames_by_formula():
    film = [frame(k / 60) for k in range(60)]
    found = ws.measure(film, wind=(3.0, 0, 0), start=0.0)
    assert found["strands"] == 3 and found["frames"] == 60
    assert found["swing_m"] == pytest.approx(SWING / np.sqrt(2), rel=1e-3)
    assert found["swing_bundle_m"] == pytest.approx(found["swing_m"]) and found["swing_strands_m"] < 1e-8
    assert found["frequency_hz"] == pytest.approx(FREQUENCY, rel=0.01)
    assert found["lean_degrees"] == pytest.approx(90.0, abs=0.1)
    power, frequency = found["spectrum_power_m2_per_hz"], found["spectrum_frequency_hz"]
    assert power.shape == frequency.shape == (30,) and frequency[power.argmax()] == pytest.approx(FREQUENCY)
    assert ws.measure(film, wind=(3.0, 0, 0), gravity=(1, 0, 0), start=0.0)["lean_degrees"] < 5.0


def test_a_run_its_file_its_frames_and_the_command_say_the_same(scene, tmp_path):
    sim = ws.Simulation(scene.replace(**{"time.frame_rate": 240, "time.duration": 0.1}))
    frames = [sim.frame()]
    with ws.Writer(tmp_path / "run", sim, formats=["vtkhdf"]) as writer:
        writer.append(sim)
        for one in sim.frames():
            writer.append(sim)
            frames.append(one)
    of_run = ws.measure(tmp_path / "run")
    assert of_run["axis"] == [1.0, 0.0, 0.0] and of_run["frames"] == len(frames)
    words = [sys.executable, "-m", "windswept", "measure", str(tmp_path / "run"), "--json"]
    of_command = json.loads(subprocess.run(words, capture_output=True, text=True, check=True).stdout)
    of_file = ws.measure(tmp_path / "run/hair.vtkhdf", wind=(1, 0, 0))
    of_frames = ws.measure(frames, wind=(1, 0, 0))
    for other in (of_file, of_frames, of_command):
        assert other.keys() == of_run.keys()
        for name, number in of_run.items():
            assert np.array_equal(other[name], number), name


def test_what_cannot_be_measured(tmp_path):
    film = [frame(k / 60) for k in range(5)]
    with pytest.raises(ws.ExportError, match="expected at least 8"):
        ws.measure(film, start=0.0)
    with pytest.raises(ValueError, match="wind: expected three finite numbers"):
        ws.measure(film, wind=(1, 2))
    with pytest.raises(ValueError, match="film: expected a path, or frames"):
        ws.measure([1, 2, 3])
    with pytest.raises(ws.ExportError, match="none.vtkhdf"):
        ws.measure(tmp_path / "none.vtkhdf")
    with pytest.raises(ws.SceneError, match=r"scene\.toml"):
        ws.measure(tmp_path)
