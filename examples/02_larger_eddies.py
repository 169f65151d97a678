"""A small brush in turbulent wind whose eddies grow while it runs, frame by frame, into a film and a picture.

    python examples/02_larger_eddies.py     # writes hair.vtkhdf and brush.png
"""

import windswept as ws

scene = ws.Scene(
    time=ws.Time(step=1.38e-3, substeps=2, duration=1.0),
    hair=ws.Hair(strands=60, points=11, length=0.10, roots=ws.Disc(center=[0.056, 0.065, 0.035], radius=0.017, direction=[1, 0.1, 0])),
    air=ws.Air(box=[0.16, 0.12, 0.07], wind=[3, 0, 0]),
    turbulence=ws.Turbulence(scale=0.006),
)
sim = ws.Simulation(scene)
with ws.VtkHdfWriter("hair.vtkhdf", sim) as film:
    for scale in [0.006, 0.012, 0.018, 0.024]:
        sim.update(**{"turbulence.scale": scale})
        for frame in sim.frames(1):
            film.append(sim)
            print(f"t = {1e3 * frame.time:.1f} ms: eddies of {1e3 * scale:.0f} mm, {sim.spectrum([scale])[0]:.3f} m²/s²")
ws.write_png("brush.png", sim.render())
