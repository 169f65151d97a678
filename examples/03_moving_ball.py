"""A ball that the program moves through hair in wind, and the forces that it meets, into a picture.

    python examples/03_moving_ball.py     # writes ball.png
"""

import numpy as np

import windswept as ws

scene = ws.Scene(
    time=ws.Time(step=1.38e-3, substeps=2, duration=1.0),
    hair=ws.Hair(strands=60, points=11, length=0.10, roots=ws.Disc(center=[0.056, 0.065, 0.035], radius=0.017, direction=[1, 0.1, 0])),
    air=ws.Air(box=[0.16, 0.12, 0.07], wind=[3, 0, 0]),
    body=ws.Body(name="ball", shape=ws.Sphere(center=[0.09, 0.03, 0.035], radius=0.012)),
)
sim = ws.Simulation(scene)
for k in range(1, 31):
    sim.set_body("ball", [0, 0.03 * np.sin(0.05 * k), 0])
    sim.step()
print(f"air drags the hair with {sim.hair.drag.sum(axis=0)} N, and has given the ball {sim.body_impulses()[0]} N s")
ws.write_png("ball.png", sim.render())
