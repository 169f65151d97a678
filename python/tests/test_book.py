"""Every snippet of README and book runs: Python and shell here, Rust as doctests of the root package (`src/lib.rs`).

The blocks of a page run one after the other in one folder, which has the examples in it.
"""

from __future__ import annotations

import os
import re
import shlex
import shutil
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

import pytest
from _pytest.mark import ParameterSet

import windswept as ws

ROOT = Path(__file__).parents[2]
PAGES = [
    *(ROOT / name for name in ["README.md", "CONTRIBUTING.md", "benches/README.md", "fuzz/README.md", "python/README.md"])
]
PAGES += sorted((ROOT / "docs").rglob("*.md"))
PAGES = [page for page in PAGES if "lab" not in page.parts]
#: Pages whose commands take no ten seconds on a software adapter; all others are `long`.
QUICK = ["docs/start/install.md", "docs/how-to/forces.md", "docs/how-to/groom.md"]
QUICK += ["CONTRIBUTING.md", "benches/README.md", "fuzz/README.md"]


def blocks(page: Path, language: str) -> list[str]:
    """The blocks of code of a language."""
    text = page.read_text(encoding="utf-8")
    return [code for found, code in re.findall(r"^```([\w,]*)\n(.*?)^```$", text, re.M | re.S) if found == language]


def named(language: str, quick: Sequence[str] | None = None) -> list[ParameterSet]:
    """The pages that have such blocks, to be tested; those that are not among the quick ones are `long`."""
    pages = [(page, page.relative_to(ROOT).as_posix()) for page in PAGES if blocks(page, language)]
    return [
        pytest.param(page, id=name, marks=() if quick is None or name in quick else pytest.mark.long)
        for page, name in pages
    ]


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A folder with the examples, in which a program finds the command `windswept` of this package."""
    shutil.copytree(ROOT / "examples", tmp_path / "examples")
    quick = tmp_path / "examples/scenes/quick.toml"
    # A quarter of the time: what a snippet shows does not depend on it.
    quick.write_text(quick.read_text(encoding="utf-8").replace("substeps = 4", "substeps = 1"), encoding="utf-8")
    shutil.copy(quick, tmp_path)
    programs = tmp_path / "programs"
    programs.mkdir()
    for name, words in {"windswept": "-m windswept", "python": ""}.items():
        (programs / name).write_text(f'#!/bin/sh\nexec "{sys.executable}" {words} "$@"\n')
        (programs / name).chmod(0o755)
    return tmp_path


def run(command: list[str], folder: Path) -> subprocess.CompletedProcess[str]:
    path = os.pathsep.join([str(folder / "programs"), os.environ["PATH"]])
    return subprocess.run(command, cwd=folder, env=os.environ | {"PATH": path}, capture_output=True, text=True)


@pytest.mark.parametrize("page", named("python"))
def test_the_python_of_a_page_runs(page, folder):
    code = "\n".join(blocks(page, "python"))
    # Less of what takes long: the length of runs is no part of what a snippet shows.
    for long, short in [("frames(30)", "frames(2)"), ("sim.run(0.1)", "sim.run(0.01)")]:
        code = code.replace(long, short)
    (folder / "page.py").write_text(code, encoding="utf-8")
    done = run([sys.executable, "page.py"], folder)
    assert done.returncode == 0, done.stdout + done.stderr


def commands(page: Path) -> list[str]:
    """The commands of a page, each with the lines that it goes over."""
    found = []
    for block in blocks(page, "sh"):
        lines = block.replace("\\\n", "").splitlines()
        for line in lines:
            # A quotation goes on.
            if found and found[-1].count("'") % 2:
                found[-1] += "\n" + line
            elif line.strip() and not line.startswith("#"):
                found.append(line)
    return found


#: Commands of the repository, which `cargo xtask help` has to know, and of others, which the tests do not have.
OTHERS = ["cargo", "blender", "ssh", "pip", "export"]


@pytest.mark.parametrize("page", named("sh", QUICK))
def test_the_commands_of_a_page_run(page, folder):
    known = (ROOT / "crates/xtask/src/main.rs").read_text(encoding="utf-8")
    for command in commands(page):
        words = [word for word in shlex.split(command, comments=True) if not re.match(r"[A-Z_]+=", word)]
        if words[:2] == ["cargo", "xtask"]:
            assert f'["{words[2]}"' in known, command
        # What blender makes is not there either.
        if words[0] in OTHERS or any(word.startswith("groom.") for word in words) or "groom.usdc" in command:
            continue
        done = run(["sh", "-c", command], folder)
        assert done.returncode == 0, f"{command}\n{done.stdout}{done.stderr}"


@pytest.mark.parametrize("page", named("toml"))
def test_the_toml_of_a_page_is_of_scenes(page):
    for block in blocks(page, "toml"):
        whole = block if "[time]" in block else "time = { step = 1e-3, duration = 0.1 }\n" + block
        # A fragment leaves out what else a scene needs; all that it has is right.
        try:
            ws.Scene.parse(whole)
        except ws.SceneError as error:
            assert all(": is missing" in fault for fault in str(error).splitlines()), f"{block}\n{error}"


def test_every_warning_is_explained():
    sources = {path: path.read_text(encoding="utf-8") for path in (ROOT / "crates").rglob("src/**/*.rs")}
    codes = {code for text in sources.values() for code in re.findall(r'(?:Warning::new|warning)\(\s*"([a-z_]+)"', text)}
    status = sources[ROOT / "crates/windswept-engine/src/status.rs"]
    table = status.split("const WARNINGS")[1].split("/// Strand steps of which")[0]
    codes |= set(re.findall(r'\(\s*(?:[A-Z_]+,\s*)?"([a-z_]+)",', table))
    page = (ROOT / "docs/reference/errors.md").read_text(encoding="utf-8")
    explained = re.findall(r"^\| `([a-z_]+)` \|", page, re.M)
    assert len(codes) > 30 and sorted(codes) == explained, set(codes) ^ set(explained)


def test_the_generated_parts_say_what_there_is(tmp_path):
    done = subprocess.run([sys.executable, "-I", ROOT / "docs/generate.py", tmp_path], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    parts = {path.stem: path.read_text(encoding="utf-8") for path in tmp_path.glob("*.md")}
    for key in ["air.spacing", "turbulence.scale", "hair.pin.at", "body.motion.rotation", "time.step"]:
        assert f"| `{key}` |" in parts["keys"], key
    # Every column of every row, in tables as wide as their heads.
    for name, text in parts.items():
        for rows in re.findall(r"(?:^\|.*\n)+", text, re.M):
            widths = {len(re.findall(r"(?<!\\)\|", row)) for row in rows.splitlines()}
            assert len(widths) == 1, f"{name}: {rows}"
    sim = ws.Simulation(ws.Scene.load(ROOT / "examples/scenes/quick.toml"))
    sim.step(3)
    for key in sim.report():
        assert f"| `{key}` |" in parts["report"], key
