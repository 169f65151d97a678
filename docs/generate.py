"""The parts of the book that follow from the code and from benches/results.

    python -I docs/generate.py FOLDER     # by `cargo xtask docs`; the package is the installed one

A function of `PARTS` returns the Markdown of one part; a page has `<!-- generated: NAME -->` where it belongs.
"""

from __future__ import annotations

import csv
import json
import re
import subprocess
import sys
from collections.abc import Callable, Iterable
from itertools import groupby
from pathlib import Path

from windswept import _native

ROOT = Path(__file__).resolve().parent.parent
RESULTS = ROOT / "benches/results"
COMMANDS = [
    "run",
    "render",
    "export",
    "measure",
    "spectrum",
    "check",
    "plan",
    "validate",
    "groom info",
    "groom convert",
    "adapters",
]


def table(head: list[str], rows: Iterable[Iterable[object]]) -> str:
    def cells(row: Iterable[object]) -> str:
        return "| " + " | ".join(str(cell).replace("|", "\\|").replace("\n", " ") for cell in row) + " |"

    return "\n".join([cells(head), "|---" * len(head) + "|", *map(cells, rows)]) + "\n"


def windswept(*words: str) -> str:
    command = [sys.executable, "-m", "windswept", *words]
    return subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True, cwd=ROOT).stdout


# The reference.


def keys() -> str:
    """A section for each table of a scene, with a row for each of its keys."""
    declared = json.loads(_native._keys())
    tables = {"": "Keys of no table"} | {key["path"]: key["help"] for key in declared if key["kind"] in ("table", "tables")}
    kind = {key["path"]: key["kind"] for key in declared}
    made = []
    for path, meaning in tables.items():
        own = [key for key in declared if key["path"].rpartition(".")[0] == path and key["path"] not in tables]
        if not own:
            continue
        brackets = {"tables": f"[[{path}]]", "table": f"[{path}]"}.get(kind.get(path, ""), "")
        made.append(f"## {path or 'scene'}\n\n{f'`{brackets}` ' if brackets else ''}{meaning}\n")
        made.append(table(["Key", "Takes", "Default", "Meaning"], ([f"`{key['path']}`", *described(key)] for key in own)))
    return "\n".join(made)


def described(key: dict[str, object]) -> tuple[object, str, object]:
    needed = f"needed {key['needed_if']}" if key["needed_if"] else "needed"
    default = f"`{key['default']}`" if key["default"] is not None else key["follows"] or needed
    variants = [variant["name"].lower() for variant in key["variants"]] if not key["words"] else []
    of = f" (of {', '.join(variants)})" if variants else ""
    return key["expected"], str(default), f"{key['help']}{of}"


def command() -> str:
    """The help of the command, and of each of its commands."""
    helps = [("windswept", windswept("--help"))]
    helps += [(f"windswept {name}", windswept(*name.split(), "--help")) for name in COMMANDS]
    return "\n".join(f"## {name}\n\n```text\n{text.strip()}\n```\n" for name, text in helps)


def source(path: str) -> str:
    return (ROOT / "crates" / path).read_text(encoding="utf-8")


def documented(lines: list[str]) -> list[tuple[str, str, str]]:
    """Fields or variants with their attributes and documentation: (line, attributes, documentation)."""
    found, doc, attributes, is_open = [], "", "", False
    for line in map(str.strip, lines):
        if line.startswith("///"):
            doc += line[3:].replace("\\[", "[").replace("\\]", "]")
        elif line.startswith("#[") or is_open:
            attributes += " " + line
            is_open = attributes.count("[") > attributes.count("]") or attributes.count("(") > attributes.count(")")
        elif line:
            found.append((line, attributes.strip(), doc.strip()))
            doc, attributes = "", ""
    return found


def report() -> str:
    """The structs of report.json, a row for each field."""
    text = source("windswept-engine/src/report.rs") + source("windswept-engine/src/gpu/adapter.rs")
    made = []
    for doc, name, body in re.findall(r"((?:///[^\n]*\n)+)(?:#\[[^\n]*\n)+pub struct (\w+) \{\n(.*?)\n\}", text, re.S):
        fields = [re.match(r"pub (\w+): (.*),", line) for line, _, _ in documented(body.splitlines())]
        rows = [
            (f"`{field[1]}`", linked(field[2]), doc + (" May be left out." if "skip_serializing_if" in attributes else ""))
            for field, (_, attributes, doc) in zip(fields, documented(body.splitlines()), strict=True)
            if field is not None
        ]
        words = " ".join(line.strip("/ ") for line in doc.splitlines())
        made.append(
            f"## {name}\n\n{plain(words)}\n\n"
            + table(["Key", "Type", "Meaning"], ((*row[:2], plain(row[2])) for row in rows))
        )
    return "\n".join(made)


def plain(doc: str) -> str:
    """Documentation without links to items of Rust."""
    return re.sub(r"\[(`[^`]+`)\](?:\([^)]*\))?", r"\1", doc.replace("\\[", "[").replace("\\]", "]"))


def linked(kind: str) -> str:
    """A type of Rust in JSON's words, with a link to a struct of the report."""
    kind = re.sub(r"^Option<(.*)>$", r"\1", kind)
    if array := re.match(r"(?:Vec<(.*)>|\[(\w+); (\d)\])$", kind):
        return f"array of {array[3] + ' ' if array[3] else ''}{linked(array[1] or array[2])}"
    if kind in ("f64", "f32"):
        return "number"
    if kind in ("u64", "u32", "usize"):
        return "count"
    names = {"String": "string", "bool": "boolean", "ShaderVariant": "string", "BTreeMap<String, u64>": "object of counts"}
    others = {"Warning": "object: code, key, text, count", "Change": "object: a `[[change]]`"}
    return names.get(kind) or others.get(kind) or f"[{kind}](#{kind.lower()})"


def errors() -> str:
    """A table for each type of error: what it is, and its text."""
    made = []
    for path in ["windswept-engine/src/error.rs", "windswept-engine/src/ops.rs", "windswept-export/src/error.rs"]:
        for doc, name, body in re.findall(
            r"((?:///[^\n]*\n)+)(?:#\[[^\n]*\n)+pub enum (\w*Error) \{\n(.*?)\n\}", source(path), re.S
        ):
            # Of a variant with fields only the head counts.
            body = re.sub(r"(\w+) \{\n.*?\n    \},", r"\1,", body, flags=re.S)
            rows = []
            for variant, attributes, meaning in documented(body.splitlines()):
                text = re.search(r'#\[error\(\s*"(.*?)"\s*[,)]', attributes, re.S)
                # Where the words continue on the next line, and what is put into them.
                words = re.sub(r"\{[^}]*\}", "…", re.sub(r"\\\s+", "", text[1])) if text else "the text of that error"
                rows.append((f"`{re.match(r'[A-Za-z]+', variant)[0]}`", plain(meaning), words))
            words = " ".join(line.strip("/ ") for line in doc.splitlines())
            made.append(f"### {name}\n\n{plain(words)}\n\n" + table(["Error", "Meaning", "Text"], rows))
    return "\n".join(made)


def formats() -> str:
    rows = re.findall(r'Format \{\s*name: "(\w+)",\s*writes: "([^"]*)"', source("windswept-export/src/formats.rs"))
    of_runs = _native.formats()
    ways = [(f"`{name}`", writes, "run, Python's `Writer`" if name in of_runs else "export") for name, writes in rows]
    return table(["Format", "Writes", "Made by"], ways)


def grooms() -> str:
    rows = re.findall(r"^  \.(\w+) +(.*)$", windswept("groom", "--help"), re.M)
    return table(["Ending", "Format"], ((f"`.{ending}`", what) for ending, what in rows))


def buffers() -> str:
    """What `windswept plan --buffers` says of the scene `quick`: buffers, and passes with what they read and write."""
    return "```text\n" + windswept("plan", "examples/scenes/quick.toml", "--buffers").strip() + "\n```\n"


# Is it right?


def rows_of(name: str) -> list[dict[str, str]]:
    lines = (RESULTS / name).read_text(encoding="utf-8").splitlines()
    return list(csv.DictReader(line for line in lines if not line.startswith("#")))


def provenance(row: dict[str, str]) -> str:
    return f"*{row['adapter']}; commit {row['commit']}; {row['date']}*\n"


def number(text: str) -> str:
    x = float(text)
    return f"{x:.4g}" if x == 0 or 1e-3 <= abs(x) < 1e5 else f"{x:.2e}"


def checks(rows: list[dict[str, str]]) -> str:
    """A section for each check of `windswept validate`."""
    made, last = [], ""
    for check, own in groupby(rows, lambda row: row["check"]):
        measured = list(own)
        line = provenance(measured[0])
        made.append(f"### {check}\n" + (f"\n{line}" if line != last else ""))
        last = line
        cells = (
            [
                row["quantity"],
                *(number(row[key]) for key in ("expected", "measured", "tolerance")),
                row["unit"],
                verdict(row),
            ]
            for row in measured
        )
        made.append(table(["Quantity", "Expected", "Measured", "Tolerance", "Unit", ""], cells))
    return "\n".join(made)


def verdict(row: dict[str, str]) -> str:
    return "holds" if row["passed"] == "true" else "**does not hold**"


#: Checks that the page about hair in wind shows, the other page all others.
OF_HAIR = ["hair-in-wind", "hair-two-way", "hair-limits", "exchange"]


def validate() -> str:
    rows = rows_of("validate.csv")
    holding = sum(row["passed"] == "true" for row in rows)
    others = [row for row in rows if row["check"] not in OF_HAIR]
    return f"{holding} of {len(rows)} rows hold.\n\n" + checks(others)


def hair() -> str:
    return checks([row for row in rows_of("validate.csv") if row["check"] in OF_HAIR])


def choices() -> str:
    """The rule's choice and the default for each error, family by family."""
    made = []
    for family, own in groupby(rows_of("choices.csv"), lambda row: row["family"]):
        rows = list(own)
        made.append(f"### {family}\n\n{provenance(rows[0])}")
        cells = (
            (
                row["error"],
                row["floor"] or "none",
                row["rule"],
                f"{row['rule_ms']} ms; {row['rule_error']}",
                f"{row['default']}",
                f"{row['default_ms']} ms; {row['default_error']}",
            )
            for row in rows
        )
        made.append(
            table(["Error", "Floor", "The rule's choice", "takes; is off by", "Default", "takes; is off by"], cells)
        )
    return "\n".join(made)


def stress() -> str:
    """A table for each stress, and the settings that do not hold."""
    all_rows = rows_of("stress.csv")
    bounded = [row for row in all_rows if row["failing"]]
    made = [f"{sum(holds(row) for row in bounded)} of {len(bounded)} bounded rows hold.\n"]
    for name, own in groupby(all_rows, lambda row: row["stress"]):
        rows = list(own)
        made.append(f"## {name}\n\n{rows[0]['swept']}.\n\n{provenance(rows[0])}")
        cells = ((row["quantity"], row["worst"], row["at"], row["bound"], standing(row)) for row in rows)
        made.append(table(["Quantity", "Worst", "at", "Bound", "Holds"], cells))
        made += [f"Settings that do not hold: {row['failures']}\n" for row in rows if row["failures"]]
        picture = f"stress-{name.replace(' ', '-')}.svg"
        if (RESULTS / picture).exists():
            made.append(f"![{name}](../../benches/results/{picture})\n")
    return "\n".join(made)


def holds(row: dict[str, str]) -> bool:
    return row["failing"].split(" ")[0] == "0"


def standing(row: dict[str, str]) -> str:
    return "–" if not row["failing"] else "yes" if holds(row) else f"**no**: {row['failing']}"


def of_figures(name: str) -> str:
    """Numbers of the paper's figures, and the claims about them."""
    made = json.loads((RESULTS / name).read_text(encoding="utf-8"))
    seeds = f"{made['seeds']} seed{'s' if made['seeds'] > 1 else ''} each, 0.4 to 1 s"
    text = f"{provenance(made)}\n{seeds}.\n\n" + table(["", *(f"`{name}`" for name in made["figures"])], made["rows"])
    claims = ((c["sentence"], c["found"], "holds" if c["holds"] else "**does not hold**") for c in made["claims"])
    return text + ("\n" + table(["Claim", "Measured", ""], claims) if made["claims"] else "")


def gpu() -> str:
    """Time of a step on a GPU, scene by scene."""
    made = []
    for path in sorted(RESULTS.glob("gpu-*.json")):
        found = json.loads(path.read_text(encoding="utf-8"))
        made.append(provenance(found | {"adapter": f"{found['adapter']['name']} ({found['adapter']['driver']})"}))
        rows = (
            (
                scene["name"],
                f"{scene['particles']:,}".replace(",", " "),
                f"{scene['ms_of_a_step_on_the_gpu']:.2f}",
                f"{scene['memory_bytes'] / 1e6:.0f}",
                f"{scene['frames_per_second']:.0f}" if "frames_per_second" in scene else "",
            )
            for scene in found["scenes"]
        )
        made.append(table(["Scene, one substep", "Particles", "ms a step", "MB", "frames a second at true speed"], rows))
    return "\n".join(made)


def goals() -> str:
    """What was measured beside its goal, a row each with its own provenance."""
    return table(
        ["Quantity", "Measured", "Goal", "Adapter, commit, date"],
        ([row["quantity"], row["measured"], row["goal"], where(row)] for row in rows_of("goals.csv")),
    )


def where(row: dict[str, str]) -> str:
    return "; ".join(word for word in (row["adapter"], row["commit"], row["date"]) if word)


def price() -> str:
    lines = (RESULTS / "price.csv").read_text(encoding="utf-8").splitlines()
    head = dict(line[2:].split(": ", 1) for line in lines if line.startswith("# ") and ": " in line)
    rows = (
        (row["quantity"], row["series"], number(row["measured"]), row["tolerance"].replace("inf", ""))
        for row in rows_of("price.csv")
    )
    return f"{provenance(head)}\n" + table(["Quantity", "Scene", "Measured", "At most"], rows)


PARTS: dict[str, Callable[[], str]] = {
    "keys": keys,
    "command": command,
    "report": report,
    "errors": errors,
    "formats": formats,
    "grooms": grooms,
    "buffers": buffers,
    "validate": validate,
    "hair": hair,
    "choices": choices,
    "stress": stress,
    "figures": lambda: of_figures("figures.json"),
    "figures-full": lambda: of_figures("figures-full.json"),
    "gpu": gpu,
    "goals": goals,
    "price": price,
}


def main() -> None:
    folder = Path(sys.argv[1])
    for name, part in PARTS.items():
        (folder / f"{name}.md").write_text(part(), encoding="utf-8")


if __name__ == "__main__":
    main()
