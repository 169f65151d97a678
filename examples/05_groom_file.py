"""A groom file: made by a script, loaded, and drawn in wind.

    python examples/05_groom_file.py        # writes curls.hair and curls.png
"""

import struct

import numpy as np

import windswept as ws

# 2001 curls of 30 points on the upper half of a ball, in centimetres, Z up, as a modelling program has them.
rng = np.random.default_rng(1)
roots = rng.normal(size=(2001, 3))
roots[:, 2] = np.abs(roots[:, 2])
roots *= 3.0 / np.linalg.norm(roots, axis=1, keepdims=True)
along = np.linspace(0.0, 4.0, 30)
curl = 0.15 * np.stack([np.cos(4 * along) - 1, np.sin(4 * along), 0 * along], axis=1)
points = roots[:, None] * (1 + along[:, None] / 3.0) + curl

with open("curls.hair", "wb") as file:
    strands, n, _ = points.shape
    # Arrays: segments and points. Then thickness, transparency and colour for a renderer, and what the file is.
    file.write(struct.pack("<4s4I5f88s", b"HAIR", strands, strands * n, 0b11, 0, 0.01, 0, 1, 1, 1, b"curls"))
    file.write(np.full(strands, n - 1, "<u2").tobytes())
    file.write(points.astype("<f4").tobytes())

scene = ws.Scene(
    title="Curls from a file, lift and drag alone",
    time=ws.Time(step=1.38e-3, duration=0.1),
    interaction=ws.Interaction(model="drag"),
    air=ws.Air(wind=[3, 0, 0]),
    hair=ws.Hair(file="curls.hair", scale=0.01, up="z", strands=200, points=15),
    picture=ws.Picture(hairs=4000),
    camera=ws.Camera(width=480, height=270),
)
sim = ws.Simulation(scene)
sim.run(0.02)
ws.write_png("curls.png", sim.render())
print(f"{len(sim.hair.ids)} of {strands} curls are simulated, the first three are numbers {sim.hair.ids[:3]} of curls.hair")
print(f"with their followers they are {len(sim.followers.ids)} hairs")
