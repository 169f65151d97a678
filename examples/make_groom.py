"""Makes examples/scenes/curls.hair: loose curls on the scalp of examples/scenes/head.obj, in its place and unit.

    python examples/make_groom.py [FILE]

600 curls of 10 points leave the head along its normals and bend down, each with a phase of its own. The file is Cem Yuksel's `.hair`:
a head of 128 bytes, the number of segments of each curl, and all points, root to tip.
"""

import math
import random
import struct
import sys
from pathlib import Path

CURLS, POINTS = 600, 10
LENGTH = 0.15  # m, on a head of 0.26 m
TURNS, RADIUS = 1.0, 0.004  # turns of a curl along its length, and its radius [m]
SCENES = Path(__file__).parent / "scenes"

Vector = tuple[float, float, float]


def scalp(path: Path) -> list[list[Vector]]:
    """Corners of the triangles of the group `scalp` [m]."""
    places: list[Vector] = []
    triangles: list[list[Vector]] = []
    group = ""
    for line in path.read_text().splitlines():
        word, *rest = line.split() or [""]
        if word == "v":
            x, y, z = (float(x) for x in rest[:3])
            places.append((x, y, z))
        elif word == "g":
            group = rest[0]
        elif word == "f" and group == "scalp":
            corners = [places[int(corner.split("/")[0]) - 1] for corner in rest]
            triangles += [[corners[0], *corners[k : k + 2]] for k in range(1, len(corners) - 1)]
    return triangles


def cross(a: Vector, b: Vector) -> Vector:
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def minus(a: Vector, b: Vector) -> Vector:
    return (a[0] - b[0], a[1] - b[1], a[2] - b[2])


def normal(corners: list[Vector]) -> Vector:
    """Normal of a triangle, twice as long as its area is large."""
    a, b, c = corners
    return cross(minus(b, a), minus(c, a))


def unit(v: Vector) -> Vector:
    length = math.hypot(*v)
    return (v[0] / length, v[1] / length, v[2] / length)


def curl(corners: list[Vector], chance: random.Random) -> list[Vector]:
    """Points of a curl that is rooted somewhere on a triangle."""
    u, v = chance.random(), chance.random()
    if u + v > 1:
        u, v = 1 - u, 1 - v
    root = [a + u * (b - a) + v * (c - a) for a, b, c in zip(*corners)]
    out = unit(normal(corners))
    side = unit(cross(out, (0.3, 0.2, 1.0)))
    other = cross(out, side)
    phase, length = math.tau * chance.random(), LENGTH * (1 - 0.2 * chance.random())
    points = []
    for k in range(POINTS):
        t = k / (POINTS - 1)
        away, down = length * (t - 0.3 * t * t), 0.35 * length * t * t
        angle = phase + math.tau * TURNS * t
        across = [RADIUS * (math.cos(angle) - math.cos(phase)), RADIUS * (math.sin(angle) - math.sin(phase))]
        x = [r + away * n + across[0] * s + across[1] * o for r, n, s, o in zip(root, out, side, other)]
        points.append((x[0], x[1] - down, x[2]))
    return points


def main() -> None:
    path = Path(sys.argv[1]) if len(sys.argv) > 1 else SCENES / "curls.hair"
    triangles = scalp(SCENES / "head.obj")
    chance = random.Random(1)
    areas = [math.hypot(*normal(corners)) for corners in triangles]
    curls = [curl(corners, chance) for corners in chance.choices(triangles, weights=areas, k=CURLS)]
    # Which arrays there are (segments and points), then thickness, transparency and colour for a renderer, and what the
    # file is.
    head = struct.pack("<4s4I5f88s", b"HAIR", CURLS, CURLS * POINTS, 0b11, 0, 0.01, 0, 1, 1, 1, b"curls, by make_groom.py")
    segments = struct.pack(f"<{CURLS}H", *[POINTS - 1] * CURLS)
    points = struct.pack(f"<{3 * CURLS * POINTS}f", *(x for curl in curls for point in curl for x in point))
    path.write_bytes(head + segments + points)
    print(f"{path}: {CURLS} curls of {POINTS} points")


if __name__ == "__main__":
    main()
