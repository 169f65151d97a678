"""Sweeps: in processes, on a cluster, with faults, with workers that die."""

import csv
import json
import os
import signal
import threading
import time
import types

import numpy as np
import pytest

import windswept as ws
from windswept import sweep

VARY = {"viscosity.hair": [0.05, 1.4], "air.wind": [[3.0, 0.0, 0.0], [5.0, 0.0, 0.0]]}


@pytest.fixture
def short(scene):
    return scene.replace(**{"time.duration": 0.02, "camera.width": 96, "camera.height": 64})


def table(out):
    with open(out / "table.csv", newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def test_every_combination_gets_its_folder_and_its_line(short, tmp_path):
    image = pytest.importorskip("PIL.Image")
    cases = sweep.run(short, VARY, tmp_path)
    assert [case.status for case in cases] == ["finished"] * 4
    assert [list(case.values.values()) for case in cases] == [[c, u] for c in VARY["viscosity.hair"] for u in VARY["air.wind"]]
    for case in cases:
        assert case.report["steps"] == 14 and case.attempts == 1 and case.error is None
        assert ws.Scene.load(case.folder / "scene.toml") == short.replace(**case.values)
        assert image.open(case.folder / "picture.png").size == (96, 64)
    lines = table(tmp_path)
    assert [line["viscosity.hair"] for line in lines] == ["0.05", "0.05", "1.4", "1.4"]
    assert lines[1]["air.wind"] == "[5.0, 0.0, 0.0]" and float(lines[0]["max_stretch"]) >= 0.0
    assert image.open(tmp_path / "sheet.png").width >= 2 * 96
    # A second call has nothing to do; a case that is not as it was, or not there, is run.
    reports = [os.stat(case.folder / "report.json").st_mtime_ns for case in cases]
    assert [case.status for case in sweep.run(short, VARY, tmp_path)] == ["skipped"] * 4
    (tmp_path / "0002" / "report.json").unlink()
    assert [case.status for case in sweep.run(short, VARY, tmp_path)] == ["skipped", "skipped", "finished", "skipped"]
    assert os.stat(tmp_path / "0001" / "report.json").st_mtime_ns == reports[1]
    # Nor is one finished whose run blew up, as the command's report says.
    failed = {**cases[3].report, "failure": {"step": 3, "time_s": 0.004, "why": "not finite"}}
    (tmp_path / "0003" / "report.json").write_text(json.dumps(failed), encoding="utf-8")
    assert [case.status for case in sweep.run(short, VARY, tmp_path)] == ["skipped"] * 3 + ["finished"]
    # Other values of the same number are other cases, of which nothing of the old ones is left; NumPy's are as good.
    seeds = {"seed": np.array([7]), "air.wind": [np.array([4.0, 0.0, 0.0], np.float32)]}
    (other,) = sweep.run(short, seeds, tmp_path, picture=False)
    assert other.status == "finished" and not (other.folder / "picture.png").exists()
    assert (table(tmp_path)[0]["seed"], table(tmp_path)[0]["air.wind"]) == ("7", "[4.0, 0.0, 0.0]")


def test_a_case_keeps_its_film_and_the_numbers_of_each(short, tmp_path, monkeypatch):
    image = pytest.importorskip("PIL.Image")
    bars = []
    monkeypatch.setattr("tqdm.auto.tqdm", lambda work, words, count, **_: bars.append(count) or work)
    filmed = short.replace(**{"time.frame_rate": 1000.0})

    def each(case):
        return {"swing_m": ws.measure(case.folder)["swing_m"], "index": case.index}

    cases = sweep.run(filmed, {"turbulence.scale": [0.006, 0.009]}, tmp_path, film="vtkhdf", each=each)
    assert [case.numbers["index"] for case in cases] == [0, 1] and cases[0].numbers["swing_m"] > 0.0
    assert [float(line["swing_m"]) for line in table(tmp_path)] == [case.numbers["swing_m"] for case in cases]
    assert bars == [2] and (cases[0].folder / "air.vtkhdf").exists()
    # The sheet says the values; the pictures do not.
    with image.open(tmp_path / "sheet.png") as sheet, image.open(cases[0].folder / "picture.png") as picture:
        corner = (0, 0, 96, 16)
        assert sheet.convert("RGB").crop(corner).tobytes() != picture.convert("RGB").crop(corner).tobytes()
    # A film that is missing is made, and numbers of cases that were finished are there too.
    (cases[1].folder / "hair.vtkhdf").unlink()
    (cases[1].folder / "air.vtkhdf").unlink()
    again = sweep.run(filmed, {"turbulence.scale": [0.006, 0.009]}, tmp_path, film="vtkhdf", each=each)
    assert [case.status for case in again] == ["skipped", "finished"]
    assert [case.numbers for case in again] == [case.numbers for case in cases]
    # A function that fails leaves the sheet, and the table of what it did.
    (tmp_path / "sheet.png").unlink()

    def fails(case):
        return {"swing_m": 1.0} if case.index == 0 else {}["missing"]

    with pytest.raises(KeyError, match="missing"):
        sweep.run(filmed, {"turbulence.scale": [0.006, 0.009]}, tmp_path, film="vtkhdf", each=fails)
    assert table(tmp_path)[0]["swing_m"] == "1.0" and (tmp_path / "sheet.png").exists()
    for wrong in ({"film": "gif"}, {"film": "vtkhdf", "checkpoint_every": 5}):
        with pytest.raises(ValueError, match="film"):
            sweep.run(short, {"seed": [1]}, tmp_path, **wrong)


def test_an_ensemble_has_a_mean_and_a_spread(short, tmp_path):
    numbers = []

    def each(case):
        numbers.append(float(np.linalg.norm(case.report["momentum_kg_m_per_s"])))
        return {"momentum": numbers[-1], "words": "left out"}

    spread = ws.ensemble(short, [3, 4, 5], tmp_path, key="air.seed", picture=False, each=each)
    assert len(set(numbers)) == 3 == len(spread.cases)
    assert spread.mean["momentum"] == pytest.approx(np.mean(numbers))
    assert spread.spread["momentum"] == pytest.approx(np.std(numbers, ddof=1))
    assert (spread.mean["steps"], spread.spread["steps"]) == (14, 0) and "words" not in spread.mean
    with pytest.raises(RuntimeError, match="no case finished: .*picture.hairs"):
        ws.ensemble(short.replace(**{"picture.hairs": 1_000_000}), [1], tmp_path / "none", retries=0)


def test_pictures_that_make_no_sheet_are_told_of(short, tmp_path):
    (tmp_path / "sheet.png").write_bytes(b"of an earlier call")
    with pytest.warns(UserWarning, match="sheet.png is not made: the pictures of a contact sheet differ in size"):
        cases = sweep.run(short, {"camera.width": [96, 64]}, tmp_path)
    assert [case.status for case in cases] == ["finished"] * 2
    assert not (tmp_path / "sheet.png").exists() and all((case.folder / "picture.png").exists() for case in cases)


def test_a_case_that_fails_stops_no_other(short, tmp_path):
    # More hairs than the adapter draws fail when they are drawn; a length that is none, at once.
    cases = sweep.run(short, {"picture.hairs": [100, 1_000_000]}, tmp_path / "drawn", retries=1)
    assert [(case.status, case.attempts) for case in cases] == [("finished", 1), ("failed", 2)]
    assert cases[1].error.startswith("the process ended with status 1: windswept.ExportError: picture.hairs: 1000000 hairs")
    said = (cases[1].folder / "error.txt").read_text()
    assert cases[1].error in said and "Traceback" in said
    assert table(tmp_path / "drawn")[1]["status"] == "failed"
    # A folder that had a finished case has one no more.
    (failed,) = sweep.run(short, {"picture.hairs": [1_000_000]}, tmp_path / "drawn", retries=0)
    assert [path.name for path in failed.folder.iterdir()] == ["error.txt"]
    cases = sweep.run(short, {"hair.length": [-1.0, 0.02]}, tmp_path / "scenes")
    assert [case.status for case in cases] == ["failed", "finished"] and "hair.length" in cases[0].error
    with pytest.raises(ws.SceneError, match="did you mean"):
        sweep.run(short, {"hair.lenght": [0.1, 0.2]}, tmp_path / "none")
    with pytest.raises(ValueError, match="vary"):
        sweep.run(short, {}, tmp_path / "none")


def test_a_process_that_dies_is_started_again(short, tmp_path, monkeypatch):
    started = []
    popen = sweep.subprocess.Popen

    def killed_first(*words, **more):
        process = popen(*words, **more)
        started.append(process)
        if len(started) == 1:
            process.kill()
        return process

    monkeypatch.setattr(sweep.subprocess, "Popen", killed_first)
    cases = sweep.run(short, {"viscosity.hair": [0.05, 1.4]}, tmp_path)
    assert [case.status for case in cases] == ["finished", "finished"]
    assert [case.attempts for case in cases] == [2, 1] and "status -9" in cases[0].error
    assert len(started) == 3


def test_a_case_goes_on_in_its_middle(short, tmp_path, monkeypatch):
    longer, vary = short.replace(**{"time.duration": 0.2}), {"viscosity.hair": [0.05]}
    (whole,) = sweep.run(longer, vary, tmp_path / "whole", picture=False)
    popen, killers = sweep.subprocess.Popen, []

    def killed_behind_its_checkpoint(*words, **more):
        process = popen(*words, **more)

        def kill():
            # Not the one that is still being written, with .part behind its name.
            while not list((tmp_path / "killed" / "0000").glob("checkpoint-" + 16 * "?")):
                time.sleep(0.005)
            process.kill()

        killers.append(threading.Thread(target=kill))
        killers[-1].start()
        return process

    monkeypatch.setattr(sweep.subprocess, "Popen", killed_behind_its_checkpoint)
    (case,) = sweep.run(longer, vary, tmp_path / "killed", picture=False, retries=0, checkpoint_every=10)
    killers[0].join()
    assert case.status == "failed" and "status -9" in case.error
    # Goes on in this process, which may not make a simulation of a scene.
    job = sweep._Job(case._text, None, False, sweep._checkpoint(case, 10))
    with monkeypatch.context() as only_loads:
        only_loads.setattr(sweep, "Simulation", types.SimpleNamespace(load=ws.Simulation.load))
        report, _ = sweep._simulate(job)
    figures = ["steps", "max_stretch", "momentum_kg_m_per_s", "strand_steps", "density_error_rms"]
    assert [report[key] for key in figures] == [whole.report[key] for key in figures]
    # The sweep itself goes on too, and leaves no checkpoint. One of another scene is not its.
    monkeypatch.setattr(sweep.subprocess, "Popen", popen)
    (case,) = sweep.run(longer, vary, tmp_path / "killed", picture=False, checkpoint_every=10)
    assert case.status == "finished" and [case.report[key] for key in figures] == [whole.report[key] for key in figures]
    assert sorted(path.name for path in case.folder.iterdir()) == ["report.json", "scene.toml"]
    with pytest.raises(ValueError, match="checkpoint_every"):
        sweep.run(longer, vary, tmp_path / "killed", checkpoint_every=0)


def test_a_cluster_goes_on_when_a_worker_is_killed(short, tmp_path, monkeypatch):
    distributed = pytest.importorskip("distributed")
    longer = short.replace(**{"time.duration": 0.1})
    monkeypatch.setattr(sweep, "uuid", types.SimpleNamespace(uuid4=lambda: "known"))
    with distributed.LocalCluster(n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None) as cluster:
        with distributed.Client(cluster) as client:
            pids = client.run(os.getpid)
            assert len(pids) == 2
            killed = []

            def kill():
                # As soon as the first case has begun; it takes half a second at least.
                while not (begun := client.get_events("windswept-sweep-known-0")):
                    time.sleep(0.02)
                killed.append(begun[0][1])
                os.kill(pids[killed[0]], signal.SIGKILL)

            killer = threading.Thread(target=kill)
            killer.start()
            cases = sweep.run(longer, VARY, tmp_path, client)
            killer.join()
            assert pids[killed[0]] not in client.run(os.getpid).values()
    assert [case.status for case in cases] == ["finished"] * 4
    assert cases[0].attempts == 2 and cases[0].error == f"worker {killed[0]} died while it ran"
    assert table(tmp_path)[0]["attempts"] == "2" and "died" in table(tmp_path)[0]["error"]
    assert all(case.report["steps"] == 72 and (case.folder / "picture.png").exists() for case in cases)
    assert [line["status"] for line in table(tmp_path)] == ["finished"] * 4
