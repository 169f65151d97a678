"""Every example runs, in a folder of its own."""

import shutil
import subprocess
import sys
from pathlib import Path

import pytest

EXAMPLES = sorted((Path(__file__).parents[2] / "examples").glob("*.py"))


# Two figures of the paper; a head of life size.
LONG = ["06_fig3a_against_fig3c.py", "07_walking_head.py"]


@pytest.mark.parametrize(
    "example",
    [pytest.param(path, id=path.name, marks=pytest.mark.long if path.name in LONG else ()) for path in EXAMPLES],
)
def test_example(example, tmp_path):
    words = ["--small"] if "--small" in example.read_text(encoding="utf-8") else []
    done = subprocess.run([sys.executable, example, *words], capture_output=True, text=True, cwd=tmp_path)
    assert done.returncode == 0, done.stdout + done.stderr
    assert done.stdout


@pytest.mark.long
def test_the_notebook_runs(tmp_path):
    import nbformat
    from nbclient import NotebookClient

    shutil.copytree(EXAMPLES[0].parent / "scenes", tmp_path / "scenes")
    notebook = nbformat.read(EXAMPLES[0].parent / "08_notebook.ipynb", as_version=4)
    cells = [cell for cell in notebook.cells if cell.cell_type == "code"]
    # What it shows is not kept: it would differ by adapter.
    assert not any(cell.outputs for cell in cells)
    NotebookClient(notebook, kernel_name="python3", resources={"metadata": {"path": tmp_path}}).execute()
    shown = [cell.outputs[-1].data for cell in cells]
    for data, words in zip(shown, ["<img", "4 pictures", "7 pictures", "7 pictures", "<iframe", "steps"], strict=True):
        assert words in data.get("text/html", "") + data["text/plain"]
    assert (tmp_path / "film.html").stat().st_size > 100_000


def test_every_numbered_rust_example_has_its_reference():
    rust = {path.stem for path in (Path(__file__).parents[2] / "examples").glob("[0-9]*.rs")}
    assert rust <= {path.stem for path in EXAMPLES}
