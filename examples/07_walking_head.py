"""A life-size head that walks and turns in gusts: loose hair and a ponytail of 10 000 hairs, and a film of it for Blender.

    python examples/07_walking_head.py                     # writes the folder walk: some minutes on two cores
    python examples/07_walking_head.py --spacing 0.006     # finer air, for a GPU
    python examples/07_walking_head.py --small             # a few steps of few strands

`walk/scene.toml` is the scene, `walk/run` what `windswept run` makes of it, `walk/film.usda` the film: hair, head and camera,
with z up as Blender has it.
"""

import argparse
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np

import windswept as ws

HEAD = Path(__file__).parent / "scenes/head.obj"
TIE = np.array([0.0, 0.045, -0.135])  # where the ponytail is tied, behind the head [m]

parser = argparse.ArgumentParser()
parser.add_argument("--spacing", type=float, default=0.025, help="of air particles [m]")
parser.add_argument("--small", action="store_true", help="a few steps of few strands")
args = parser.parse_args()
folder = Path("walk")
folder.mkdir(exist_ok=True)

# Roots on the scalp, evenly, and the normals there.
lines = [line.split() for line in HEAD.read_text().splitlines()]
places = np.array([line[1:4] for line in lines if line[:1] == ["v"]], dtype=float)
start = lines.index(["g", "scalp"])
end = next((k for k in range(start + 1, len(lines)) if lines[k][:1] == ["g"]), len(lines))
faces = [[int(corner.split("/")[0]) - 1 for corner in line[1:]] for line in lines[start:end] if line[:1] == ["f"]]
corners = places[[[face[0], *face[k : k + 2]] for face in faces for k in range(1, len(face) - 1)]]
across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
area = np.linalg.norm(across, axis=1)
rng = np.random.default_rng(1)
hairs = 400 if args.small else 10_000
chosen = rng.choice(len(area), hairs, p=area / area.sum())
part = np.sort(rng.random((hairs, 2)), axis=1)
weights = np.stack([part[:, 0], part[:, 1] - part[:, 0], 1 - part[:, 1]], axis=1)
roots = np.einsum("ik,ikj->ij", weights, corners[chosen])
normals = across[chosen] / area[chosen, None]


def save(name: str, rows: np.ndarray, goal: np.ndarray, length: float, shorter: float, points: int) -> None:
    """Straight hairs that leave the head at a slant toward a goal: a vector for each, or one for all."""
    n = normals[rows]
    along = goal - np.sum(goal * n, axis=1, keepdims=True) * n
    direction = 0.5 * n + along / np.maximum(np.linalg.norm(along, axis=1, keepdims=True), 1e-9)
    direction /= np.linalg.norm(direction, axis=1, keepdims=True)
    lengths = length * (1 - shorter * rng.random(len(rows)))
    t = np.linspace(0, 1, points)
    curves = roots[rows, None] + (lengths[:, None] * t)[..., None] * direction[:, None]
    offsets = points * np.arange(len(rows) + 1)
    np.savez_compressed(folder / name, points=curves.reshape(-1, 3).astype("f4"), offsets=offsets, meters_per_unit=1.0)


tail = (roots[:, 2] < 0.03) & (roots[:, 1] > 0.0)
save("tail.npz", np.flatnonzero(tail), TIE - roots[tail], 0.45, 0.0, 24)
down = np.array([0.0, -1.0, 0.0]) + 2.0 * roots[~tail] * [1, 0, 1]
save("loose.npz", np.flatnonzero(~tail), down, 0.26, 0.2, 16)

# Two steps a second, 1.2 m/s forward, 15 mm up and down; from 0.6 s on a look to the side, by 40 degrees in 0.2 s.
times = np.arange(0.0, 1.5, 0.05)
keyframes = [
    ws.Keyframe(
        time=float(t),
        translation=[0, 0.015 * float(np.sin(4 * np.pi * t)), 1.2 * float(t)],
        rotation=[0, float(np.radians(40) * np.clip((t - 0.6) / 0.2, 0, 1)), 0],
    )
    for t in times
]


def hair(name: str, strands: int, **more: Any) -> ws.Hair:
    return ws.Hair(
        name=name,
        file=str(folder / f"{name}.npz"),
        strands=20 if args.small else strands,
        body="head",
        rest="weightless",
        radius=2.5e-5,
        youngs_modulus=5e8,  # soft, as hair that is brushed: it lies on the head
        fibres_per_strand=80.0,
        stiffness=[[0.0, 2.0], [0.2, 1.0]],
        clump=ws.Clump(size=0.02, strength=0.7, noise=0.4),
        **more,
    )


scene = ws.Scene(
    title="A head that walks in gusts",
    time=ws.Time(
        step=1.25e-3,
        substeps=1 if args.spacing > 0.01 else 2,  # air moves less than half a spacing in each
        settle=0.1 if args.small else 1.5,
        duration=0.02 if args.small else 1.2,
        frame_rate=50.0,
    ),
    hair=[
        hair("loose", 150),
        hair("tail", 100, pin=[ws.Pin(ring=ws.Ring(center=TIE.tolist(), radius=0.012))]),
    ],
    body=ws.Body(name="head", shape=ws.MeshFile(file=str(HEAD), scale=1.0, resolution=0.004), motion=keyframes),
    air=ws.Air(
        box=ws.Bounds(min=[-0.45, -0.5, -0.6], max=[0.45, 0.35, 0.45]),
        spacing=args.spacing,
        follows="head",
        wind=[1.0, 0.0, -0.5],
        gust=[ws.Gust(time=t, velocity=v) for t, v in [(0.3, [0.0, 0.0, 0.0]), (0.5, [1.5, 0.0, 0.0]), (0.9, [-0.5, 0.0, -1.0])]],
    ),
    turbulence=ws.Turbulence(scale=max(0.04, 1.5 * args.spacing), intensity=0.6),
    camera=ws.Camera(eye=[1.7, 0.05, 0.6], target=[0, -0.05, 0.6], fov=32, width=800, height=352),
    picture=ws.Picture(hairs=hairs),
)
(folder / "scene.toml").write_text(scene.text_in(folder), encoding="utf-8")


def windswept(*words: str) -> None:
    subprocess.run([sys.executable, "-m", "windswept", *words], check=True)


windswept("check", str(folder / "scene.toml"))
windswept("run", str(folder / "scene.toml"), "--out", str(folder / "run"), "--overwrite")
film = ["--format", "usd", "--out", str(folder / "film.usda"), "--followers", "--up", "z", "--overwrite"]
windswept("export", str(folder / "run"), *film)
