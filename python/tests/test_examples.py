"""Every example runs, in a folder of its own."""

import subprocess
import sys
from pathlib import Path

import pytest

EXAMPLES = sorted((Path(__file__).parents[2] / "examples").glob("*.py"))


@pytest.mark.parametrize("example", EXAMPLES, ids=lambda path: path.name)
def test_example(example, tmp_path):
    words = ["--small"] if "--small" in example.read_text(encoding="utf-8") else []
    done = subprocess.run([sys.executable, example, *words], capture_output=True, text=True, cwd=tmp_path)
    assert done.returncode == 0, done.stdout + done.stderr
    assert done.stdout


def test_every_rust_example_has_its_twin():
    rust = {path.stem for path in (Path(__file__).parents[2] / "examples").glob("*.rs")}
    assert rust <= {path.stem for path in EXAMPLES}
