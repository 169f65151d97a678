"""What the tests share: a small scene, on the software adapter unless WGPU_ADAPTER_NAME names another."""

import os

os.environ.setdefault("WGPU_ADAPTER_NAME", "software")
os.environ.setdefault("MPLBACKEND", "agg")

import pytest

import windswept as ws

SCENE = """
title = "Small"
time = { step = 1.38e-3, duration = 0.05 }
[hair]
strands = 8
points = 6
length = 0.02
roots = { center = [0.02, 0.03, 0.0225], radius = 0.01, direction = [0.0, -1.0, 0.0] }
[air]
box = { min = [0.0, 0.0, 0.0], max = [0.06, 0.045, 0.045] }
wind = [3.0, 0.0, 0.0]
ramp = 0.0
fringe = 0.02
[camera]
width = 320
height = 180
[picture]
hairs = 500
"""

#: Hair alone.
BARE = 'time = { step = 1.38e-3, duration = 0.05 }\ninteraction = { model = "none" }\n'


@pytest.fixture
def scene() -> ws.Scene:
    return ws.Scene.parse(SCENE)


@pytest.fixture
def bare() -> ws.Scene:
    return ws.Scene.parse(BARE)


@pytest.fixture
def sim(scene: ws.Scene) -> ws.Simulation:
    return ws.Simulation(scene)
