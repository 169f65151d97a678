"""Runs one scene with every combination of some values, on this machine or on a Dask cluster.

    from windswept import sweep

    cases = sweep.run(scene, vary={"turbulence.bands.0.scale": [0.006, 0.018], "viscosity.hair": [0.05, 1.4]}, out="sweep")

`out` gets a folder per case (`scene.toml`, `report.json`, `picture.png`, or `error.txt`), `table.csv` of all, and `sheet.png`
of their pictures; where these make no sheet, as pictures of different sizes or too many, a warning says why. Called again it runs what is missing; with `checkpoint_every` a case goes on in its middle.

A script that has no `if __name__ == "__main__":` may call it: cases are processes of their own, which never import the script.
"""

from __future__ import annotations

import csv
import hashlib
import itertools
import json
import os
import subprocess
import sys
import tempfile
import time
import uuid
import warnings
from collections.abc import Generator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from windswept._native import ExportError, Scene, SceneError, Simulation, contact_sheet, write_png

if TYPE_CHECKING:
    from distributed import Client

__all__ = ["Case", "run"]

#: Columns of the table that come from a report.
_REPORTED = ["steps", "time_s", "ms_per_step", "max_stretch", "density_error_rms"]

#: What names of checkpoints begin with.
_CHECKPOINT = "checkpoint-"


@dataclass
class Case:
    """One combination of values."""

    index: int
    #: The case's values, by dotted key.
    values: dict[str, Any]
    folder: Path
    #: "finished" in this call, "skipped" where an earlier call had finished it, or "failed".
    status: str = "waiting"
    #: Number of runs that were started in this call, those that a dead worker left among them.
    attempts: int = 0
    report: dict[str, Any] = field(default_factory=dict)
    #: The case's last fault, also where the case finished in the end.
    error: str | None = None
    _text: str = field(default="", repr=False)
    _log: str = field(default="", repr=False)


@dataclass(frozen=True)
class _Job:
    """What a worker needs to know of a case."""

    text: str
    adapter: str | None
    picture: bool
    #: File of its checkpoint and steps between two; None: it has none.
    checkpoint: tuple[str, int] | None = None


#: Report and PNG of a finished run.
_Result = tuple[dict[str, Any], bytes | None]


def run(
    scene: Scene,
    vary: Mapping[str, Sequence[Any]],
    out: str | os.PathLike[str],
    client: Client | None = None,
    *,
    workers: int = 2,
    retries: int = 2,
    adapter: str | None = None,
    picture: bool = True,
    checkpoint_every: int | None = None,
) -> list[Case]:
    """Runs the scene for its duration with every combination of the values.

    Args:
        scene: what all cases share.
        vary: values by dotted key.
        out: folder of the results; made where it is missing.
        client: a Dask client; None: processes on this machine. Workers on a cluster need windswept and a GPU, but no file
            system in common with us.
        workers: processes at a time, without a client.
        retries: how often a case that fails, or whose worker dies, is started again.
        adapter: as `Simulation`'s.
        picture: whether the last state of each case is drawn.
        checkpoint_every: steps after which a case that runs on this machine writes a checkpoint into its folder, from which
            it goes on when it is started again; None: it starts anew.

    Returns:
        Every case, in the order of the product of the values. A case that fails does not stop the others.

    Raises:
        SceneError: no case makes a scene: a key is unknown, say.
    """
    if not vary or not all(len(values) > 0 for values in vary.values()):
        raise ValueError("vary: expected at least one key with at least one value")
    if workers < 1 or retries < 0:
        raise ValueError(f"expected workers >= 1 and retries >= 0, found {workers} and {retries}")
    if checkpoint_every is not None and checkpoint_every < 1:
        raise ValueError(f"checkpoint_every: expected at least 1 step, found {checkpoint_every}")
    cases = _cases(scene, vary, Path(out))
    missing = [case for case in cases if case.status == "waiting"]
    every = checkpoint_every if client is None else None
    jobs = {case.index: _Job(case._text, adapter, picture, _checkpoint(case, every)) for case in missing}
    work = _locally(missing, jobs, workers, retries) if client is None else _on(client, missing, jobs, retries)
    try:
        for case, result in work:
            _settle(case, result)
            _write_table(cases, vary, Path(out))
    finally:
        work.close()
    _write_table(cases, vary, Path(out))
    _write_sheet(cases, Path(out) / "sheet.png")
    return cases


def _cases(scene: Scene, vary: Mapping[str, Sequence[Any]], out: Path) -> list[Case]:
    cases, faults = [], []
    for index, values in enumerate(itertools.product(*vary.values())):
        case = Case(index, dict(zip(vary, values)), out / f"{index:04}")
        try:
            case._text = scene.replace(**case.values).text
        except SceneError as error:
            case.status, case.error = "failed", str(error)
            faults.append(error)
        cases.append(case)
    if len(faults) == len(cases):
        raise faults[0]
    for case in cases:
        case.folder.mkdir(parents=True, exist_ok=True)
        if case.status == "waiting" and (report := _report(case)):
            case.status, case.report = "skipped", report
        elif case.status == "failed":
            _settle(case, None)
    return cases


def _checkpoint(case: Case, every: int | None) -> tuple[str, int] | None:
    """The file of a case's checkpoint: other scenes have files of other names."""
    if every is None:
        return None
    name = hashlib.sha256(case._text.encode()).hexdigest()[:16]
    return str((case.folder / f"{_CHECKPOINT}{name}").absolute()), every


def _report(case: Case) -> dict[str, Any] | None:
    """The report that the case's folder has, if it is of just this scene and of a run that did not fail."""
    try:
        if (case.folder / "scene.toml").read_bytes() != case._text.encode():
            return None
        report = json.loads((case.folder / "report.json").read_text(encoding="utf-8"))
        return report if isinstance(report, dict) and "failure" not in report else None
    except (OSError, ValueError):
        return None


def _simulate(job: _Job) -> _Result:
    """Runs a case to its end in this process, from its start or from its checkpoint; returns its report and its last picture."""
    path, every = job.checkpoint or ("", 0)
    try:
        sim = Simulation.load(path, adapter=job.adapter)
    except (OSError, ValueError):
        # There is none, or it is not whole.
        sim = Simulation(Scene.parse(job.text), adapter=job.adapter)
    saved = sim.steps
    for _ in sim.frames():
        if every and sim.steps >= saved + every:
            sim.save(path)
            saved = sim.steps
    drawn = None
    if job.picture:
        with tempfile.TemporaryDirectory() as folder:
            write_png(Path(folder) / "picture.png", sim.render())
            drawn = (Path(folder) / "picture.png").read_bytes()
    return sim.report(), drawn


def _simulate_on_a_worker(job: _Job, topic: str) -> _Result:
    """A whole run on a worker, which first tells the scheduler that it has begun: workers that die tell nothing."""
    from distributed import get_worker

    worker = get_worker()
    worker.log_event(topic, worker.address)
    return _simulate(job)


def _locally(
    cases: list[Case], jobs: dict[int, _Job], workers: int, retries: int
) -> Generator[tuple[Case, _Result | None], None, None]:
    """Runs each case in a process of its own: whatever happens to it happens to that case alone."""
    waiting = list(reversed(cases))
    running: dict[subprocess.Popen[bytes], tuple[Case, tempfile.TemporaryDirectory[str]]] = {}
    try:
        while waiting or running:
            while waiting and len(running) < workers:
                case, folder = waiting.pop(), tempfile.TemporaryDirectory()
                case.attempts += 1
                job = jobs[case.index]
                words = {"text": job.text, "adapter": job.adapter, "picture": job.picture, "checkpoint": job.checkpoint}
                (Path(folder.name) / "job.json").write_text(json.dumps(words), encoding="utf-8")
                with open(Path(folder.name) / "log.txt", "wb") as log:
                    command = [sys.executable, "-m", "windswept.sweep", folder.name]
                    process = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=log, stderr=log)
                running[process] = case, folder
            time.sleep(0.02)
            for process in [process for process in running if process.poll() is not None]:
                case, folder = running.pop(process)
                with folder:
                    result = _fetch(case, Path(folder.name), process.returncode)
                if result is None and case.attempts <= retries:
                    waiting.append(case)
                else:
                    yield case, result
    finally:
        for process, (_, folder) in running.items():
            process.kill()
            process.wait()
            folder.cleanup()


def _fetch(case: Case, folder: Path, status: int) -> _Result | None:
    """The result that a process left; without one the process's last words are the case's error."""
    try:
        report = json.loads((folder / "report.json").read_text(encoding="utf-8"))
    except (OSError, ValueError):
        case._log = (folder / "log.txt").read_text(encoding="utf-8", errors="replace").strip()
        # A traceback ends with its error, which may have lines of help below it.
        said = [line for line in case._log.splitlines() if line[:1].strip() and "Error: " in line]
        words = said[-1] if said else case._log[-200:] or "no words"
        case.error = f"the process ended with status {status}: {words}"
        return None
    drawn = folder / "picture.png"
    return report, drawn.read_bytes() if drawn.exists() else None


def _on(
    client: Any, cases: list[Case], jobs: dict[int, _Job], retries: int
) -> Generator[tuple[Case, _Result | None], None, None]:
    """Runs the cases on a cluster, whose scheduler starts again what a worker that died has left."""
    from distributed import as_completed

    topic, submitted = f"windswept-sweep-{uuid.uuid4()}", dict.fromkeys(jobs, 0)

    def start(case: Case) -> Any:
        submitted[case.index] += 1
        return client.submit(_simulate_on_a_worker, jobs[case.index], f"{topic}-{case.index}", pure=False)

    def count(case: Case) -> None:
        workers = [worker for _, worker in client.get_events(f"{topic}-{case.index}")]
        # What did not reach a worker was an attempt too.
        case.attempts = max(len(workers), submitted[case.index])
        if len(workers) > submitted[case.index]:
            case.error = case.error or f"worker {workers[-2]} died while it ran"

    futures = {start(case): case for case in cases}
    completed: Any = as_completed(list(futures))  # type: ignore[no-untyped-call]
    try:
        for future in completed:
            case = futures.pop(future)
            count(case)
            error = future.exception() if future.status == "error" else None
            if future.status == "finished":
                yield case, future.result()
                continue
            case.error = f"{type(error).__name__}: {error}" if error else f"the task was {future.status}"
            if submitted[case.index] <= retries:
                again = start(case)
                futures[again] = case
                completed.add(again)
            else:
                yield case, None
    finally:
        client.cancel(list(futures))


def _settle(case: Case, result: _Result | None) -> None:
    # The folder may hold files of another case that had this number, or of an earlier try.
    for name in ("report.json", "scene.toml", "picture.png", "error.txt"):
        (case.folder / name).unlink(missing_ok=True)
    if result is not None:
        for checkpoint in case.folder.glob(f"{_CHECKPOINT}*"):
            checkpoint.unlink()
    if result is None:
        case.status = "failed"
        _write(case.folder / "error.txt", "\n\n".join(filter(None, [case.error, case._log])) + "\n")
        return
    case.status = "finished"
    case.report, drawn = result
    if drawn is not None:
        _write(case.folder / "picture.png", drawn)
    _write(case.folder / "scene.toml", case._text)
    # The report comes last: who finds it finds a finished case.
    _write(case.folder / "report.json", json.dumps(case.report, indent=2) + "\n")


def _write_table(cases: list[Case], vary: Mapping[str, Sequence[Any]], out: Path) -> None:
    lines: list[list[Any]] = [["case", "status", "attempts", *vary, *_REPORTED, "error"]]
    for case in cases:
        values = [value if isinstance(value, str) else json.dumps(value, default=_plain) for value in case.values.values()]
        reported = [case.report.get(key, "") for key in _REPORTED]
        lines.append([case.folder.name, case.status, case.attempts, *values, *reported, case.error or ""])
    partial = out / "table.csv.part"
    with open(partial, "w", newline="", encoding="utf-8") as file:
        csv.writer(file).writerows(lines)
    os.replace(partial, out / "table.csv")


def _write_sheet(cases: list[Case], path: Path) -> None:
    """Puts the pictures of all cases side by side. The sheet of an earlier call does not stay where there is none now."""
    path.unlink(missing_ok=True)
    pictures = [case.folder / "picture.png" for case in cases if (case.folder / "picture.png").exists()]
    try:
        if pictures:
            contact_sheet(pictures, path)
    except ExportError as error:
        # Cameras may be what varies.
        warnings.warn(f"{path} is not made: {error}", stacklevel=3)


def _plain(value: Any) -> Any:
    """A number or an array of NumPy as Python's own; anything that no scene takes as its words."""
    return value.tolist() if hasattr(value, "tolist") else str(value)


def _write(path: Path, content: str | bytes) -> None:
    """Writes a file whole or not at all."""
    partial = path.with_name(path.name + ".part")
    partial.write_bytes(content.encode() if isinstance(content, str) else content)
    os.replace(partial, path)


def _main(folder: Path) -> None:
    """Runs the case of a folder: `python -m windswept.sweep FOLDER` is the process of a case."""
    job = _Job(**json.loads((folder / "job.json").read_text(encoding="utf-8")))
    report, drawn = _simulate(job)
    if drawn is not None:
        (folder / "picture.png").write_bytes(drawn)
    _write(folder / "report.json", json.dumps(report))


if __name__ == "__main__":
    _main(Path(sys.argv[1]))
