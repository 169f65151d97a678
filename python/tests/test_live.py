"""A simulation in a browser: a client connects as viser's page does, sees hair move and turns dials."""

import socket
import subprocess
import sys
import threading
import time
import urllib.request

import msgspec
import numpy as np
import pytest
import viser
import zstandard
from websockets.sync.client import connect

import windswept as ws


class Client:
    """What the page of viser is sent, and sends."""

    def __init__(self, url):
        protocol = f"viser-v{viser.__version__}"
        self.socket = connect(url.replace("http", "ws"), subprotocols=[protocol], max_size=None, compression=None)
        # Controls by their id, and points of what is drawn by its name.
        self.controls, self.points, self.messages = {}, {}, []
        self.until(lambda: self.messages and self.messages[-1]["type"] == "ReplayDoneMessage")
        # viser hears a client from its first camera on.
        x, y = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0)
        places = {"wxyz": (*x, 0.0), "position": x, "look_at": y, "up_direction": y}
        self.send("ViewerCameraMessage", **places, fov=1.0, near=0.1, far=9.0, image_height=48, image_width=64)

    def read(self):
        data = self.socket.recv(timeout=60)
        at = 16 + int.from_bytes(data[8:16], "little")
        sent = msgspec.msgpack.decode(zstandard.decompress(data[16:at]))
        arrays = []
        for length in sent["binaryBufferLengths"]:
            at = -(-at // 8) * 8
            arrays.append(data[at : at + length])
            at += length
        for message in sent["messages"]:
            self.messages.append(message)
            values = message.get("props") or message.get("updates") or {}
            if "uuid" in message:
                self.controls.setdefault(message["uuid"], {}).update(values)
            if "points" in values:
                buffer = arrays[values["points"]["__binary_index"]]
                self.points[message["name"]] = np.frombuffer(buffer, np.float32).reshape(-1, 3)

    def until(self, holds):
        end = time.monotonic() + 60
        while not holds():
            assert time.monotonic() < end
            self.read()

    def labels(self):
        return {values.get("label"): uuid for uuid, values in self.controls.items()}

    def send(self, kind, **values):
        self.socket.send(msgspec.msgpack.encode({"type": kind, **values}))

    def set(self, label, value):
        self.send("GuiUpdateMessage", uuid=self.labels()[label], updates={"value": value})

    def says(self, words):
        return any(words in values.get("_markdown", "") for values in self.controls.values())


@pytest.fixture
def page(sim):
    # A key that simulations keep has a dial too.
    page = ws.live(sim, 0, dials={"air.wind": (-5, 5), "rods.damping": (0, 1), "time.step": (1e-3, 2e-3)}, play=False)
    yield page
    page.stop()


@pytest.fixture
def client(page):
    client = Client(page.url)
    yield client
    client.socket.close()


def test_a_page_shows_a_simulation_and_its_dials_move_hair(scene, sim, client):
    segments = np.delete(np.arange(48), sim.hair.offsets[1:] - 1)
    twin, still = ws.Simulation(scene), ws.Simulation(scene)

    def is_shown(twin):
        hair, air = client.points["/hair"].reshape(-1, 2, 3), client.points["/air"]
        expected = twin.hair.positions[np.stack([segments, segments + 1], axis=1)]
        return np.array_equal(hair, expected) and np.array_equal(air, twin.air.positions)

    assert sim.steps == 0 and is_shown(twin)
    client.set("Step", True)
    client.until(lambda: client.says(", 1 steps"))
    twin.step()
    assert is_shown(twin)
    client.set("air.wind x", -2.0)
    client.set("air.wind z", 1.5)
    client.set("rods.damping", 0.5)
    while sim.scene["air.wind"].tolist() != [-2.0, 0.0, 1.5] or sim.scene["rods.damping"] != 0.5:
        time.sleep(0.01)
    twin.update(**{"air.wind": [-2.0, 0.0, 1.5], "rods.damping": 0.5})
    client.set("Step", True)
    client.until(lambda: client.says(", 2 steps"))
    twin.step()
    still.step(2)
    assert is_shown(twin) and not is_shown(still)


def test_it_plays_until_it_is_paused(sim, client):
    client.set("Play", True)
    client.until(lambda: sim.steps >= 7)
    client.set("Play", False)
    time.sleep(0.5)
    steps = sim.steps
    time.sleep(0.5)
    assert sim.steps == steps
    client.until(lambda: client.says(f", {steps} steps"))
    # It goes no faster than time, or than its part that is asked for.
    client.set("Speed", 0.1)
    client.set("Play", True)
    begun, before = time.monotonic(), sim.time
    client.until(lambda: sim.steps >= steps + 20)
    assert sim.time - before < 0.2 * (time.monotonic() - begun)


def test_what_cannot_be_is_said_and_it_goes_on(sim, client):
    client.set("time.step", 1.5e-3)
    client.until(lambda: client.says("time.step"))
    client.set("Step", True)
    client.until(lambda: client.says(", 1 steps"))
    assert client.says("start another simulation")
    client.set("rods.damping", 0.5)
    client.until(lambda: not client.says("time.step"))
    # A lost device pauses it.
    client.set("Play", True)
    client.until(lambda: sim.steps >= 3)
    sim._lose_device()
    client.until(lambda: client.says("lost"))
    play = client.labels()["Play"]
    client.until(lambda: any(m.get("uuid") == play and m.get("updates") == {"value": False} for m in client.messages))


def test_a_page_is_for_this_machine_alone_and_stop_frees_its_port(page, client):
    with urllib.request.urlopen(page.url) as response:
        assert response.status == 200 and b"<html" in response.read()
    assert page.url in repr(page) and page.url in page._repr_html_()
    (theme,) = (message for message in client.messages if message["type"] == "ThemeConfigurationMessage")
    assert not theme["show_share_button"]
    port = int(page.url.rsplit(":")[-1])
    if sys.platform == "linux":
        # Another address of this machine still has the port free.
        socket.create_server(("127.0.0.2", port)).close()
    with pytest.raises(OSError):
        socket.create_server(("127.0.0.1", port))
    threading.Timer(0.2, page.stop).start()
    page.wait()
    page.stop()
    socket.create_server(("127.0.0.1", port)).close()


def test_the_usual_dials_are_those_that_a_scene_has(scene):
    usual = {f"{key} {axis}" for key in ("air.wind", "gravity") for axis in "xyz"}
    usual.add("rods.damping")
    dials = {"turbulence.scale", "turbulence.intensity"}
    for scene, more in [(scene, set()), (scene.replace(turbulence={"scale": 0.006, "intensity": 0.1}), dials)]:
        page = ws.live(ws.Simulation(scene), 0)
        labels = Client(page.url).labels().keys()
        page.stop()
        assert labels & (usual | dials) == usual | more


def test_what_live_cannot_take_is_named(sim):
    for words, error, said in [
        ({"port": 70000}, ValueError, "port: expected 0 to 65535, found 70000"),
        ({"dials": {"air.wnd": (0, 1)}}, ws.SceneError, "did you mean wind"),
        ({"dials": {"air.wind": (1, 0)}}, ValueError, r"lowest and the highest value of air.wind, found \(1, 0\)"),
        ({"dials": {"title": (0, 1)}}, ValueError, "expected keys of numbers and vectors, found title"),
    ]:
        with pytest.raises(error, match=said):
            ws.live(sim, **words)
    with pytest.raises(TypeError, match="sim: expected a windswept.Simulation, found Scene"):
        ws.live(sim.scene)


def test_without_viser_the_error_says_what_to_install(sim):
    start = "import sys; sys.modules['viser'] = None; import windswept as ws; "
    code = f"{start}ws.live(ws.Simulation(ws.Scene.parse(sys.argv[1])))"
    done = subprocess.run([sys.executable, "-c", code, sim.scene.text], capture_output=True, text=True)
    assert done.stderr.endswith("ImportError: windswept.live needs viser: pip install 'windswept[live]'\n")
