"""Looks of hair by a few keys each: runs examples/scenes/looks.toml with them, and writes docs/how-to/looks.md with a picture of each.

    python benches/looks.py COMMAND [LOOK...]     # COMMAND is the built windswept; all looks, or these

A look takes half a minute on a software adapter. Pictures need Pillow.
"""

import subprocess
import sys
from pathlib import Path

from PIL import Image

ROOT = Path(__file__).resolve().parent.parent
SCENE = ROOT / "examples/scenes/looks.toml"
RUNS = ROOT / "out/looks"
PAGE = ROOT / "docs/how-to/looks.md"
PICTURES = ROOT / "docs/looks"
#: Time of the pictures [s].
TIME = 0.5

#: Each look: what it shows, and its keys.
LOOKS = {
    "calm": ("Hair hangs, and a breath of air moves the tips.", {"air.wind": "[0, 0, -0.1]"}),
    "breezy": ("A breeze lifts hair from the head and lets it fall.", {"air.wind": "[-0.4, 0, -0.8]"}),
    "wild": (
        "A gale with gusts; fine, curly hair of many lengths stands away from the head.",
        {
            "air.wind": "[-1, 1.5, -4]",
            "hair.radius": "2.5e-5",
            "hair.length_variation": "0.5",
            "hair.curl": "{ radius = 0.008, pitch = 0.08 }",
        },
    ),
    "heavy": (
        "Long, thick, soft fibres: the same breeze hardly lifts them.",
        {
            "air.wind": "[-0.4, 0, -0.8]",
            "hair.length": "0.3",
            "hair.radius": "5e-5",
            "hair.density": "2600",
            "hair.youngs_modulus": "2e9",
        },
    ),
    "sprayed": (
        "Stiff from the root on and in small locks: the breeze bends it as a whole.",
        {
            "air.wind": "[-0.4, 0, -0.8]",
            "hair.stiffness": "[[0, 8], [0.5, 3], [1, 1]]",
            "hair.clump": "{ size = 0.02, strength = 0.7, noise = 0.6 }",
        },
    ),
    "wet": (
        "Water makes hair heavy, soft, and one with its neighbours: it lies in locks.",
        {
            "air.wind": "[-0.4, 0, -0.8]",
            "hair.density": "4000",
            "hair.youngs_modulus": "3e9",
            "hair.clump": "{ size = 0.045, strength = 1.0, noise = 0.2 }",
        },
    ),
}


def show(command: str, name: str) -> None:
    """Runs a look, and keeps its picture."""
    out = RUNS / name
    _, keys = LOOKS[name]
    sets = [word for key, value in keys.items() for word in ("--set", f"{key}={value}")]
    run(command, "run", SCENE, "--out", out, "--formats", "vtkhdf", "--overwrite", *sets)
    run(command, "render", out, "--contact-sheet", TIME, "--out", out / "look.png", "--overwrite")
    PICTURES.mkdir(exist_ok=True)
    with Image.open(out / "look.png") as picture:
        picture.convert("RGB").save(PICTURES / f"{name}.webp", quality=82, method=6)


def run(*words: object) -> None:
    subprocess.run([str(word) for word in words], check=True, stdout=subprocess.DEVNULL)


def page() -> str:
    """The page: the looks side by side, and then the keys of each."""
    rows = [
        f"| ![{name}](../looks/{name}.webp) | **{name}**: {says} | {'<br>'.join(f'`{key} = {value}`' for key, value in keys.items())} |\n"
        for name, (says, keys) in LOOKS.items()
    ]
    return f"""# Looks

Each picture is `examples/scenes/looks.toml` {TIME} s after the wind began, with the keys beside it in place of the
scene's. `python benches/looks.py COMMAND` makes the pictures and this page, with the built command `windswept`.

| Picture | Look | Keys |
|---|---|---|
{"".join(rows)}
Keys go into the scene, or behind `windswept run scene.toml` as `--set KEY=VALUE`. They act on any scene; how much
depends on the length of the hair and the size of the head. [Scene keys](../reference/keys.md) says what else can be
set, and a look that changes in the course of a film does so by `[[change]]`.
"""


if __name__ == "__main__":
    command, *names = sys.argv[1:]
    for name in names or LOOKS:
        show(command, name)
    PAGE.write_text(page(), encoding="utf-8")
