"""Simulations: stepping, arrays, frames, reports, threads, interrupts."""

import gc
import json
import os
import signal
import subprocess
import sys
import threading
import time
import weakref

import numpy as np
import pytest

import windswept as ws
from conftest import SCENE


def test_time_passes_in_steps(sim):
    assert (sim.time, sim.steps, sim.dt) == (0.0, 0, 1.38e-3)
    sim.step()
    sim.step(4)
    assert sim.steps == 5 and sim.time == pytest.approx(6.9e-3)
    sim.run(0.00414)
    assert sim.steps == 8
    assert sim.scene.title == "Small" and "llvmpipe" in sim.adapter


def test_arrays_are_float32_of_the_state_now_and_the_callers_own(sim):
    sim.step(3)
    for array, shape in [
        (sim.hair.positions, (48, 3)),
        (sim.hair.velocities, (48, 3)),
        (sim.hair.orientations, (40, 4)),
        (sim.air.positions, (len(sim.air.positions), 3)),
        (sim.air.velocities, sim.air.positions.shape),
    ]:
        assert array.dtype == np.float32 and array.shape == shape
        assert array.flags.c_contiguous and array.flags.writeable and array.flags.aligned
        assert np.isfinite(array).all()
    # No two arrays share memory, and they outlive what they came from.
    frame = sim.frame()
    arrays = [sim.hair.positions, sim.hair.positions, frame.hair.positions, frame.hair.velocities, frame.air.positions]
    del frame
    assert not any(np.shares_memory(a, b) for i, a in enumerate(arrays) for b in arrays[:i])
    assert all(np.array_equal(arrays[0], array) for array in arrays[1:3])
    assert sim.hair.offsets.tolist() == list(range(0, 49, 6))
    assert np.allclose(np.linalg.norm(sim.hair.orientations, axis=1), 1.0, atol=1e-5)
    before = sim.hair.positions
    kept = before.copy()
    before[:] = 7.0
    assert np.array_equal(sim.hair.positions, kept)
    sim.step(2)
    assert not np.array_equal(sim.hair.positions, kept)
    low, high = sim.air.box
    assert (low == 0).all() and np.allclose(high, [0.06, 0.045, 0.045])
    assert (sim.air.positions >= low).all() and (sim.air.positions <= high).all()
    assert sim.air.vorticity.shape == sim.air.density_ratio.shape == sim.air.positions.shape[:1]
    assert 0.5 < sim.air.density_ratio.mean() < 1.2


def test_the_same_scene_gives_the_same_bits(scene):
    runs = [ws.Simulation(scene) for _ in range(2)]
    runs[0].step(7)
    for _ in range(7):
        runs[1].step()
    assert np.array_equal(runs[0].air.positions, runs[1].air.positions)
    assert np.array_equal(runs[0].hair.positions, runs[1].hair.positions)


def test_frames_come_at_the_scenes_rate(sim):
    frames = sim.frames(2)
    assert len(frames) == 2
    first = next(frames)
    # 60 a second in steps of 1.38 ms: frame 1 after round(12.08) steps.
    assert first.step == 12 and first.time == pytest.approx(12 * 1.38e-3)
    assert len(frames) == 1
    assert [frame.step for frame in frames] == [24] and list(frames) == []
    kept = first.hair.positions.copy()
    sim.step(3)
    assert np.array_equal(first.hair.positions, kept)
    assert first.hair.offsets.tolist() == sim.hair.offsets.tolist() and len(first.air.positions) == len(sim.air.positions)
    # Off a frame, the next one is the next; without a number they go on to the scene's duration, 36 steps.
    assert [frame.step for frame in sim.frames()] == [36]
    assert len(sim.frames()) == 0
    assert sim.frame().step == 36


def test_frames_wrap_in_tqdm(bare):
    tqdm = pytest.importorskip("tqdm")
    sim = ws.Simulation(bare, groom=ws.Groom([[[0, 0, 0], [0.01, 0, 0], [0.02, 0, 0]]]))
    bar = tqdm.tqdm(sim.frames(3), disable=True)
    assert len(bar) == 3 and len(list(bar)) == 3


def test_a_callback_drives_and_ends_a_run(bare):
    points = np.zeros((2, 5, 3))
    points[:, :, 1] = -np.linspace(0, 0.04, 5)
    points[1, :, 0] = 0.1
    sim = ws.Simulation(bare, groom=ws.Groom(points))
    roots = points[:, 0]

    def shake(sim):
        sim.set_roots(roots + [0.002 * np.sin(100.0 * sim.time), 0.0, 0.0])

    sim.run(0.03, callback=shake)
    moved = 0.002 * np.sin(100.0 * (sim.time - sim.dt))
    assert np.allclose(sim.hair.positions[::5], roots + [moved, 0, 0], atol=1e-6)
    calls = []
    sim.run(0.05, callback=lambda sim: calls.append(sim.steps) or len(calls) < 3, every=4)
    assert np.diff(calls).tolist() == [4, 4]
    steps = sim.steps
    sim.run(0.05, callback=lambda sim: np.float32(sim.time) < 0)
    assert sim.steps == steps + 1, "NumPy's False"
    sim.run(2 * sim.dt, callback=lambda sim: [])
    assert sim.steps == steps + 3, "an empty list is no False"
    with pytest.raises(ZeroDivisionError):
        sim.run(0.01, callback=lambda sim: 1 / 0)


def test_roots_turn_with_their_frames(bare):
    points = np.zeros((1, 5, 3))
    points[0, :, 0] = np.linspace(0, 0.01, 5)
    sim = ws.Simulation(bare.replace(gravity=[0, 0, 0], **{"rods.damping": 50.0}), groom=ws.Groom(points))
    x, y, z, w = sim.hair.orientations[0].astype(float)
    half = np.sqrt(0.5)
    # A quarter turn about y, q' = r q.
    sim.set_roots([[0, 0, 0]], frames=[[half * x + half * z, half * y + half * w, half * z - half * x, half * w - half * y]])
    sim.run(0.5)
    assert np.allclose(sim.hair.positions[-1], [0, 0, -0.01], atol=1e-4)


def test_air_and_hair_can_be_put_elsewhere(sim):
    velocities = sim.air.velocities
    velocities[:, 1] += 0.5
    sim.set_air(velocities=velocities)
    assert np.array_equal(sim.air.velocities, velocities)
    shifted = sim.air.positions.astype(float) + [0.06, 0.0, -0.045]
    here = sim.air.positions
    sim.set_air(positions=shifted)
    # f32 of a box of 60 mm.
    assert np.abs((sim.air.positions - here + 0.03) % 0.06 - 0.03).max() < 1e-7
    hair = sim.hair.positions
    sim.set_hair(positions=hair + np.float32(0.001), velocities=np.ones((48, 3)))
    assert np.allclose(sim.hair.positions[1:6], hair[1:6] + 0.001, atol=1e-7)
    assert np.allclose(sim.hair.positions[0], hair[0], atol=1e-7), "roots are held"
    sim.step(2)
    assert np.isfinite(sim.hair.positions).all()


def test_the_wind_can_be_turned(sim, bare):
    sim.step(3)
    before = sim.air.velocities.mean(axis=0)
    sim.set_wind([3.0, 0.0, 1.5])
    sim.step(1)
    change = sim.air.velocities.mean(axis=0) - before
    # All air takes the change in that step; the fringe, hair and neighbours add less than 0.1 m/s.
    assert change == pytest.approx([0.0, 0.0, 1.5], abs=0.1)
    assert "wind = [3.0, 0.0, 1.5]" in sim.scene.text and ws.Scene.parse(sim.scene.text) == sim.scene
    for bad in ([1.0, 2.0], 3.0, [np.nan, 0, 0], [[1, 2, 3]], "fast", None):
        with pytest.raises(ValueError, match="wind"):
            sim.set_wind(bad)
    alone = ws.Simulation(bare, groom=ws.Groom([[[0, 0, 0], [0.01, 0, 0]]]))
    with pytest.raises(ValueError, match="wind"):
        alone.set_wind([1, 0, 0])
    # A wind that swings passes through what is nearly zero.
    sim.set_wind([0.002 * np.sin(np.pi), 0.0, 1e-30])
    sim.step(1)
    assert "wind = [0.0, 0.0, 0.0]" in sim.scene.text and np.isfinite(sim.air.velocities).all()


def test_a_force_pushes_hair_and_air(sim, bare):
    hair, air = np.zeros_like(sim.hair.positions), np.zeros_like(sim.air.positions)
    other = ws.Simulation(sim.scene)
    # Arrays, and a callback that says the same: the same bits.
    sim.set_force(hair + [0, 30, 0], air=air + [0, 0, 300])
    other.set_force(callback=lambda frame: (hair + [0, 30, 0], air + [0, 0, 300]))
    before = sim.air.velocities.mean(axis=0)
    sim.step(3)
    other.step(3)
    assert np.array_equal(sim.hair.positions, other.hair.positions)
    assert np.array_equal(sim.air.velocities, other.air.velocities)
    # Hair holds some of the air back.
    given = 3 * sim.dt * 300
    assert 0.7 * given < sim.air.velocities.mean(axis=0)[2] - before[2] < given
    for name, bad in (("hair", {"hair": hair[1:]}), ("air", {"air": air[1:]}), ("hair", {"hair": hair + np.nan})):
        with pytest.raises(ValueError, match=name):
            sim.set_force(**bad)
    for bad in (3, "fast"):
        with pytest.raises(ValueError, match="callback"):
            sim.set_force(callback=bad)
    with pytest.raises(ValueError, match="callback"):
        sim.set_force(hair, callback=lambda frame: None)
    sim.set_force(callback=lambda frame: 3)
    with pytest.raises(ValueError, match="callback: returned what is no acceleration: hair: expected shape"):
        sim.step()
    sim.set_force()
    # Loose hair falls up.
    loose = ws.Simulation(bare, groom=ws.Groom([[[0, 0, 0], [0.01, 0, 0]]], root="free"))
    loose.set_force(np.float32([[0, 19.62, 0]] * 2))
    loose.step(10)
    assert loose.hair.velocities == pytest.approx(np.float32([[0, 9.81 * 10 * loose.dt, 0]] * 2), abs=1e-5)


def test_a_callback_is_asked_before_each_step(sim):
    asked = []

    def force(frame):
        # The simulation can be looked at meanwhile.
        asked.append((frame.step, sim.steps, frame.time == sim.time))
        if frame.step == 15:
            raise KeyError("enough")
        return None if frame.step < 5 else (np.zeros_like(frame.hair.positions), None)

    sim.set_force(callback=force)
    sim.step(0)
    assert asked == []
    sim.step(3)
    next(sim.frames(1))
    assert asked == [(k, k, True) for k in range(sim.steps)]
    with pytest.raises(KeyError, match="enough"):
        sim.step(20)
    assert sim.steps == 15
    sim.set_force()
    sim.step(2)
    assert sim.steps == 17 and len(asked) == 16
    for wrong in ((1, 2, 3), np.zeros(3), "fast"):
        sim.set_force(callback=lambda frame, wrong=wrong: wrong)
        with pytest.raises(ValueError, match="callback|hair"):
            sim.step(1)


def test_a_callback_does_not_keep_its_simulation_alive(bare):
    sim = ws.Simulation(bare, groom=ws.Groom([[[0, 0, 0], [0.01, 0, 0]]]))
    marker = type("Marker", (), {})()
    sim.set_force(callback=lambda frame, sim=sim, marker=marker: None)
    alive = weakref.ref(marker)
    del sim, marker
    gc.collect()
    assert alive() is None


def test_the_eddies_have_the_energy_of_their_band():
    # Without hair, all of the box's volume is the air's.
    scene = ws.Scene.parse(SCENE[: SCENE.index("[hair]")] + SCENE[SCENE.index("[air]") :])
    sim = ws.Simulation(scene.replace(**{"turbulence": {"bands": [{"scale": 0.006}, {"scale": 0.009}]}}))
    v = 0.2 * np.random.default_rng(2).normal(size=sim.air.velocities.shape)
    sim.set_air(velocities=v + [3.0, 0.0, 0.0])
    energies = sim.spectrum([0.006, 0.009])
    assert energies.dtype == np.float64 and energies[0] > energies[1] > 0
    low, high = sim.air.box
    volume = float(np.prod(high - low)) / len(v)
    u = ws.ops.band_velocity(sim.air.positions - low, v, mass=1.29 * volume, rest_density=1.29, scale=0.006, box=high - low)
    assert energies[0] == pytest.approx(0.5 * (u.astype(float) ** 2).sum(1).mean(), rel=1e-5)
    assert sim.air.band_energy.shape == v.shape[:1]
    assert sim.air.band_energy.mean() == pytest.approx(energies[0], rel=1e-4)
    assert [band["m2_per_s2"] for band in sim.report()["band_energy"]] == energies.tolist()
    for bad in (0.006, [[0.006]], [0.0], [-1.0], [np.nan], [1e-7], "small", None):
        with pytest.raises(ValueError, match="scale"):
            sim.spectrum(bad)
    assert len(ws.Simulation(scene).air.band_energy) == 0


def test_any_layout_and_width_of_floats_comes_in(sim):
    v = np.random.default_rng(1).normal(size=sim.air.velocities.shape)
    wide = np.zeros((len(v), 7))
    wide[:, 1:6:2] = v
    frozen = v.copy()
    frozen.flags.writeable = False
    odd = np.frombuffer(b"." + v.tobytes(), dtype=float, offset=1).reshape(v.shape)
    for array in (v, v.astype(np.float32), np.asfortranarray(v), wide[:, 1:6:2], frozen, v.astype(">f8"), v.tolist(), odd,
                  v.astype(np.longdouble)):
        sim.set_air(velocities=array)
        assert np.allclose(sim.air.velocities, v, atol=1e-6)
    sim.set_air(velocities=v.astype(np.float16))
    assert np.allclose(sim.air.velocities, v, atol=2e-3)


def test_arrays_that_do_not_fit_are_named(sim):
    n = len(sim.air.positions)
    for call, name, value in [
        (sim.set_air, "velocities", np.zeros((n, 2))),
        (sim.set_air, "velocities", np.zeros((n + 1, 3))),
        (sim.set_air, "positions", np.full((n, 3), np.nan)),
        (sim.set_air, "positions", np.zeros((n, 3), dtype=object)),
        (sim.set_air, "positions", np.zeros((n, 3), dtype=bool)),
        (sim.set_air, "positions", np.ma.masked_array(np.zeros((n, 3)), mask=np.arange(3 * n).reshape(n, 3) == 5)),
        (sim.set_hair, "orientations", np.zeros((40, 3))),
        (sim.set_hair, "orientations", np.zeros((40, 4))),
        (sim.set_hair, "positions", np.zeros((47, 3))),
        (sim.set_roots, "positions", np.zeros((7, 3))),
        (sim.set_roots, "positions", np.full((8, 3), np.inf)),
        # Finite, but not in float32.
        (sim.set_air, "velocities", np.full((n, 3), 1e39)),
        (sim.set_hair, "positions", np.full((48, 3), -1e39)),
        (sim.set_roots, "positions", np.full((8, 3), 1e39)),
    ]:
        with pytest.raises(ValueError, match=name):
            call(**{name: value})
    with pytest.raises(ValueError, match="frames"):
        sim.set_roots(np.zeros((8, 3)), frames=np.zeros((8, 4)))
    for bad in (-1, 2**40, 2**63 - 1):
        with pytest.raises(ValueError):
            sim.step(bad)
    for bad in (-1.0, float("nan"), float("inf"), 1e30):
        with pytest.raises(ValueError, match="duration"):
            sim.run(bad)


def test_the_report_is_the_commands(sim):
    sim.step(3)
    report = sim.report()
    assert report["schema"] == 2 and report["steps"] == 3 and report["particles"]["hair"] == 48
    assert report["ms_per_step"] > 0 and report["max_stretch"] >= 0


def test_a_trace_has_the_timed_passes(sim, tmp_path):
    sim.keep_trace()
    sim.step(3)
    sim.write_trace(tmp_path / "trace.json")
    bars = json.loads((tmp_path / "trace.json").read_text())["traceEvents"]
    assert {bar["name"].split(":")[0] for bar in bars} == {row["pass"] for row in sim.report()["passes"]}
    with pytest.raises(OSError):
        sim.write_trace(tmp_path / "nowhere" / "trace.json")


def test_it_shows_what_it_is(sim):
    sim.step(4)
    for shown in (repr(sim), sim._repr_html_()):
        for word in ("Small", "48", str(len(sim.air.positions)), "llvmpipe", "ms per step"):
            assert word in shown
    assert "8 strands" in repr(sim.hair) and "particles" in repr(sim.air) and "Frame" in repr(sim.frame())
    assert "<script>" not in ws.Simulation(sim.scene.replace(title="<script>"))._repr_html_()


def test_an_adapter_that_is_not_there_is_a_gpu_error(scene):
    assert ws.adapters() and {"name", "backend", "kind"} <= set(ws.adapters()[0])
    with pytest.raises(ws.GpuError, match="no such thing"):
        ws.Simulation(scene, adapter="no such thing")
    assert issubclass(ws.GpuError, RuntimeError)
    assert "llvmpipe" in repr(ws.Simulation(scene, adapter="software"))


@pytest.mark.skipif(not os.path.isdir("/proc/self/task"), reason="counts threads as Linux does")
def test_an_adapter_has_one_device_whatever_it_is_called(sim):
    # A device of the software adapter comes with a thread for each core, and more.
    threads = len(os.listdir("/proc/self/task"))
    name = next(adapter["name"] for adapter in ws.adapters() if adapter["name"] in sim.adapter)
    others = [ws.Simulation(sim.scene, adapter=part) for part in (name, name[:5], name[:5].upper())]
    assert len({sim.adapter, *(other.adapter for other in others)}) == 1
    assert len(os.listdir("/proc/self/task")) <= threads + 1


def test_two_simulations_run_on_two_threads(scene):
    alone = ws.Simulation(scene)
    alone.step(12)
    sims = [ws.Simulation(scene) for _ in range(2)]
    threads = [threading.Thread(target=sim.step, args=(12,)) for sim in sims]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    for sim in sims:
        assert np.array_equal(sim.air.positions, alone.air.positions)
    # One simulation, many writers: each takes its steps.
    before = alone.steps
    threads = [threading.Thread(target=alone.step, args=(5,)) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert alone.steps == before + 20
    # One simulation, many readers.
    seen = []
    readers = [threading.Thread(target=lambda: seen.append(sims[0].hair.positions.sum())) for _ in range(4)]
    sims[0].step(1)
    for thread in readers:
        thread.start()
    for thread in readers:
        thread.join()
    assert len(set(seen)) == 1


def test_the_interpreter_is_free_while_stepping(sim):
    # Held, the interpreter would let no thread pass between the two lines around the call.
    turns, done = [0], threading.Event()

    def turn():
        while not done.is_set():
            turns[0] += 1
            time.sleep(0)

    other = threading.Thread(target=turn)
    other.start()
    before = turns[0]
    sim.step(40)
    passed = turns[0] - before
    done.set()
    other.join()
    # One at each switch between the two threads, were it held; measured thousands.
    assert passed > 100, passed


@pytest.fixture
def interruptible():
    """What a shell starts in the background ignores SIGINT, and hands that on."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


def test_ctrl_c_stops_between_steps(sim, interruptible):
    timer = threading.Timer(0.5, os.kill, (os.getpid(), signal.SIGINT))
    timer.start()
    # Minutes of steps: what did not hear Ctrl-C would make them all.
    with pytest.raises(KeyboardInterrupt):
        sim.step(100_000)
    steps = sim.steps
    assert 0 < steps < 100_000
    sim.step(1)
    assert sim.steps == steps + 1 and np.isfinite(sim.hair.positions).all()


def test_ctrl_c_stops_while_hair_settles(interruptible):
    scene = ws.Scene.parse(SCENE)
    scene["time.settle"] = 10.0
    scene["hair.strands"], scene["hair.points"] = 2000, 60
    timer = threading.Timer(1.0, os.kill, (os.getpid(), signal.SIGINT))
    timer.start()
    # Minutes of steps: what did not hear Ctrl-C would make them all. Measured 0.7 s after it.
    with pytest.raises(KeyboardInterrupt):
        ws.Simulation(scene)
    ws.Simulation(ws.Scene.parse(SCENE)).step()


FORKED = """
import multiprocessing, sys
import windswept as ws

def work(_):
    sim = ws.Simulation(ws.Scene.parse(sys.argv[1]))
    sim.step(2)
    return sim.hair.positions.tobytes()

here = work(0)
with multiprocessing.get_context("fork").Pool(2) as pool:
    there = pool.map_async(work, range(2)).get(60)
print("as here" if set(there) == {here} else "other numbers")
"""

DAEMON = """
import sys, threading, time
import windswept as ws

sim = ws.Simulation(ws.Scene.parse(sys.argv[1]))
threading.Thread(target=lambda: sim.step(10**6), daemon=True).start()
while sim.steps == 0:
    time.sleep(0.01)
print("main ends")
"""


@pytest.mark.skipif(not hasattr(os, "fork"), reason="the system does not fork")
@pytest.mark.parametrize(("program", "said"), [(FORKED, "as here"), (DAEMON, "main ends")])
def test_programs_that_fork_or_leave_a_thread_behind_end_well(program, said):
    done = subprocess.run([sys.executable, "-c", program, SCENE], capture_output=True, text=True, timeout=120)
    assert (done.returncode, done.stdout.strip()) == (0, said), done.stderr


@pytest.mark.skipif(not os.path.isfile("/proc/self/statm"), reason="reads the memory as Linux tells it")
def test_simulations_leave_no_memory_behind(scene):
    def resident():
        gc.collect()
        with open("/proc/self/statm") as file:
            return int(file.read().split()[1]) * os.sysconf("SC_PAGE_SIZE")

    def some(count):
        for _ in range(count):
            ws.Simulation(scene).step()

    some(10)
    before = resident()
    some(40)
    # Measured below 10 kB a simulation.
    assert resident() - before < 40 * 1_000_000


def test_a_lost_device_is_an_error_and_the_process_goes_on(scene, tmp_path):
    sim, other = ws.Simulation(scene), ws.Simulation(scene)
    sim.step(2)
    kept = sim.hair.positions
    sim._lose_device()
    # Whoever comes first, and whoever shares the device.
    for use in [
        lambda: other.step(),
        lambda: sim.step(),
        lambda: sim.frame(),
        lambda: sim.render(64, 48),
        lambda: sim.air.density_ratio,
        lambda: sim.save(tmp_path / "lost.windswept"),
    ]:
        with pytest.raises(ws.GpuError, match="lost"):
            use()
    assert not any(tmp_path.iterdir())
    # What could be told without the device still can.
    assert sim.steps == 2 and sim.scene == scene and "2" in repr(sim)
    anew = ws.Simulation(scene)
    anew.step(2)
    assert np.array_equal(anew.hair.positions, kept)


def test_what_a_start_warns_of_is_a_user_warning(bare):
    points = np.zeros((3, 12, 3))
    points[..., 0] = np.linspace(0.0, 0.2, 12)
    points[..., 2] = 0.01 * np.arange(3)[:, None]
    with pytest.warns(UserWarning) as caught:
        sim = ws.Simulation(bare, groom=ws.Groom(points, rest="hanging"))
    said = [str(warning.message) for warning in caught]
    assert any(words.startswith("groom: 3 of 3 strands are") for words in said), said
    # Each once, in the words of the report; the line is the caller's.
    assert sorted(said) == sorted(f"{warning['key']}: {warning['text']}" for warning in sim.report()["warnings"])
    assert {warning.filename for warning in caught} == {__file__}
