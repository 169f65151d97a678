"""The JSON schema of a scene file, by a public validator."""

import json
import subprocess
import sys
import tomllib
from pathlib import Path

import jsonschema
import pytest

SCENES = sorted((Path(__file__).parents[2] / "examples/scenes").rglob("*.toml"))


@pytest.fixture(scope="module")
def validator() -> jsonschema.Draft202012Validator:
    command = [sys.executable, "-m", "windswept", "check", "--schema"]
    schema = json.loads(subprocess.run(command, check=True, stdout=subprocess.PIPE).stdout)
    jsonschema.Draft202012Validator.check_schema(schema)
    return jsonschema.Draft202012Validator(schema)


def test_scenes_of_the_examples_are_valid(validator: jsonschema.Draft202012Validator) -> None:
    assert len(SCENES) > 10
    for path in SCENES:
        validator.validate(tomllib.loads(path.read_text()))


@pytest.mark.parametrize(
    "keys",
    [
        "banana = 1",
        "[time]\nstep = -1.0\nduration = 1.0",
        "[time]\nduration = 1.0",
        '[time]\nstep = "short"\nduration = 1.0',
        "[time]\nstep = 1e-3\nduration = 1.0\nsubsteps = 0",
        'method = "exact"',
        "gravity = [0.0, -9.81]",
        "[hair]\npoints = 1",
        "[[hair]]\ntaper = 1.5",
        "[air]\nwind = 3.0",
        "[turbulence]\nbands = [{ strength = 1.0 }]",
        '[[body]]\nshape = "cube"',
    ],
)
def test_wrong_scenes_are_refused(validator: jsonschema.Draft202012Validator, keys: str) -> None:
    text = keys if "[time]" in keys else f"{keys}\n[time]\nstep = 1e-3\nduration = 1.0"
    with pytest.raises(jsonschema.ValidationError):
        validator.validate(tomllib.loads(text))
