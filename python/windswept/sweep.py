"""Runs one scene with every combination of some values, on this machine or on a Dask cluster.

    import windswept as ws

    scene = ws.Scene.load("examples/scenes/quick.toml")     # eddies enter with its wind
    cases = ws.sweep.run(
        scene,
        vary={"turbulence.scale": [0.006, 0.018], "air.wind": [[3, 0, 0], [5, 0, 0]]},
        out="sweep",
        film="vtkhdf",
        each=lambda case: {"swing_m": ws.measure(case.folder)["swing_m"]},
    )

`out` gets a folder per case (`scene.toml`, `report.json`, `picture.png` and the film, or `error.txt`), `table.csv` of all, and
`sheet.png` of their pictures, labelled where Pillow is installed; a warning says why pictures make no sheet, as those of
different sizes. Called again it runs what is missing; with `checkpoint_every` a case goes on in its middle. `ensemble` repeats
a scene with other seeds.

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
from collections.abc import Callable, Generator, Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path
from statistics import fmean, stdev
from typing import TYPE_CHECKING, Any, Literal, cast

from windswept._native import ExportError, SceneError, Simulation, Writer, contact_sheet, write_png
from windswept._table import plain
from windswept.scene import Scene

if TYPE_CHECKING:
    from distributed import Client

    from windswept.report import Report

__all__ = ["Case", "Spread", "ensemble", "run"]

#: Columns of the table that come from a report.
_REPORTED = ["steps", "time_s", "ms_per_step", "max_stretch", "density_error_rms"]

#: Files of a case beside its scene and its report.
_FILES = ("picture.png", "hair.vtkhdf", "air.vtkhdf")

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
    report: Report = field(default_factory=lambda: cast("Report", {}))
    #: What `each` returned.
    numbers: dict[str, Any] = field(default_factory=dict)
    #: The case's last fault, also where the case finished in the end.
    error: str | None = None
    _text: str = field(default="", repr=False)
    _log: str = field(default="", repr=False)


@dataclass(frozen=True)
class Spread:
    """Numbers over an ensemble, by name."""

    mean: dict[str, float]
    #: Standard deviation of one case: of a sample, so that it is NaN where one case alone finished.
    spread: dict[str, float]
    cases: list[Case]


@dataclass(frozen=True)
class _Job:
    """What a worker needs to know of a case."""

    text: str
    adapter: str | None
    picture: bool
    #: File of its checkpoint and steps between two; None: it has none.
    checkpoint: tuple[str, int] | None = None
    film: bool = False


#: Report of a finished run, and its files by name: picture and film.
_Result = tuple["Report", dict[str, bytes]]


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
    film: Literal["vtkhdf"] | None = None,
    each: Callable[[Case], Mapping[str, Any]] | None = None,
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
        film: "vtkhdf" writes every frame of hair and air into the case's folder; not with checkpoint_every, as a case that goes
            on has not the frames before.
        each: called with every case that has finished, in this process; what it returns becomes `case.numbers`, and columns of
            the table.
        checkpoint_every: steps after which a case that runs on this machine writes a checkpoint into its folder, from which
            it goes on when it is started again; None: it starts anew.

    Returns:
        Every case, in the order of the product of the values. A case that fails does not stop the others.

    Raises:
        SceneError: no case makes a scene: a key is unknown, say.
        Whatever `each` raises: the cases' folders, the table so far and the sheet are there.
    """
    if not vary or not all(len(values) > 0 for values in vary.values()):
        raise ValueError("vary: expected at least one key with at least one value")
    if workers < 1 or retries < 0:
        raise ValueError(f"expected workers >= 1 and retries >= 0, found {workers} and {retries}")
    if checkpoint_every is not None and checkpoint_every < 1:
        raise ValueError(f"checkpoint_every: expected at least 1 step, found {checkpoint_every}")
    if film not in (None, "vtkhdf") or (film and checkpoint_every is not None):
        raise ValueError(f'film: expected "vtkhdf", without checkpoint_every, or None; found {film!r}')
    cases = _cases(scene, vary, Path(out), bool(film))
    missing = [case for case in cases if case.status == "waiting"]
    every = checkpoint_every if client is None else None
    jobs = {case.index: _Job(case._text, adapter, picture, _checkpoint(case, every), bool(film)) for case in missing}
    work = _locally(missing, jobs, workers, retries) if client is None else _on(client, missing, jobs, retries)
    try:
        for case, result in _shown(work, len(missing)):
            _settle(case, result)
            _write_table(cases, vary, Path(out))
    finally:
        work.close()
    _write_sheet(cases, Path(out) / "sheet.png")
    try:
        for case in cases if each else []:
            if case.status != "failed":
                case.numbers = dict(each(case))  # type: ignore[misc]
    finally:
        _write_table(cases, vary, Path(out))
    return cases


def ensemble(scene: Scene, seeds: Sequence[int], out: str | os.PathLike[str], *, key: str = "seed", **options: Any) -> Spread:
    """Runs the scene with each seed: the mean and the spread of every number of its reports and of what `each` returns.

        spread = ws.ensemble(scene, range(8), "ensemble", film="vtkhdf", each=lambda case: ws.measure(case.folder))
        spread.mean["swing_m"], spread.spread["swing_m"]

    Args:
        key: "seed" for all chance, "air.seed" for another wind over the same hair, "hair.seed" for other hair in the same wind.
        options: as `run`'s.

    Raises:
        RuntimeError: no case finished.
    """
    cases = run(scene, {key: list(seeds)}, out, **options)
    numbers = [{**case.report, **case.numbers} for case in cases if case.status != "failed"]
    if not numbers:
        raise RuntimeError(f"no case finished: {cases[0].error}")
    names = [name for name in numbers[0] if all(_is_number(own.get(name)) for own in numbers)]
    columns = {name: [float(own[name]) for own in numbers] for name in names}
    spread = {name: stdev(own) if len(own) > 1 else float("nan") for name, own in columns.items()}
    return Spread({name: fmean(own) for name, own in columns.items()}, spread, cases)


def _is_number(value: Any) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool)


def _shown(work: Iterable[tuple[Case, _Result | None]], count: int) -> Iterable[tuple[Case, _Result | None]]:
    """The cases as they finish, with a bar in a terminal if tqdm is installed."""
    try:
        from tqdm.auto import tqdm  # type: ignore[import-untyped]
    except ImportError:
        return work
    bar: Iterable[tuple[Case, _Result | None]] = tqdm(work, "sweep", count, unit="case", disable=None)
    return bar


def _cases(scene: Scene, vary: Mapping[str, Sequence[Any]], out: Path, film: bool) -> list[Case]:
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
        if case.status == "waiting" and (report := _report(case, film)):
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


def _report(case: Case, film: bool) -> Report | None:
    """The report that the case's folder has, if it is of just this scene and of a run that did not fail."""
    try:
        if (case.folder / "scene.toml").read_bytes() != case._text.encode():
            return None
        if film and not list(case.folder.glob("*.vtkhdf")):
            return None
        report = json.loads((case.folder / "report.json").read_text(encoding="utf-8"))
        return cast("Report", report) if isinstance(report, dict) and "failure" not in report else None
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
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        film = Writer(folder, sim, formats=["vtkhdf"]) if job.film else None
        if film:
            film.append(sim)
        for _ in sim.frames():
            if film:
                film.append(sim)
            if every and sim.steps >= saved + every:
                sim.save(path)
                saved = sim.steps
        # The last frame may be before the end.
        sim.step(max(round(sim.scene.time.duration / sim.dt) - sim.steps, 0))
        if film:
            film.close()
        if job.picture:
            write_png(folder / "picture.png", sim.render())
        files = {name: (folder / name).read_bytes() for name in _FILES if (folder / name).exists()}
    return sim.report(), files


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
                (Path(folder.name) / "job.json").write_text(json.dumps(asdict(job)), encoding="utf-8")
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
    return report, {file.name: file.read_bytes() for file in (folder / "files").iterdir()}


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
    for name in ("report.json", "scene.toml", "error.txt", *_FILES):
        (case.folder / name).unlink(missing_ok=True)
    for checkpoint in case.folder.glob(f"{_CHECKPOINT}*") if result is not None else []:
        checkpoint.unlink()
    if result is None:
        case.status = "failed"
        _write(case.folder / "error.txt", "\n\n".join(filter(None, [case.error, case._log])) + "\n")
        return
    case.status = "finished"
    case.report, files = result
    for name, content in files.items():
        _write(case.folder / name, content)
    _write(case.folder / "scene.toml", case._text)
    # The report comes last: who finds it finds a finished case.
    _write(case.folder / "report.json", json.dumps(case.report, indent=2) + "\n")


def _write_table(cases: list[Case], vary: Mapping[str, Sequence[Any]], out: Path) -> None:
    own = list({name: None for case in cases for name in case.numbers})
    lines: list[list[Any]] = [["case", "status", "attempts", *vary, *_REPORTED, *own, "error"]]
    for case in cases:
        reported = [case.report.get(key, "") for key in _REPORTED] + [case.numbers.get(name, "") for name in own]
        lines.append([case.folder.name, case.status, case.attempts, *_said(case).values(), *reported, case.error or ""])
    partial = out / "table.csv.part"
    with open(partial, "w", newline="", encoding="utf-8") as file:
        csv.writer(file).writerows(lines)
    os.replace(partial, out / "table.csv")


def _write_sheet(cases: list[Case], path: Path) -> None:
    """Puts the pictures of all cases side by side. The sheet of an earlier call does not stay where there is none now."""
    path.unlink(missing_ok=True)
    drawn = [case for case in cases if (case.folder / "picture.png").exists()]
    try:
        with tempfile.TemporaryDirectory() as folder:
            if drawn:
                contact_sheet([_labelled(case, Path(folder)) for case in drawn], path)
    except ExportError as error:
        # Cameras may be what varies.
        warnings.warn(f"{path} is not made: {error}", stacklevel=3)


def _said(case: Case) -> dict[str, str]:
    """The values of a case as words."""
    return {key: value if isinstance(value, str) else json.dumps(plain(value), default=str) for key, value in case.values.items()}


def _labelled(case: Case, folder: Path) -> Path:
    """A picture of the case that says its values, if Pillow is installed."""
    picture = case.folder / "picture.png"
    try:
        from PIL import Image, ImageDraw
    except ImportError:
        return picture
    labelled = folder / f"{case.folder.name}.png"
    with Image.open(picture) as drawn:
        words = "\n".join(f"{key} = {value}" for key, value in _said(case).items())
        ImageDraw.Draw(drawn).multiline_text((4, 2), words, fill="white", stroke_width=1, stroke_fill="black")
        drawn.save(labelled)
    return labelled


def _write(path: Path, content: str | bytes) -> None:
    """Writes a file whole or not at all."""
    partial = path.with_name(path.name + ".part")
    partial.write_bytes(content.encode() if isinstance(content, str) else content)
    os.replace(partial, path)


def _main(folder: Path) -> None:
    """Runs the case of a folder: `python -m windswept.sweep FOLDER` is the process of a case."""
    job = _Job(**json.loads((folder / "job.json").read_text(encoding="utf-8")))
    report, files = _simulate(job)
    (folder / "files").mkdir()
    for name, content in files.items():
        (folder / "files" / name).write_bytes(content)
    _write(folder / "report.json", json.dumps(report))


if __name__ == "__main__":
    _main(Path(sys.argv[1]))
