"""One strand, clamped level, hangs under its own weight: hair alone, no air, no file.

    python examples/01_one_strand.py
"""

import windswept as ws

SCENE = """
title = "One strand"
interaction = { model = "none" }
[time]
step = 1.38e-3
duration = 2.0
[hair]
strands = 1
points = 21
length = 0.10
roots = { center = [0.0, 0.0, 0.0], radius = 1.0e-3, direction = [1.0, 0.0, 0.0] }
[rods]
damping = 8.0
"""

sim = ws.Simulation(ws.Scene.parse(SCENE))
print("running on", sim.adapter)
for _ in range(5):
    sim.step(290)
    root, tip = sim.hair.positions[[0, -1]]
    below, ahead = 1e3 * (root[1] - tip[1]), 1e3 * (tip[0] - root[0])
    print(f"t = {sim.time:.2f} s: the tip is {below:.1f} mm below the root, {ahead:.1f} mm ahead")
