"""One device, shared: two simulations on two threads, and a single pass on arrays of your own.

    python examples/04_own_device.py

Every simulation on the same adapter has the same device; `adapter=` chooses it.
"""

import threading
from pathlib import Path

import numpy as np

import windswept as ws

scene = ws.Scene.load(Path(__file__).parent / "scenes/quick.toml")
bare = ws.Scene(time=ws.Time(step=1.38e-3, duration=1.0), interaction=ws.Interaction(model="none"))

# Strands of our own beside a scene's.
points = np.zeros((2, 20, 3))
points[..., 1] = -0.005 * np.arange(20)
points[1, :, 2] = 0.01
strands = ws.Simulation(bare, groom=ws.Groom(points, radius=[4e-5, 8e-5]))
brush = ws.Simulation(scene)
print("running on", brush.adapter)

# The interpreter is free while either steps.
threads = [threading.Thread(target=brush.step, args=(3,)), threading.Thread(target=strands.step, args=(100,))]
for thread in threads:
    thread.start()
for thread in threads:
    thread.join()
print(f"{brush.steps} steps of the brush, {strands.steps} of the strands")

# The wind and the roots, driven from here.
brush.set_wind([4.0, 0.0, 1.0])
brush.step(1)
print(f"the air now blows with {brush.air.velocities.mean(axis=0)} m/s")
roots = points[:, 0]
strands.run(0.05, callback=lambda sim: sim.set_roots(roots + [0.005 * np.sin(40 * sim.time), 0, 0]))
print(f"the tips are {1e3 * strands.hair.positions[[19, 39], 0]} mm to the side")

density = ws.ops.density(brush.air.positions, mass=1.46e-7, radius=9.3e-3)
print(f"{density.mean():.3f} kg/m³ of air on average")
