"""A small brush in turbulent wind, frame by frame, into a film and a picture.

    python examples/02_brush_in_wind.py     # writes out/brush/hair.vtkhdf and out/brush/last.png
"""

from pathlib import Path

import windswept as ws

FRAMES = 3

scene = ws.Scene.load(Path(__file__).parent / "scenes/quick.toml")
sim = ws.Simulation(scene)
print(sim)

out = Path("out/brush")
out.mkdir(parents=True, exist_ok=True)
with ws.VtkHdfWriter(out / "hair.vtkhdf", sim, frames=FRAMES) as film:
    for k, frame in enumerate(sim.frames(FRAMES), 1):
        film.append(sim)
        print(f"frame {k}: {1e3 * frame.time:.1f} ms")
ws.write_png(out / "last.png", sim.render())

report = sim.report()
print(f"{report['ms_per_step']:.1f} ms a step, over-density {report['over_density_rms']:.4f}")
