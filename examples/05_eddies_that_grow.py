"""Eddies grow from 6 to 18 mm while the simulation runs: which sizes have the energy?

    python examples/05_eddies_that_grow.py
"""

import windswept as ws

sim = ws.Simulation(
    ws.Scene(
        time=ws.Time(step=1.38e-3, substeps=2, duration=1.0),
        air=ws.Air(box=[0.12, 0.08, 0.08], wind=[3, 0, 0], ramp=0.0),
        turbulence=ws.Turbulence(scale=0.006),
    )
)
for scale in [0.006, 0.012, 0.018]:
    sim.update(**{"turbulence.scale": scale})
    sim.step(10)
    energy = ", ".join(f"{e:.3f} m²/s² at {1e3 * s:.0f} mm" for s, e in zip([0.006, 0.018], sim.spectrum([0.006, 0.018])))
    print(f"t = {1e3 * sim.time:.0f} ms, scale {sim.scene['turbulence.scale']}: {energy}")
