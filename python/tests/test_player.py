"""What a notebook shows of a simulation, and films with a slider."""

import base64
import html
import io
from html.parser import HTMLParser

import numpy as np
import pytest
from PIL import Image

import windswept as ws


class Page(HTMLParser):
    """The pictures of a page, and the attributes of what has an id."""

    def __init__(self, text):
        super().__init__()
        self.pictures, self.named = [], {}
        self.feed(text)
        self.close()

    def handle_starttag(self, tag, attributes):
        values = dict(attributes)
        if "id" in values:
            self.named[values["id"]] = values
        if tag == "img":
            head, data = values["src"].split(",")
            assert head == "data:image/png;base64"
            self.pictures.append(np.asarray(Image.open(io.BytesIO(base64.b64decode(data))).convert("RGBA")))


def test_a_notebook_shows_the_picture_of_a_simulation(sim, bare):
    sim.step(2)
    (picture,) = Page(sim._repr_html_()).pictures
    np.testing.assert_array_equal(picture, sim.render())
    assert "llvmpipe" in sim._repr_html_()
    # Without a device there are words.
    sim._lose_device()
    assert "lost" in sim._repr_html_() and "<img" not in sim._repr_html_()


def test_a_player_has_the_pictures_that_are_rendered(scene, tmp_path):
    sim, again = ws.Simulation(scene), ws.Simulation(scene)
    player = ws.show(sim, 0.05, width=96, height=64)
    drawn = [again.render(96, 64), *(again.render(96, 64) for _ in again.frames(3))]
    assert sim.steps == again.steps and player.fps == scene["time.frame_rate"] == 60
    page = Page(player.html())
    np.testing.assert_array_equal(page.pictures, drawn)
    assert page.named["at"]["max"] == "3" and "play" in page.named
    assert "4 pictures of 96 x 64, 60 a second" in repr(player)
    # The scene's duration is over.
    assert len(ws.show(sim, width=96, height=64).pictures) == 1
    # A notebook has the same page in a frame; a file has it too.
    frame = player._repr_html_()
    assert html.unescape(frame.split('srcdoc="')[1].split('"')[0]) == player.html()
    player.save(tmp_path / "film.html")
    assert (tmp_path / "film.html").read_text(encoding="utf-8") == player.html()
    np.testing.assert_array_equal(Page(ws.show(iter(drawn), fps=12).html()).pictures, drawn)


def test_a_folder_of_a_run_is_shown(sim, tmp_path):
    with ws.Writer(tmp_path / "run", sim, formats=["png"]) as writer:
        for _ in sim.frames(2):
            writer.append(sim)
    player = ws.show(tmp_path / "run")
    files = sorted((tmp_path / "run/frames").iterdir())
    assert player.pictures == [path.read_bytes() for path in files] and player.fps == 60
    assert ws.show(str(tmp_path / "run/frames"), fps=24).fps == 24


def test_what_is_no_film_is_named(sim, tmp_path):
    picture = np.zeros((4, 6, 4), np.uint8)
    for film, words, error, said in [
        (tmp_path, {}, ValueError, "windswept render"),
        ([], {}, ValueError, "expected pictures, found none"),
        ([picture, picture[:2]], {}, ValueError, r"found \(6, 4\) and \(6, 2\)"),
        ([picture[0]], {}, ValueError, r"expected shape \(height, width, 4\)"),
        ([sim.frame()], {}, ValueError, "picture: expected"),
        (3, {}, TypeError, "found int"),
        ([picture], {"fps": 0}, ValueError, "fps: expected"),
        ([picture], {"duration": 1.0, "width": 3}, TypeError, "duration, width: for a simulation only"),
        (sim, {"duration": -1.0}, ValueError, "duration: expected"),
        (sim, {"duration": 0.0, "camera": "none"}, ValueError, "camera"),
    ]:
        with pytest.raises(error, match=said):
            ws.show(film, **words)
