"""One strand, clamped level, hangs under its own weight: hair alone, no air, no file.

    python examples/01_one_strand.py
"""

import windswept as ws

scene = ws.Scene(
    time=ws.Time(step=1.38e-3, duration=2.0),
    interaction=ws.Interaction(model="none"),
    hair=ws.Hair(strands=1, points=21, length=0.10, roots=ws.Disc(center=[0, 0, 0], radius=1e-3, direction=[1, 0, 0])),
    rods=ws.Rods(damping=8.0),
)
sim = ws.Simulation(scene)
print("running on", sim.adapter)
for _ in range(5):
    sim.step(290)
    root, tip = sim.hair.positions[[0, -1]]
    below, ahead = 1e3 * (root[1] - tip[1]), 1e3 * (tip[0] - root[0])
    print(f"t = {sim.time:.2f} s: the tip is {below:.1f} mm below the root, {ahead:.1f} mm ahead")
