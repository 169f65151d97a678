"""What comes out: films, pictures, plots, the command."""

import subprocess
import sys

import numpy as np
import pytest

import windswept as ws


def test_a_film_is_written_frame_by_frame(sim, tmp_path):
    h5py = pytest.importorskip("h5py")
    kept = []
    with ws.VtkHdfWriter(tmp_path / "hair.vtkhdf", sim) as hair, ws.VtkHdfWriter(tmp_path / "air.vtkhdf", sim, kind="air") as air:
        for writer in (hair, air):
            writer.append(sim)
        for frame in sim.frames(2):
            kept.append(frame)
            hair.append(sim)
            air.append(sim)
        assert "hair" in repr(hair)
    with h5py.File(tmp_path / "hair.vtkhdf") as file:
        root = file["VTKHDF"]
        assert root["Steps"].attrs["NSteps"] == 3
        assert np.allclose(root["Steps/Values"], [0.0] + [frame.time for frame in kept])
        assert np.array_equal(root["Points"][48:96], kept[0].hair.positions)
        assert "Small" in str(file["windswept/scene"][()])
    with h5py.File(tmp_path / "air.vtkhdf") as file:
        assert np.array_equal(file["VTKHDF/Points"][-len(kept[1].air.positions) :].shape, kept[1].air.positions.shape)
    with pytest.raises(ValueError, match="closed"):
        hair.append(sim)
    hair.close()


def test_a_film_that_cannot_be_written_says_so(sim, bare, tmp_path):
    with pytest.raises(ws.ExportError):
        ws.VtkHdfWriter(tmp_path / "no" / "such" / "folder.vtkhdf", sim)
    with pytest.raises(ValueError, match="kind"):
        ws.VtkHdfWriter(tmp_path / "x", sim, kind="both")
    with ws.VtkHdfWriter(tmp_path / "x.vtkhdf", sim, frames=1) as writer:
        writer.append(sim)
        sim.step()
        with pytest.raises(ws.ExportError):
            writer.append(sim)
    alone = ws.Simulation(bare, groom=ws.Groom([[[0, 0, 0], [0.01, 0, 0]]]))
    with pytest.raises(ws.ExportError, match="air"):
        ws.VtkHdfWriter(tmp_path / "y.vtkhdf", alone, kind="air")


def test_pictures_show_the_hair(sim, tmp_path):
    image = pytest.importorskip("PIL.Image")
    picture = sim.render(width=160, height=90)
    assert picture.shape == (90, 160, 4) and picture.dtype == np.uint8 and (picture[..., 3] == 255).all()
    assert picture[..., :3].std() > 5
    assert np.array_equal(picture, sim.render(width=160, height=90)), "the same state, the same picture"
    sim.run(0.03)
    assert not np.array_equal(picture, sim.render(width=160, height=90))
    assert sim.render().shape == (180, 320, 4)
    # From elsewhere, with the renderer of the scene's camera: as a camera of the scene that stands there.
    eye, target = [0.2, 0.05, 0.1], np.array([0.02, 0.03, 0.02])
    cameras = [ws.Camera(width=160, height=90), ws.Camera(name="side", eye=eye, target=target, fov=30, width=160, height=90)]
    there = ws.Simulation(sim.scene.replace(camera=cameras))
    there.step(int(sim.steps))
    picture = there.render(camera="side")
    assert picture.shape == (90, 160, 4) and not np.array_equal(picture, there.render())
    assert np.array_equal(picture, there.render(eye=eye, target=target, fov=30))
    assert np.array_equal(there.render(), there.render(camera="camera"))
    for wrong, words in [
        ({"camera": "back"}, "camera: expected one of camera, side, found \"back\""),
        ({"eye": eye}, "target: expected one beside eye"),
        ({"target": eye}, "eye: expected one beside target"),
        ({"eye": eye, "target": eye}, "the same point"),
        ({"fov": 200}, "fov: expected an angle below 180 degrees"),
        ({"eye": [1, 2]}, "eye: expected three numbers"),
    ]:
        with pytest.raises(ValueError, match=words):
            there.render(**wrong)
    ws.write_png(tmp_path / "a.png", picture)
    assert np.array_equal(np.asarray(image.open(tmp_path / "a.png")), picture[..., :3])
    ws.contact_sheet([tmp_path / "a.png"] * 3, tmp_path / "sheet.png")
    assert image.open(tmp_path / "sheet.png").width > 480
    for bad in (0, 15, -5, 10**6, 2**40):
        with pytest.raises((ValueError, ws.ExportError)):
            sim.render(width=bad)
    for bad in (picture[..., :3], picture.astype(float), np.zeros((0, 4, 4), np.uint8), "picture"):
        with pytest.raises(ValueError, match="picture"):
            ws.write_png(tmp_path / "b.png", bad)


def test_the_spectrum_has_the_energy_of_its_waves():
    from windswept import plot

    rng = np.random.default_rng(3)
    box = np.array([[0.0, 0.0, 0.0], [0.2, 0.1, 0.1]])
    x = rng.uniform(box[0], box[1], size=(60_000, 3))
    k = 2 * np.pi / 0.1 * 2
    v = np.stack([np.zeros(len(x)), 0.3 * np.sin(k * x[:, 0]), np.ones(len(x))], -1)
    waves, energy = plot.energy_spectrum(x, v, box)
    # ½ ⟨u²⟩ = 0.0225 m²/s² in one shell, less what the mean over a cell takes from this wave; measured 0.4 % more,
    # noise.
    cell = 0.2 / round(0.2 / (2 * (2e-3 / len(x)) ** (1 / 3)))
    total = energy.sum() * (waves[1] - waves[0])
    assert total == pytest.approx(0.0225 * np.sinc(k * cell / (2 * np.pi)) ** 2, rel=0.015)
    assert waves[energy.argmax()] == pytest.approx(k) and energy.max() > 0.97 * energy.sum()
    with pytest.raises(ValueError, match="box"):
        plot.energy_spectrum(x, v, box[::-1])


def test_plots_draw(sim, bare, tmp_path):
    pyplot = pytest.importorskip("matplotlib.pyplot")
    sim.step(5)
    figure, (left, right) = pyplot.subplots(1, 2)
    assert ws.plot.spectrum(sim, ax=left, label="small") is left
    assert ws.plot.profile(sim, along="y", component="x", bins=10, ax=right) is right
    figure.savefig(tmp_path / "plots.png")
    assert (right.lines[0].get_xdata() > 1.0).any()
    with pytest.raises(ValueError, match="along"):
        ws.plot.profile(sim, along="w")
    alone = ws.Simulation(bare, groom=ws.Groom([[[0, 0, 0], [0.01, 0, 0]]]))
    for plot in (ws.plot.spectrum, ws.plot.profile):
        with pytest.raises(ValueError, match="no air"):
            plot(alone, ax=left)


def test_the_wheel_carries_the_command(tmp_path):
    def run(*words, **more):
        return subprocess.run([sys.executable, "-m", "windswept", *words], capture_output=True, text=True, **more)

    done = run("adapters")
    assert done.returncode == 0 and ws.adapters()[0]["name"] in done.stdout
    assert run("nonsense").returncode == 2
    script = next(p for p in (tmp_path.__class__(sys.executable).parent).glob("windswept*"))
    done = subprocess.run([script, "--help"], capture_output=True, text=True)
    assert done.returncode == 0 and "check" in done.stdout


def contents(path):
    """Every number of a film that its frames decide, by its name in the file."""
    h5py = pytest.importorskip("h5py")
    found = {}
    with h5py.File(path) as file:
        finished = file["VTKHDF/Steps"].attrs["NSteps"]
        found["Times"] = file["VTKHDF/Steps/Values"][:finished]
        points = finished * file["VTKHDF/NumberOfPoints"][0]
        found["Points"] = file["VTKHDF/Points"][:points]
        for name, data in file["VTKHDF/PointData"].items():
            found[name] = data[:points]
    return found


@pytest.mark.parametrize(("air", "scalar"), [("vorticity", "Vorticity"), ("band_energy", "BandEnergy")])
def test_the_writers_write_what_the_command_writes(scene, tmp_path, air, scalar):
    bands = [{"scale": 0.009, "strength": 30.0}]
    scene = scene.replace(**{"picture.air": air, "turbulence": {"bands": bands}, "time.duration": 0.035})
    (tmp_path / "scene.toml").write_text(scene.to_toml())
    words = ["run", tmp_path / "scene.toml", "--out", tmp_path / "command"]
    done = subprocess.run([sys.executable, "-m", "windswept", *words], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr

    sim = ws.Simulation(scene)
    one = tmp_path / "one.vtkhdf"
    with ws.Writer(tmp_path / "python", sim) as folder, ws.VtkHdfWriter(one, sim, kind="air") as film:
        for writer in (folder, film):
            writer.append(sim)
        for frame in sim.frames():
            folder.append(sim)
            film.append(sim)
    assert "vtkhdf" in repr(folder)
    for kind in ("hair", "air"):
        command = contents(tmp_path / "command" / f"{kind}.vtkhdf")
        ours = contents(tmp_path / "python" / f"{kind}.vtkhdf")
        assert len(command["Times"]) == 3 and command.keys() == ours.keys()
        for name, values in command.items():
            assert np.array_equal(values, ours[name]), (kind, name)
    assert command[scalar].any() and scalar not in contents(tmp_path / "command/hair.vtkhdf")
    alone = contents(one)
    assert alone.keys() == command.keys() and all(np.array_equal(command[name], alone[name]) for name in command)
    # A frame has them too, and the pictures are the same.
    assert np.array_equal(getattr(frame.air, air), command[scalar][-len(frame.air.positions) :])
    for name in ["preview.gif", *(f"frames/{k:04}.png" for k in range(3))]:
        assert (tmp_path / "command" / name).read_bytes() == (tmp_path / "python" / name).read_bytes(), name


def test_a_folder_has_one_writer(sim, tmp_path):
    out = tmp_path / "out"
    with ws.Writer(out, sim) as writer:
        writer.append(sim)
        there = sorted(path.name for path in out.iterdir())
        with pytest.raises(ws.ExportError, match="out: another run is writing here"):
            ws.Writer(out, sim)
        assert ".windswept.lock" in there and sorted(path.name for path in out.iterdir()) == there
    assert not (out / ".windswept.lock").exists()
    # What is there is not lost unless that is asked for, and then nothing of it stays to be taken for the new run's.
    there = {path.name: path.read_bytes() for path in out.iterdir() if path.is_file()}
    with pytest.raises(ws.ExportError, match="is of an earlier run; overwrite=True replaces"):
        ws.Writer(out, sim)
    assert {path.name: path.read_bytes() for path in out.iterdir() if path.is_file()} == there
    for name in ("report.json", "checkpoint.windswept", "film.npz", "mine.txt"):
        (out / name).write_text("of before")
    with ws.Writer(out, sim, formats=["usd"], overwrite=True):
        pass
    assert sorted(path.name for path in out.iterdir() if path.is_file()) == ["mine.txt", "scene.toml"]
    (out / "frames").mkdir()
    # Half a picture that a killed writer left goes.
    half = out / "frames/0007.png.part"
    half.write_text("half")
    with ws.Writer(out, sim, overwrite=True) as writer:
        assert not half.exists()
        writer.append(sim)
    # Pictures behind a link are somebody else's.
    (out / "frames").rename(tmp_path / "other")
    before = {path.name: path.read_bytes() for path in (tmp_path / "other").iterdir()}
    (out / "frames").symlink_to(tmp_path / "other")
    with pytest.raises(ws.ExportError, match="frames: is a link; expected a folder or nothing"):
        ws.Writer(out, sim, overwrite=True)
    assert {path.name: path.read_bytes() for path in (tmp_path / "other").iterdir()} == before
    assert not (out / ".windswept.lock").exists()


def test_the_command_reads_what_a_writer_wrote(sim, tmp_path):
    with ws.Writer(tmp_path / "out", sim, formats=["vtkhdf"]) as writer:
        writer.append(sim)
        sim.step(20)
        writer.append(sim)
    for words in (["render"], ["export", "--format", "npz"]):
        done = subprocess.run([sys.executable, "-m", "windswept", *words, tmp_path / "out"], capture_output=True, text=True)
        assert done.returncode == 0, done.stderr
    assert len(list((tmp_path / "out/frames").iterdir())) == 2 and (tmp_path / "out/film.npz").exists()


def test_a_writer_names_what_it_cannot_write(sim, tmp_path):
    assert {"vtkhdf", "png"} <= ws.formats().keys() and all(ws.formats().values())
    with pytest.raises(ValueError, match="formats: expected some of"):
        ws.Writer(tmp_path / "a", sim, formats=["abc"])
    with pytest.raises(ValueError, match="frames"):
        ws.Writer(tmp_path / "a", sim, frames=0)
    (tmp_path / "file").write_text("mine")
    with pytest.raises(ws.ExportError, match="file: could not be made"):
        ws.Writer(tmp_path / "file", sim)
    # Pictures that cannot be saved are told once; the film goes on without them.
    (tmp_path / "b").mkdir()
    (tmp_path / "b" / "frames").write_text("mine")
    with ws.Writer(tmp_path / "b", sim) as writer:
        with pytest.raises(ws.ExportError, match="frames: could not be made"):
            writer.append(sim)
        sim.step()
        writer.append(sim)
        with pytest.raises(ws.ExportError, match="b: a frame at .* cannot follow the one at"):
            writer.append(sim)
    assert len(contents(tmp_path / "b" / "hair.vtkhdf")["Times"]) == 2
    # A film without room costs the other format no frame.
    with ws.Writer(tmp_path / "c", sim, formats=["vtkhdf", "usd"], frames=1) as writer:
        writer.append(sim)
        sim.step()
        with pytest.raises(ws.ExportError, match="is one more than the 1 announced"):
            writer.append(sim)
    assert len(contents(tmp_path / "c" / "hair.vtkhdf")["Times"]) == 1
    layer = (tmp_path / "c" / "hair.usda").read_text()
    assert float(layer.split("endTimeCode = ")[1].split()[0]) == pytest.approx(60 * sim.time)
    with pytest.raises(ValueError, match="closed"):
        writer.append(sim)
