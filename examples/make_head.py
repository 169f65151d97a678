"""Makes examples/scenes/head.obj: a head in metres, its face toward +Z, with a neck that is open below.

    python examples/make_head.py [FILE]

The head is a stack of rings, half ellipses in front and half ellipses behind, with a nose and two ears pushed out of them. Its groups
are `scalp`, where hair grows, and `face`, which is all the rest. The origin is between the ears.
"""

import math
import sys
from pathlib import Path

# Of each ring: height, half width, depth in front of the origin and behind it [m].
RINGS = [
    (0.126, 0.014, 0.010, 0.020),
    (0.122, 0.033, 0.030, 0.042),
    (0.113, 0.050, 0.050, 0.062),
    (0.098, 0.064, 0.069, 0.081),
    (0.078, 0.073, 0.082, 0.095),
    (0.056, 0.078, 0.089, 0.103),
    (0.034, 0.079, 0.091, 0.106),
    (0.014, 0.077, 0.090, 0.104),
    (-0.004, 0.075, 0.088, 0.098),
    (-0.020, 0.073, 0.089, 0.089),
    (-0.036, 0.070, 0.089, 0.078),
    (-0.054, 0.066, 0.087, 0.068),
    (-0.072, 0.060, 0.084, 0.061),
    (-0.088, 0.052, 0.081, 0.057),
    (-0.102, 0.044, 0.074, 0.056),
    (-0.110, 0.044, 0.050, 0.056),
    (-0.120, 0.048, 0.030, 0.058),
    (-0.145, 0.050, 0.028, 0.062),
    (-0.175, 0.056, 0.030, 0.068),
]
CROWN = (0.0, 0.128, -0.006)
COLUMNS = 40


def bump(x: float) -> float:
    """1 at 0, 0 from 1 on, smooth."""
    return math.cos(0.5 * math.pi * min(abs(x), 1.0)) ** 2


def point(ring: int, column: int) -> tuple[float, float, float]:
    """A point of the surface [m]; column 0 is in the middle of the face."""
    height, width, front, back = RINGS[ring]
    turn = math.tau * column / COLUMNS
    x, z = width * math.sin(turn), (front if math.cos(turn) > 0 else back) * math.cos(turn)
    # The nose: widest and farthest out at its tip, with a bridge above.
    below = max(0.0, (-0.020 - height) / 0.016)
    above = max(0.0, (height + 0.020) / 0.052)
    z += 0.024 * bump(turn_to(turn, 0.0) / 0.28) * bump(max(below, above))
    # The ears: thin, and bent back.
    for side in (1.0, -1.0):
        part = bump(turn_to(turn, side * 1.68) / 0.16) * bump((height + 0.004) / 0.042)
        x += 0.020 * side * part
        z -= 0.010 * part
    return x, height, z


def turn_to(a: float, b: float) -> float:
    """The angle between two directions [rad]."""
    return abs((a - b + math.pi) % math.tau - math.pi)


def hairline(turn: float) -> float:
    """Height above which hair grows [m]: high over the face, behind the ears down to the nape."""
    across = turn_to(turn, 0.0)
    return 0.066 - 0.030 * bump((across - 1.1) / 0.5) - 0.150 * bump((across - math.pi) / 1.75)


def main() -> None:
    file = Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parent / "scenes" / "head.obj"
    lines = ["# A head, made by examples/make_head.py; in metres", "v {:.4f} {:.4f} {:.4f}".format(*CROWN)]
    lines += ["v {:.4f} {:.4f} {:.4f}".format(*point(r, c)) for r in range(len(RINGS)) for c in range(COLUMNS)]
    # Places in a texture: around, and from the crown down. The first column stands twice.
    lines += [f"vt {c / COLUMNS:.3f} {1 - (r + 1) / len(RINGS):.3f}" for r in range(len(RINGS)) for c in range(COLUMNS + 1)]
    lines += [f"vt {(c + 0.5) / COLUMNS:.4f} 1" for c in range(COLUMNS)]
    groups: dict[str, list[str]] = {"scalp": [], "face": []}

    def corner(r: int, c: int) -> str:
        return f"{2 + r * COLUMNS + c % COLUMNS}/{1 + r * (COLUMNS + 1) + c}"

    for c in range(COLUMNS):
        groups["scalp"].append(f"f 1/{1 + len(RINGS) * (COLUMNS + 1) + c} {corner(0, c)} {corner(0, c + 1)}")
        for r in range(len(RINGS) - 1):
            height = 0.5 * (RINGS[r][0] + RINGS[r + 1][0])
            group = "scalp" if height > hairline(math.tau * (c + 0.5) / COLUMNS) else "face"
            corners = corner(r, c), corner(r + 1, c), corner(r + 1, c + 1), corner(r, c + 1)
            groups[group].append("f " + " ".join(corners))
    for name, faces in groups.items():
        lines += [f"g {name}", *faces]
    file.write_text("\n".join(lines) + "\n")
    print(f"{file}: {sum(map(len, groups.values()))} faces, {len(groups['scalp'])} of them scalp")


if __name__ == "__main__":
    main()
