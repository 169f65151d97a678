"""Opens FOLDER's pictures with Pillow and compares them with the plain dumps beside them.

Usage: look.py FOLDER WIDTH HEIGHT; picture.png and picture.rgb, preview.gif, whose last picture is last.rgb.
"""

import pathlib
import sys

import numpy as np
from PIL import Image

folder = pathlib.Path(sys.argv[1])
size = (int(sys.argv[2]), int(sys.argv[3]))


def dump(name):
    return np.fromfile(folder / name, np.uint8).reshape(size[1], size[0], 3)


with Image.open(folder / "picture.png") as png:
    png.load()
    if (png.format, png.mode, png.size) != ("PNG", "RGB", size) or not np.array_equal(np.asarray(png), dump("picture.rgb")):
        sys.exit(f"picture.png is {png.format} {png.mode} {png.size}, or not what was drawn")

with Image.open(folder / "preview.gif") as film:
    durations = []
    for k in range(film.n_frames):
        film.seek(k)
        durations.append(film.info["duration"])
    last = np.asarray(film.convert("RGB")).astype(int)
    expected = Image.fromarray(dump("last.rgb")).resize(film.size, Image.Resampling.BILINEAR)
    error = np.abs(last - np.asarray(expected).astype(int))
    print(film.format, *film.size, film.info["loop"], film.n_frames, sum(durations), min(durations), max(durations), f"{error.mean():.2f}")
