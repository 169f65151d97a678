# %% [markdown]
# Figure 3(a) against 3(c): the same hair behind eddies of 6 mm, and of 18 mm.
#
#     python examples/fig3a_against_fig3c.py           # the small copies, 1 s each: minutes on a CPU
#     python examples/fig3a_against_fig3c.py --small   # a few frames, to see it work
#
# Writes out/fig3/tips.png (how far the tips swing), out/fig3/spectrum.png (which eddies the air has),
# out/fig3/difference.png (what the larger eddies change: energy by size, swing over time) and the two pictures, side by
# side in out/fig3/both.png.

# %%
import sys
from pathlib import Path

import matplotlib

matplotlib.use("agg")
import matplotlib.pyplot as plt
import numpy as np

import windswept as ws

FEW = "--small" in sys.argv
SCENES = Path(__file__).parent / "scenes/small"
OUT = Path("out/fig3")
OUT.mkdir(parents=True, exist_ok=True)

# %%
sims, swings = {}, {}
for name, label in [("fig3a", "eddies of 6 mm"), ("fig3c", "eddies of 18 mm")]:
    scene = ws.Scene.load(SCENES / f"{name}.toml")
    if FEW:
        scene = scene.replace(**{"time.frame_rate": 240, "picture.hairs": 1000, "camera.width": 320, "camera.height": 180})
    sim = ws.Simulation(scene)
    tips = sim.hair.offsets[1:] - 1
    times, paths = [], []
    for frame in sim.frames(2 if FEW else 60):
        times.append(frame.time)
        paths.append(frame.hair.positions[tips])
    ws.write_png(OUT / f"{name}.png", sim.render())
    # The swing is across wind and gravity, about where each tip is on average.
    across = np.array(paths)[:, :, 2]
    swings[label] = times, across - across.mean(axis=0)
    sims[label] = sim
    print(f"{name}: the tips swing by {1e3 * swings[label][1].std():.2f} mm rms; {sim}")

# %%
figure, ax = plt.subplots(figsize=(7, 4))
for (label, (times, swing)), color in zip(swings.items(), ("tab:blue", "tab:orange")):
    ax.plot(times, 1e3 * swing, color=color, alpha=0.15, linewidth=0.7)
    ax.plot(times, 1e3 * swing.std(axis=1), color=color, label=f"{label}: rms over the strands")
ax.set_xlabel("time [s]")
ax.set_ylabel("tips, sideways [mm]")
ax.legend()
figure.savefig(OUT / "tips.png", dpi=150)

# %%
figure, ax = plt.subplots(figsize=(6, 4))
for label, sim in sims.items():
    ws.plot.spectrum(sim, ax=ax, label=label)
for scale in (0.006, 0.018):
    # A band's centre is at k s = √2.
    ax.axvline(np.sqrt(2) / scale, color="grey", linewidth=0.5)
ax.legend()
figure.savefig(OUT / "spectrum.png", dpi=150)

# %%
figure, (left, right) = plt.subplots(1, 2, figsize=(11, 4), layout="constrained")
scales = np.geomspace(0.005, 0.02, 7)
small, large = (sim.spectrum(scales) for sim in sims.values())
left.plot(1e3 * scales, 1e6 * (large - small), marker="o")
left.axhline(0.0, color="grey", linewidth=0.5)
left.set_xlabel("scale s [mm]")
left.set_ylabel("energy of the band, 18 mm less 6 mm [mm²/s²]")
(times, of_small), (_, of_large) = swings.values()
right.plot(times, 1e3 * (of_large.std(axis=1) - of_small.std(axis=1)))
right.axhline(0.0, color="grey", linewidth=0.5)
right.set_xlabel("time [s]")
right.set_ylabel("rms swing of the tips, 18 mm less 6 mm [mm]")
figure.savefig(OUT / "difference.png", dpi=150)
ws.contact_sheet([OUT / "fig3a.png", OUT / "fig3c.png"], OUT / "both.png")
for scale, a, c in zip(scales, small, large):
    print(f"s = {1e3 * scale:4.1f} mm: {1e6 * a:9.1f} mm²/s² behind 6 mm, {1e6 * c:9.1f} behind 18 mm")
print("pictures in", OUT)
