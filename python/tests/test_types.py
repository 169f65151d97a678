"""The package as others see it: types, import time, help."""

import ast
import inspect
import os
import re
import subprocess
import sys
import typing
from pathlib import Path

import pytest

import windswept as ws


def python(*words):
    return subprocess.run([sys.executable, *words], capture_output=True, text=True, cwd=Path(__file__).parent)


ROOT = Path(__file__).parents[2]
EXAMPLES = sorted((ROOT / "examples").glob("*.py"))


@pytest.mark.long
def test_stubs_are_those_of_the_module(tmp_path):
    # mypy does not add `scene.__all__` to that of the package.
    (tmp_path / "allowed").write_text("windswept.__all__\n")
    done = python("-m", "mypy.stubtest", "windswept", "--concise", "--allowlist", tmp_path / "allowed")
    assert done.returncode == 0, done.stdout + done.stderr


def test_generated_files_are_those_of_the_module():
    done = python("-I", ROOT / "python/generate.py", "--check")
    assert done.returncode == 0, f"{done.stdout}{done.stderr}run `cargo xtask stubs`"


def test_stubs_have_the_docstrings_of_the_module():
    stub = ast.parse((Path(ws.__file__).parent / "_native.pyi").read_text(encoding="utf-8"))
    documented = 0
    for node in stub.body:
        thing = getattr(ws._native, getattr(node, "name", ""), None)
        for member in [node, *getattr(node, "body", [])] if thing else []:
            name = getattr(member, "name", "__")
            own = thing if member is node else getattr(thing, name, None)
            if isinstance(member, (ast.ClassDef, ast.FunctionDef)) and not name.startswith("__") and own.__doc__:
                assert ast.get_docstring(member) == inspect.cleandoc(own.__doc__).strip(), name
                documented += 1
    assert documented > 80


MYPY = ["mypy", "--strict"]
PYRIGHT = ["pyright", "--pythonpath", sys.executable]


@pytest.mark.parametrize(
    "words",
    [
        pytest.param([*MYPY, "-p", "windswept"], id="package", marks=pytest.mark.long),
        pytest.param([*MYPY, *EXAMPLES], id="mypy"),
        pytest.param([*PYRIGHT, *EXAMPLES], id="pyright"),
    ],
)
def test_the_package_and_the_examples_pass_strict_types(words):
    done = python("-m", *words)
    assert done.returncode == 0, done.stdout + done.stderr


def test_a_report_has_the_type_that_it_says(sim):
    sim.update(**{"turbulence.scale": 0.009})
    sim.step(3)

    def check(value, kind, path):
        if typing.is_typeddict(kind):
            assert kind.__required_keys__ <= set(value) <= kind.__required_keys__ | kind.__optional_keys__, path
            hints = typing.get_type_hints(kind)
            for key, inner in value.items():
                check(inner, hints[key], f"{path}.{key}")
        elif typing.get_origin(kind) in (list, dict):
            assert isinstance(value, typing.get_origin(kind)), path
            for inner in value.values() if isinstance(value, dict) else value:
                check(inner, typing.get_args(kind)[-1], path)
        else:
            assert isinstance(value, (int, kind) if kind is float else kind), path

    report = sim.report()
    check(report, ws.Report, "report")
    assert {"max_stretch", "band_energy", "ms_per_step", "passes"} <= set(report)
    # What a run that fails and a scene with bodies have besides.
    source = (ROOT / "crates/windswept-engine/src/report.rs").read_text(encoding="utf-8")
    fields = re.findall(r"^    pub (\w+):", source[source.index("pub struct Report") :].split("\n}\n")[0], re.M)
    assert set(fields) == ws.Report.__required_keys__ | ws.Report.__optional_keys__


def test_import_loads_nothing_large_and_touches_no_gpu():
    done = python("-c", "import sys, windswept; print([m for m in sys.modules if m in ('numpy', 'matplotlib', 'distributed')])")
    assert done.stdout.strip() == "[]", done.stdout
    # Vulkan's loader says what it does, as soon as anything loads it.
    loud = {**os.environ, "VK_LOADER_DEBUG": "all"}

    def said(code):
        return subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, env=loud).stderr

    assert said("import windswept") == ""
    if sys.platform == "linux":
        assert said("import windswept; windswept.adapters()") != ""
    # Nor does a name that is not there look for one.
    assert {"plot", "sweep", "ops"} <= set(dir(ws)) and not hasattr(ws, "polt")


def test_everything_public_is_documented():
    for name in ws.__all__:
        thing = getattr(ws, name)
        if name == "__version__":
            continue
        assert thing.__doc__, name
        for member in vars(thing).values() if isinstance(thing, type) and not issubclass(thing, Exception) else []:
            if not getattr(member, "__name__", "_").startswith("_"):
                assert member.__doc__, f"{name}.{member.__name__}"
    assert "step" in ws.Simulation.__doc__ and "SceneError" in ws.Simulation.__doc__
