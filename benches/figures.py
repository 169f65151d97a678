"""The paper's figures with numbers: runs their scenes, measures the films, and writes benches/results/figures.json, of which
`docs/generate.py` makes a page, and the pictures of the book.

    cargo xtask figures            # the small scenes, three seeds each, or so many as --seeds says
    cargo xtask figures --full     # the paper's size, one seed: for a GPU, or a night

cargo xtask figures calls this program as `figures.py COMMAND [--full] [--check] [--seeds N]`, COMMAND being the built windswept. A run whose
scene, seed and program are those of a finished run in out/figures is not repeated. With --check numbers and pictures stay as they are.
The exit status is 1 where a claim does not hold.
"""

import datetime
import hashlib
import json
import shutil
import statistics
import subprocess
import sys
from dataclasses import asdict, dataclass, field
from pathlib import Path

from PIL import Image

ROOT = Path(__file__).resolve().parent.parent
RUNS = ROOT / "out/figures"
RESULTS = ROOT / "benches/results"
PICTURES = ROOT / "docs/figures"
#: Times of the pictures of a strip [s].
STRIP = "0.5,0.7,0.9"
#: Parts of the moving picture, in README and book.
DIAL = ["fig2b", "12 mm", "fig3c"]


@dataclass(frozen=True)
class Figure:
    """A figure of the paper, or a scene beside them: the scene's file, and keys."""

    file: str
    keys: tuple[str, ...] = ()


FIGURES = {
    **{name: Figure(name) for name in ["fig2a", "fig2b", "fig3b", "fig3c", "fig4"]},
    "12 mm": Figure("fig3c", ("turbulence.scale=0.012", "time.substeps=6")),
}


@dataclass
class Numbers:
    """Numbers of the runs of one figure, seed by seed."""

    values: dict[str, list[float]] = field(default_factory=dict)

    def add(self, name: str, value: float | None) -> None:
        self.values.setdefault(name, []).append(float("nan") if value is None else value)

    def __getitem__(self, name: str) -> list[float]:
        return self.values[name]

    def mean(self, name: str) -> float:
        return statistics.fmean(self[name])

    def spread(self, name: str) -> float:
        """Standard deviation over the seeds; not a number for one seed."""
        return statistics.stdev(self[name]) if len(self[name]) > 1 else float("nan")

    def text(self, name: str, factor: float = 1.0, digits: int = 1) -> str:
        mean, spread = (f"{factor * x:.{digits}f}" for x in (self.mean(name), self.spread(name)))
        return mean if spread == "nan" else f"{mean} ± {spread}"


#: Rows of the table: number of `windswept measure` or of report.json, its words, factor and digits.
ROWS = [
    ("swing_m", "swing of tips [mm]", 1e3, 1),
    ("swing_bundle_m", "of the bundle [mm]", 1e3, 1),
    ("swing_strands_m", "of strands in it [mm]", 1e3, 1),
    ("frequency_hz", "frequency [Hz]", 1.0, 1),
    ("wavelength_m", "wavelength [mm]", 1e3, 0),
    ("turning_mean_degrees", "turning, mean [°]", 1.0, 0),
    ("turning_largest_degrees", "turning, largest [°]", 1.0, 0),
    ("gathering", "gathering", 1.0, 2),
    ("coherence", "coherence", 1.0, 2),
    ("lean_degrees", "lean [°]", 1.0, 0),
    ("density_error_rms", "density error [%]", 1e2, 1),
]


def run(command: Path, name: str, figure: Figure, seed: int, full: bool) -> Path:
    """Runs a scene, unless that was done, and measures its film into measure.json."""
    scene = ROOT / "examples/scenes" / ("" if full else "small") / f"{figure.file}.toml"
    keys = [*figure.keys, f"seed={seed}", "time.duration=1.0", "time.frame_rate=120"]
    mark = hashlib.sha256(scene.read_bytes() + command.read_bytes() + repr(keys).encode()).hexdigest()
    folder = RUNS / f"{'full' if full else 'small'}-{name.replace(' ', '')}-{seed}"
    done = folder / "measure.json"
    if done.exists() and json.loads(done.read_text()).get("made_by") == mark:
        return folder
    shutil.rmtree(folder, ignore_errors=True)
    print(f"==> {name}, seed {seed}", flush=True)
    sets = [word for key in keys for word in ("--set", key)]
    call(command, "run", scene, "--out", folder, "--formats", "vtkhdf", *sets)
    numbers = json.loads(call(command, "measure", folder, "--from", 0.4, "--json"))
    report = json.loads((folder / "report.json").read_text())
    numbers["density_error_rms"] = report.get("density_error_rms")
    numbers["made_by"] = mark
    done.write_text(json.dumps(numbers))
    return folder


def call(command: Path, *words: object) -> str:
    return subprocess.run([str(command), *map(str, words)], check=True, stdout=subprocess.PIPE, text=True).stdout


def measured(folders: list[Path]) -> Numbers:
    numbers = Numbers()
    for folder in folders:
        values = json.loads((folder / "measure.json").read_text())
        for name in [row[0] for row in ROWS] + ["turns", "stretch"]:
            numbers.add(name, values.get(name))
    return numbers


@dataclass(frozen=True)
class Claim:
    """A sentence about the small scenes, what was measured, and whether that bears it out."""

    sentence: str
    found: str
    holds: bool


def claims(of: dict[str, Numbers], turns_at_rest: float) -> list[Claim]:
    """The claims; the paper's own come first."""
    small, middle, large, loose = of["fig2b"], of["12 mm"], of["fig3c"], of["fig3b"]
    turning = "turning_largest_degrees"
    ratio, between = large.mean("swing_m") / small.mean("swing_m"), middle.mean("swing_m") / small.mean("swing_m")
    apart = {
        name: abs(small.mean(name) - loose.mean(name)) / max(small.spread(name), loose.spread(name))
        for name in ("gathering", "coherence")
    }
    turns = of["fig4"].mean("turns") / turns_at_rest
    dense = [n for name, n in of.items() if name not in ("fig2a", "12 mm")]
    density = max(n.mean("density_error_rms") for n in dense)
    worst = max(max(n["density_error_rms"]) for n in dense)
    stretch = max(max(n["stretch"]) for n in of.values())

    def degrees(figure: Numbers) -> str:
        return "largest by seed: " + ", ".join(f"{x:.0f}°" for x in figure[turning])

    return [
        Claim("Without eddies no strand turns by more than 60°.", degrees(of["fig2a"]), max(of["fig2a"][turning]) < 60.0),
        Claim("Eddies of 6 mm turn some strand by more than 100° in each run.", degrees(small), min(small[turning]) > 100.0),
        Claim(
            "Eddies of 18 mm turn the most bent strand by more than 180° in each run.",
            degrees(large),
            min(large[turning]) > 180.0,
        ),
        Claim(
            "At one intensity eddies of 18 mm swing the tips at least 1.6 times as far as eddies of 6 mm, and 12 mm lie between.",
            f"18 mm: {ratio:.2f} times, 12 mm: {between:.2f} times",
            ratio >= 1.6 and 1.0 < between < ratio,
        ),
        Claim(
            "With c_hair = 1.4 hair spreads less than with 0.05, by three times the spread of the runs or more.",
            f"gathering {small.text('gathering', 1, 3)} and {loose.text('gathering', 1, 3)}",
            small.mean("gathering") < loose.mean("gathering") and apart["gathering"] > 3.0,
        ),
        Claim(
            "With c_hair = 1.4 neighbours move more alike than with 0.05, by three times the spread of the runs or more.",
            f"coherence {small.text('coherence', 1, 3)} and {loose.text('coherence', 1, 3)}",
            small.mean("coherence") > loose.mean("coherence") and apart["coherence"] > 3.0,
        ),
        Claim(
            "Curls keep their number of turns within 10 %.",
            f"{of['fig4'].mean('turns'):.2f} turns, {turns_at_rest:.2f} at rest",
            abs(turns - 1.0) < 0.1,
        ),
        Claim(
            "Figures 2(b) to 4 each have a mean density error below 5 %.",
            f"largest mean {1e2 * density:.1f} %, largest of a run {1e2 * worst:.1f} %",
            density < 0.05,
        ),
        Claim("No segment of the small scenes stretches by more than 0.1 %.", f"largest {1e2 * stretch:.4f} %", stretch < 1e-3),
    ]


def turns_at_rest(command: Path) -> float:
    """Turns of the curls of fig4 as they grow, in a film without wind, gravity and air."""
    folder = RUNS / "curls-at-rest"
    shutil.rmtree(folder, ignore_errors=True)
    scene = ROOT / "examples/scenes/small/fig4.toml"
    keys = ["interaction.model=none", "gravity=[0,0,0]", "time.duration=0.1", "time.frame_rate=120"]
    sets = [word for key in keys for word in ("--set", key)]
    call(command, "run", scene, "--out", folder, "--formats", "vtkhdf", *sets)
    return json.loads(call(command, "measure", folder, "--json"))["turns"]


def strip(command: Path, folder: Path, name: str) -> None:
    """Three frames side by side as WebP."""
    sheet = folder / "strip.png"
    call(command, "render", folder, "--contact-sheet", STRIP, "--out", sheet, "--overwrite")
    picture = Image.open(sheet)
    width = 1200
    picture = picture.resize((width, picture.height * width // picture.width), Image.LANCZOS)
    PICTURES.mkdir(exist_ok=True)
    picture.save(PICTURES / f"{name.replace(' ', '')}.webp", quality=80, method=6)


def moving_picture(command: Path, folders: list[Path], path: Path) -> None:
    """The films side by side as an animated WebP of at most 1 MB: 0.5 to 1 s, three times slower than real."""
    for folder in folders:
        shutil.rmtree(folder / "frames", ignore_errors=True)
        call(command, "render", folder, "--frames", "60..", "--every", 4, "--overwrite")
    films = [sorted((folder / "frames").glob("*.png")) for folder in folders]
    frames = []
    for shown in zip(*films, strict=True):
        parts = [Image.open(file).convert("RGB") for file in shown]
        width = 320
        parts = [part.resize((width * 3 // 2, part.height * width * 3 // 2 // part.width), Image.LANCZOS) for part in parts]
        cut = (parts[0].width - width) // 2
        whole = Image.new("RGB", (width * len(parts), parts[0].height))
        for k, part in enumerate(parts):
            whole.paste(part.crop((cut, 0, cut + width, part.height)), (k * width, 0))
        frames.append(whole)
    for quality in range(75, 20, -10):
        frames[0].save(path, save_all=True, append_images=frames[1:], duration=100, loop=0, quality=quality, method=6)
        if path.stat().st_size < 1_000_000:
            break


def head(command: Path) -> None:
    """The picture of hair on a head, whose commands are in docs/how-to/head.md."""
    folder = RUNS / "head"
    shutil.rmtree(folder, ignore_errors=True)
    call(command, "run", ROOT / "examples/scenes/head.toml", "--out", folder, "--formats", "vtkhdf")
    keys = ["picture.hairs=16000", "camera.fov=17", "camera.eye=[0.212,0.125,0.40]", "camera.target=[0.092,0.055,0.07]"]
    keys += ["camera.width=1200", "camera.height=675"]
    call(command, "render", folder, "--frames", "9..10", *(word for key in keys for word in ("--set", key)))
    with Image.open(next((folder / "frames").glob("*.png"))) as picture:
        picture.convert("RGB").save(ROOT / "docs/head.webp", quality=82, method=6)


def table(of: dict[str, Numbers]) -> list[list[str]]:
    """A row for each number: its words, and its value for each figure."""
    return [
        [words, *("-" if n.mean(key) != n.mean(key) else n.text(key, factor, digits) for n in of.values())]
        for key, words, factor, digits in ROWS
    ]


def save(name: str, of: dict[str, Numbers], found: list[Claim], folder: Path, seeds: int) -> None:
    """Writes what was measured, with the adapter of a run, the commit and the date."""
    report = json.loads((folder / "report.json").read_text())
    results = {
        "adapter": report["adapter"]["name"],
        "commit": report.get("commit", "unknown"),
        "date": datetime.date.today().isoformat(),
        "seeds": seeds,
        "figures": list(of),
        "rows": table(of),
        "claims": [asdict(claim) for claim in found],
    }
    (RESULTS / name).write_text(json.dumps(results, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")


def main() -> int:
    command, full, check = Path(sys.argv[1]), "--full" in sys.argv, "--check" in sys.argv
    count = int(sys.argv[sys.argv.index("--seeds") + 1]) if "--seeds" in sys.argv else 1 if full else 3
    seeds = list(range(1, count + 1))
    chosen = {name: figure for name, figure in FIGURES.items() if not full or name in ("fig2b", "fig3c")}
    folders = {name: [run(command, name, figure, seed, full) for seed in seeds] for name, figure in chosen.items()}
    of = {name: measured(runs) for name, runs in folders.items()}
    print("\n".join(" | ".join(row) for row in [["", *of], *table(of)]))
    if full:
        for name, runs in folders.items():
            strip(command, runs[0], f"full-{name}")
        save("figures-full.json", of, [], folders["fig2b"][0], len(seeds))
        return 0
    found = claims(of, turns_at_rest(command))
    for claim in found:
        print(f"{'holds         ' if claim.holds else 'DOES NOT HOLD '}  {claim.sentence}  {claim.found}")
    if not check:
        for name, runs in folders.items():
            strip(command, runs[0], name)
        moving_picture(command, [folders[name][0] for name in DIAL], ROOT / "docs/dial.webp")
        save("figures.json", of, found, folders["fig2b"][0], len(seeds))
        head(command)
        subprocess.run([sys.executable, ROOT / "benches/looks.py", command], check=True)
    return 0 if all(claim.holds for claim in found) else 1


if __name__ == "__main__":
    sys.exit(main())
