"""A small brush in turbulent wind, frame by frame, into a film and a picture.

    python examples/02_brush_in_wind.py     # writes hair.vtkhdf and brush.png
"""

import windswept as ws

scene = ws.Scene(
    time=ws.Time(step=1.38e-3, duration=1.0),
    hair=ws.Hair(strands=60, points=11, length=0.10, roots=ws.Disc(center=[0.056, 0.065, 0.035], radius=0.017, direction=[1, 0.1, 0])),
    air=ws.Air(box=[0.16, 0.12, 0.07], wind=[3, 0, 0]),
    turbulence=ws.Turbulence(scale=0.006),
)
sim = ws.Simulation(scene)
with ws.VtkHdfWriter("hair.vtkhdf", sim) as film:
    for frame in sim.frames(3):
        film.append(sim)
        print(f"{1e3 * frame.time:.1f} ms")
ws.write_png("brush.png", sim.render())
print(f"{sim.report().get('ms_per_step', 0.0):.1f} ms a step")
