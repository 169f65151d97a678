"""The package as others see it: types, import time, help."""

import os
import subprocess
import sys
from pathlib import Path

import windswept as ws


def python(*words):
    return subprocess.run([sys.executable, *words], capture_output=True, text=True, cwd=Path(__file__).parent)


def test_stubs_are_those_of_the_module():
    done = python("-m", "mypy.stubtest", "windswept", "--concise")
    assert done.returncode == 0, done.stdout + done.stderr


def test_the_package_and_the_examples_pass_strict_types():
    examples = sorted(str(path) for path in (Path(__file__).parents[2] / "examples").glob("*.py"))
    assert examples
    for words in (["-p", "windswept"], examples):
        done = python("-m", "mypy", "--strict", *words)
        assert done.returncode == 0, done.stdout + done.stderr


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
