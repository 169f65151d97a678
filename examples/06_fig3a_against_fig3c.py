# %% [markdown]
# Figure 3(a) against 3(c): the same hair behind eddies of 6 mm, and of 18 mm.
#
#     python examples/06_fig3a_against_fig3c.py           # the small copies, 1 s each: minutes on a CPU
#     python examples/06_fig3a_against_fig3c.py --small   # a few frames, to see it work
#
# Writes out/fig3/both.png, the two pictures, and out/fig3/difference.png: how far the tips swing, and which eddies the
# air has.

# %%
import sys
from pathlib import Path

import matplotlib

matplotlib.use("agg")
import matplotlib.pyplot as plt
import numpy as np

import windswept as ws

FEW = "--small" in sys.argv
OUT = Path("out/fig3")
OUT.mkdir(parents=True, exist_ok=True)

# %%
figure, (left, right) = plt.subplots(1, 2, figsize=(11, 4), layout="constrained")
scales = np.geomspace(0.005, 0.02, 7)
for name, label, color in [("fig3a", "eddies of 6 mm", "tab:blue"), ("fig3c", "eddies of 18 mm", "tab:orange")]:
    scene = ws.Scene.load(Path(__file__).parent / f"scenes/small/{name}.toml")
    if FEW:
        scene.time.frame_rate, scene.picture.hairs = 240, 1000
        scene.camera = [ws.Camera(width=320, height=180)]
    sim = ws.Simulation(scene)
    tips = sim.hair.offsets[1:] - 1
    frames = [(frame.time, frame.hair.positions[tips, 2]) for frame in sim.frames(2 if FEW else 60)]
    ws.write_png(OUT / f"{name}.png", sim.render())
    # The swing is across wind and gravity, about where each tip is on average.
    times, across = (np.array(values) for values in zip(*frames))
    swing, energy = 1e3 * (across - across.mean(axis=0)), 1e6 * sim.spectrum(scales)
    left.plot(times, swing, color=color, alpha=0.15, linewidth=0.7)
    left.plot(times, swing.std(axis=1), color=color, label=f"{label}: rms over the strands")
    right.plot(1e3 * scales, energy, color=color, marker="o", label=label)
    print(f"{name}: the tips swing by {swing.std():.2f} mm rms; energy by size {np.round(energy)} mm²/s²")

# %%
left.set(xlabel="time [s]", ylabel="tips, sideways [mm]")
right.set(xlabel="scale s [mm]", ylabel="energy of the band [mm²/s²]")
left.legend()
right.legend()
figure.savefig(OUT / "difference.png", dpi=150)
ws.contact_sheet([OUT / "fig3a.png", OUT / "fig3c.png"], OUT / "both.png")
print("pictures in", OUT)
