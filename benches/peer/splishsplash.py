"""The peer of `cargo xtask bench --peer`: a step of SPlisHSPlasH's position-based fluid, beside which windswept's is timed.

    python splishsplash.py PARTICLES STEPS

PBF with 2 iterations, vorticity confinement and XSPH, on a cube of about PARTICLES particles at the spacing and the step of
examples/scenes/fig2b.toml; no boundary. It does less than windswept's step: it has no band filter, no rods and no exchange
with hair. Prints two lines, `wall` with the median time of a step [ms] and `particles`, as benches/round.rs does.

Needs pysplishsplash from PyPI, and libGLdispatch.so.0 loaded before it (on Debian and Ubuntu `apt-get install libglvnd0`):
`cargo xtask bench` sets LD_PRELOAD to it where it finds it. Without it the import ends the process.
"""

import json
import os
import statistics
import sys
import tempfile
import time

SPACING = 4.84e-3  # m, of fig2b's air
STEP = 1.38e-3  # s
DENSITY = 1.29  # kg/m^3
WARM_UP = 2  # steps

particles, steps = int(sys.argv[1]), int(sys.argv[2])
# A block that is n + 1 spacings wide gets n particles; a little more, so that rounding takes none.
side = (round(particles ** (1 / 3)) + 1.001) * SPACING
scene = {
    "Configuration": {
        "particleRadius": SPACING / 2,
        "simulationMethod": 2,
        "gravitation": [0, 0, 0],
        "timeStepSize": STEP,
        "cflMethod": 0,
        "stopAt": (WARM_UP + steps + 0.5) * STEP,
        "boundaryHandlingMethod": 0,
        "numberOfStepsPerRenderUpdate": 1,
        "PBF": {"minIterations": 2, "maxIterations": 2, "maxError": 1e-4},
    },
    "Materials": [
        {
            "id": "Fluid",
            "density0": DENSITY,
            "viscosityMethod": 0,
            "vorticityMethod": 2,
            "xsph": 0.014,
            "Vorticity confinement": {"vorticity": 0.008},
        }
    ],
    "FluidBlocks": [
        {"denseMode": 0, "start": [0, 0, 0], "end": [side] * 3, "id": "Fluid", "initialVelocity": [3, 0, 0]}
    ],
}

folder = tempfile.mkdtemp(prefix="splishsplash")
path = os.path.join(folder, "scene.json")
with open(path, "w") as file:
    json.dump(scene, file)

# Output from its start must not be taken for times.
out = os.dup(1)
os.dup2(2, 1)

import pysplishsplash as sph  # noqa: E402

simulator = sph.Exec.SimulatorBase()
simulator.init(sceneFile=path, useGui=False, initialPause=False, useCache=False, outputDir=folder)
simulator.initSimulation()
ends = [time.perf_counter()]
simulator.setTimeStepCB(lambda: ends.append(time.perf_counter()))
simulator.runSimulation()
times = [(after - before) * 1e3 for before, after in zip(ends, ends[1:])][WARM_UP:]
found = sph.Simulation.getCurrent().getFluidModel(0).numActiveParticles()
os.write(out, f"wall\t{statistics.median(times):.4f}\nparticles\t{found}\n".encode())
os._exit(0)  # the library's own shutdown is not reliable
