"""The tables of a scene and their keys, made by `cargo xtask stubs` from the keys that the engine declares."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Literal

from windswept._table import Key, SceneTable, Table, key

if TYPE_CHECKING:
    from numpy import float64
    from numpy.typing import ArrayLike, NDArray

__all__ = [
    "Air",
    "Band",
    "Body",
    "Bounds",
    "Camera",
    "Cap",
    "Capsule",
    "Change",
    "Clump",
    "Cuboid",
    "Curl",
    "DirectFilter",
    "Disc",
    "Fluid",
    "Force",
    "GridFilter",
    "Gust",
    "Hair",
    "Inflow",
    "Interaction",
    "Keyframe",
    "Line",
    "MeshFile",
    "Picture",
    "Pin",
    "Plane",
    "Ring",
    "Rods",
    "Scalp",
    "Scene",
    "Sphere",
    "Strength",
    "Time",
    "Turbulence",
    "Viscosity",
]


class Time(Table):
    """Step, duration, frames: `[time]`."""

    _path = "time"

    step: Key[float, float] = key()
    """Step Δt as written; the engine runs substeps whole steps of step / substeps. A number greater than 0 [s]. Needed.
    """
    substeps: Key[int, int] = key(default=1)
    """Whole steps of Δt/n per Δt; the engine takes more where strands of very short segments need them. A whole number
    of at least 1, at most 10000. Default 1.
    """
    duration: Key[float, float] = key()
    """Length of the run. A number greater than 0 [s]. Needed."""
    settle: Key[float, float] = key(default=0.0)
    """Time before the run in which hair comes to rest in still air, with roots and bodies as they are at the start. The
    run begins with hair at rest there. A number of at least 0 [s]. Default 0.0.
    """
    frame_rate: Key[float, float] = key(default=60.0)
    """Exported frames per second. A number greater than 0 [1/s]. Default 60.0."""


class Curl(Table):
    """Helical rest shape, right-handed about the strand's axis: `[hair.curl]`."""

    _path = "hair.curl"

    radius: Key[float, float] = key()
    """Radius of the helix. A length in metres greater than 0. Needed."""
    pitch: Key[float, float] = key()
    """Advance along the axis per turn. A length in metres greater than 0. Needed."""


class Disc(Table):
    """A flat disc. `hair.roots.shape = "disc"`."""

    _path = "hair.roots"
    _word = ("shape", "disc")

    center: Key[NDArray[float64], ArrayLike] = key(kind="vector")
    """Centre of the shape. Three numbers, [x, y, z] [m]. Needed."""
    radius: Key[float, float] = key()
    """Radius of the disc or cap; half length of the line. A length in metres greater than 0. Needed."""
    direction: Key[NDArray[float64], ArrayLike] = key(default=[0.0, -1.0, 0.0], kind="vector")
    """Direction in which strands start, a unit vector; a cap faces it. Three numbers, [x, y, z], not all 0. Default
    [0.0, -1.0, 0.0].
    """
    normal: Key[NDArray[float64] | None, ArrayLike | None] = key(default=None, kind="vector")
    """Normal of the disc or of the line, a unit vector: strands lean where it is not the direction. Three numbers, [x,
    y, z], not all 0. Without it: direction.
    """


class Cap(Table):
    """The half sphere that faces a direction; strands start along its normals. `hair.roots.shape = "sphere_cap"`."""

    _path = "hair.roots"
    _word = ("shape", "sphere_cap")

    center: Key[NDArray[float64], ArrayLike] = key(kind="vector")
    """Centre of the shape. Three numbers, [x, y, z] [m]. Needed."""
    radius: Key[float, float] = key()
    """Radius of the disc or cap; half length of the line. A length in metres greater than 0. Needed."""
    direction: Key[NDArray[float64], ArrayLike] = key(default=[0.0, -1.0, 0.0], kind="vector")
    """Direction in which strands start, a unit vector; a cap faces it. Three numbers, [x, y, z], not all 0. Default
    [0.0, -1.0, 0.0].
    """


class Line(Table):
    """A line of half length `radius`, horizontal where it can be. `hair.roots.shape = "line"`."""

    _path = "hair.roots"
    _word = ("shape", "line")

    center: Key[NDArray[float64], ArrayLike] = key(kind="vector")
    """Centre of the shape. Three numbers, [x, y, z] [m]. Needed."""
    radius: Key[float, float] = key()
    """Radius of the disc or cap; half length of the line. A length in metres greater than 0. Needed."""
    direction: Key[NDArray[float64], ArrayLike] = key(default=[0.0, -1.0, 0.0], kind="vector")
    """Direction in which strands start, a unit vector; a cap faces it. Three numbers, [x, y, z], not all 0. Default
    [0.0, -1.0, 0.0].
    """
    normal: Key[NDArray[float64] | None, ArrayLike | None] = key(default=None, kind="vector")
    """Normal of the disc or of the line, a unit vector: strands lean where it is not the direction. Three numbers, [x,
    y, z], not all 0. Without it: direction.
    """


class Scalp(Table):
    """Triangles of a body. `hair.roots.shape = "mesh"`."""

    _path = "hair.roots"
    _word = ("shape", "mesh")

    body: Key[str, str] = key()
    """Name of the body with shape mesh that roots are on. A string. Needed."""
    group: Key[str | None, str | None] = key(default=None)
    """Name of the group, object or material of the body's file that roots are on. A string. Without it: all triangles
    of the body.
    """


class Clump(Table):
    """Locks that the hairs gather to which follow the strands, in pictures and films: `[hair.clump]`."""

    _path = "hair.clump"

    size: Key[float, float] = key()
    """Distance from each centre's root to the next. A length in metres greater than 0. Needed."""
    strength: Key[float, float] = key(default=0.8)
    """Part of the way to its centre that a hair's tip is drawn; its root stays, and between them the part grows with
    the length. A number above 0, at most 1. Default 0.8.
    """
    noise: Key[float, float] = key(default=0.0)
    """Part of the strength that hairs go without at most, drawn at random. A number from 0 to below 1. Default 0.0."""


class Keyframe(Table):
    """Keyframes of the roots, about the centre of their shape, or about the origin of a groom file; not with a body:
    `[hair.motion]`. Keyframes of the body, about its centre, or about the origin of its mesh file: `[body.motion]`.
    """

    _path = "body.motion"

    time: Key[float, float] = key()
    """Time of the keyframe; each is later than the one before. A number of at least 0 [s]. Needed."""
    translation: Key[NDArray[float64], ArrayLike] = key(default=[0.0, 0.0, 0.0], kind="vector")
    """Translation T from the position that the scene gives; tips of strands that are held stay. Three numbers, [x, y,
    z] [m]. Default [0.0, 0.0, 0.0].
    """
    rotation: Key[NDArray[float64], ArrayLike] = key(default=[0.0, 0.0, 0.0], kind="vector")
    """Rotation vector of R, axis times angle, about the thing's centre. Three numbers, [x, y, z] [rad]. Default [0.0,
    0.0, 0.0].
    """


class Ring(Table):
    """Hair tie that gathers the strands while hair settles (time.settle): `[hair.pin.ring]`."""

    _path = "hair.pin.ring"

    center: Key[NDArray[float64], ArrayLike] = key(kind="vector")
    """Centre of the ring, where the body is written. Three numbers, [x, y, z] [m]. Needed."""
    radius: Key[float, float] = key()
    """Radius of the bundle of strands. A length in metres greater than 0. Needed."""
    normal: Key[NDArray[float64] | None, ArrayLike | None] = key(default=None, kind="vector")
    """Normal of the ring, a unit vector. Three numbers, [x, y, z], not all 0. Without it: away from the mean of the
    roots.
    """


class Pin(Table):
    """Places along the strands that are held: at a body, or by a hair tie: `[hair.pin]`."""

    _path = "hair.pin"

    at: Key[float | None, float | None] = key(default=None)
    """Length of the strand from its root to the pin; the nearest point of the strand is held. A number greater than 0
    [m]. Without it: that to the ring around the body.
    """
    fraction: Key[float | None, float | None] = key(default=None)
    """Part of the strand's length from its root to the pin, in place of at. A number from 0 to below 1. Without it: at
    says it.
    """
    body: Key[str | None, str | None] = key(default=None)
    """Name of the body that the pin goes with. A string. Without it: that of the hair, else none: it rests."""
    ring: Key[Ring | None, Ring | None] = key(default=None, of=Ring, kind="table")
    """Hair tie that gathers the strands while hair settles (time.settle). Without it: strands are held where they
    start.
    """


class Hair(Table):
    """Groups of strands; several as [[hair]], each with a name: `[hair]`."""

    _path = "hair"

    name: Key[str, str] = key(default="hair")
    """Name of the group, for dotted keys and reports. A string. Default "hair"."""
    strands: Key[int | None, int | None] = key(default=None)
    """Number of strands. A whole number of at least 1, at most 16777216. Needed with strands that are drawn."""
    points: Key[int | None, int | None] = key(default=None)
    """Points per strand, root included. A whole number of at least 2, at most 16384. Needed with strands that are
    drawn.
    """
    length: Key[float | None, float | None] = key(default=None)
    """Length of a strand along its curl. A length in metres greater than 0. Needed with strands that are drawn."""
    length_variation: Key[float, float] = key(default=0.0)
    """Fraction by which strands are shorter at most, drawn at random. A number from 0 to below 1. Default 0.0."""
    curl: Key[Curl | None, Curl | None] = key(default=None, of=Curl, kind="table")
    """Helical rest shape, right-handed about the strand's axis. Without it: straight."""
    curl_phase: Key[float, float] = key(default=1.0)
    """Spread of the helices' phases over the strands, 0 to 1. A number of at least 0 [turns]. Default 1.0."""
    roots: Key[Disc | Cap | Line | Scalp | None, Disc | Cap | Line | Scalp | None] = key(default=None, of=(Disc, Cap, Line, Scalp), kind="table")
    """Shape that the strands are rooted on. Needed with strands that are drawn."""
    file: Key[str | None, str | None] = key(default=None)
    """Groom file that the strands come from (.hair, .data, .bin, .npz, .npy, .ply). A path relative to the scene's
    folder. Needed with a groom file.
    """
    scale: Key[float | None, float | None] = key(default=None)
    """Metres per unit of the file: 0.01 for centimetres. A number greater than 0 [m]. Needed with a groom file that
    does not say its unit.
    """
    up: Key[Literal["y", "z", "x", "yzx", "zxy", "xzy", "yxz", "zyx"], Literal["y", "z", "x", "yzx", "zxy", "xzy", "yxz", "zyx"]] = key(default="y")
    """Axis of the file that points up, or the axes of the file that become x, y and z; xzy, yxz and zyx mirror. One of
    "y", "z", "x", "yzx", "zxy", "xzy", "yxz", "zyx". Default "y".
    """
    rest: Key[Literal["weightless", "hanging"], Literal["weightless", "hanging"]] = key(default="hanging")
    """Whether the shape in the file is the one at rest, from which weight bends the strands, or the one that they hang
    in, with their roots clamped. One of "weightless", "hanging". Default "hanging".
    """
    file_radius: Key[bool, bool] = key(default=True)
    """Whether strands take their radius from the file, where it has one that is a hair's, 15 to 150 µm on average. True
    or false. Default True.
    """
    file_guides: Key[bool, bool] = key(default=True)
    """Whether the strands that the file marks as guides are those that are simulated; false: as if it marked none. True
    or false. Default True.
    """
    points_per_strand: Key[int | None, int | None] = key(default=None)
    """Points of each strand of a file that does not say where one ends: a .ply without strands, an array (points, 3). A
    whole number of at least 1, at most 16384. Without it: the file must say.
    """
    radius: Key[float, float] = key(default=4e-05)
    """Radius of a fibre at its root; the semi-major axis, along d2, where the cross-section is an ellipse. A length in
    metres greater than 0. Default 4e-05.
    """
    taper: Key[float, float] = key(default=0.0)
    """Fraction by which the tip's radius is less than the root's. A number from 0 to below 1. Default 0.0."""
    aspect: Key[float, float] = key(default=1.0)
    """Semi-minor axis, along d1, over semi-major axis of the cross-section; a curl turns about d2 and so bends the flat
    way. A number above 0, at most 1. Default 1.0.
    """
    density: Key[float, float] = key(default=1320.0)
    """Density of a fibre. A number greater than 0 [kg/m³]. Default 1320.0."""
    fibres_per_strand: Key[float, float] = key(default=1.0)
    """Fibres that a strand stands for; they scale its mass, stiffness and drag area. A number greater than 0. Default
    1.0.
    """
    youngs_modulus: Key[float, float] = key(default=4000000000.0)
    """Young's modulus E of a fibre; not with the three stiffnesses. A number greater than 0 [Pa]. Default 4000000000.0.
    """
    poissons_ratio: Key[float, float] = key(default=0.38)
    """Poisson's ratio ν: G = E/(2 (1 + ν)), GA = EA/(2 (1 + ν)). A number above -1, at most 0.5. Default 0.38."""
    stretch_stiffness: Key[float | None, float | None] = key(default=None)
    """Stretch stiffness EA of the strand; the three stiffnesses go together. A number greater than 0 [N]. Needed with
    the three stiffnesses.
    """
    bend_stiffness: Key[float | None, float | None] = key(default=None)
    """Bend stiffness EI of the strand. A number greater than 0 [N m²]. Needed with the three stiffnesses."""
    twist_stiffness: Key[float | None, float | None] = key(default=None)
    """Twist stiffness GJ of the strand. A number greater than 0 [N m²]. Needed with the three stiffnesses."""
    point_mass: Key[float | None, float | None] = key(default=None)
    """Mass of every point; the paper's is 1.46e-7. A number greater than 0 [kg]. Without it: half of each adjoining
    segment's mass.
    """
    stiffness: Key[list[list[float]] | None, ArrayLike | None] = key(default=None, kind="pairs")
    """Factor of the stiffness to bend and twist along the strands, linear between its pairs: stiffer roots are [[0, 4],
    [0.3, 1]]. Pairs [part of the length, factor] with parts from 0 to 1 that rise and factors above 0. Without it: 1
    from root to tip.
    """
    clump: Key[Clump | None, Clump | None] = key(default=None, of=Clump, kind="table")
    """Locks that the hairs gather to which follow the strands, in pictures and films. Without it: they do not gather.
    """
    friction: Key[float, float] = key(default=0.3)
    """Coulomb's coefficient of friction of the strands on other strands, of a pair the smaller one; two-way only. A
    number of at least 0. Default 0.3.
    """
    root: Key[Literal["clamped", "pinned", "free"], Literal["clamped", "pinned", "free"]] = key(default="clamped")
    """Hold of the roots: in place and direction, in place, not at all. One of "clamped", "pinned", "free". Default
    "clamped".
    """
    tip: Key[Literal["clamped", "pinned", "free"], Literal["clamped", "pinned", "free"]] = key(default="free")
    """Hold of the tips, as of the roots; clamped with rods.solver = "direct" only. One of "clamped", "pinned", "free".
    Default "free".
    """
    seed: Key[int | None, int | None] = key(default=None)
    """Seed that draws the group's root positions, length variation and curl phase, or the strands of its file that are
    simulated. A whole number of at least 0, at most 4294967295. Without it: from seed, another one for each group.
    """
    body: Key[str | None, str | None] = key(default=None)
    """Name of the body whose motion the roots take part in. A string. Without it: that of roots.body, else none."""
    motion: Key[list[Keyframe], Keyframe | Sequence[Keyframe]] = key(factory=list, of=Keyframe, kind="tables")
    """Keyframes of the roots, about the centre of their shape, or about the origin of a groom file; not with a body.
    Without it: roots rest, or move as their body.
    """
    pin: Key[list[Pin], Pin | Sequence[Pin]] = key(factory=list, of=Pin, kind="tables")
    """Places along the strands that are held: at a body, or by a hair tie. Without it: no pins."""


class Sphere(Table):
    """All points within `radius` of a point. `body.shape = "sphere"`."""

    _path = "body"
    _word = ("shape", "sphere")

    center: Key[NDArray[float64], ArrayLike] = key(kind="vector")
    """Centre of the sphere or of the box. Three numbers, [x, y, z] [m]. Needed."""
    radius: Key[float, float] = key()
    """Radius of the sphere, or about the capsule's axis. A length in metres greater than 0. Needed."""


class Capsule(Table):
    """All points within `radius` of a line. `body.shape = "capsule"`."""

    _path = "body"
    _word = ("shape", "capsule")

    radius: Key[float, float] = key()
    """Radius of the sphere, or about the capsule's axis. A length in metres greater than 0. Needed."""
    start: Key[NDArray[float64], ArrayLike] = key(kind="vector")
    """Start of the capsule's axis. Three numbers, [x, y, z] [m]. Needed."""
    end: Key[NDArray[float64], ArrayLike] = key(kind="vector")
    """End of the capsule's axis. Three numbers, [x, y, z] [m]. Needed."""


class Cuboid(Table):
    """All points of a box with sharp edges. `body.shape = "box"`."""

    _path = "body"
    _word = ("shape", "box")

    center: Key[NDArray[float64], ArrayLike] = key(kind="vector")
    """Centre of the sphere or of the box. Three numbers, [x, y, z] [m]. Needed."""
    size: Key[NDArray[float64], ArrayLike] = key(kind="vector")
    """Sides of the box along its own axes. Three numbers, [x, y, z] [m]. Needed."""
    rotation: Key[NDArray[float64], ArrayLike] = key(default=[0.0, 0.0, 0.0], kind="vector")
    """Rotation vector of the box about its centre, axis times angle. Three numbers, [x, y, z] [rad]. Default [0.0, 0.0,
    0.0].
    """


class Plane(Table):
    """All points behind a plane. `body.shape = "plane"`."""

    _path = "body"
    _word = ("shape", "plane")

    point: Key[NDArray[float64], ArrayLike] = key(kind="vector")
    """A point of the plane, about which it turns, and about which a square of 2 m of it is drawn. Three numbers, [x, y,
    z] [m]. Needed.
    """
    normal: Key[NDArray[float64], ArrayLike] = key(kind="vector")
    """Normal of the plane, away from the body. Three numbers, [x, y, z], not all 0. Needed."""


class MeshFile(Table):
    """All points that the triangles of a file enclose. `body.shape = "mesh"`."""

    _path = "body"
    _word = ("shape", "mesh")

    file: Key[str | None, str | None] = key(default=None)
    """Mesh file whose triangles enclose the body (.obj, .ply, .glb). A path relative to the scene's folder. Needed
    without frames.
    """
    frames: Key[str | None, str | None] = key(default=None)
    """File of a mesh that deforms, in place of a mesh file (.npz): positions (T, n, 3), triangles (m, 3) and times (T)
    in s. It moves by these poses, and has no keyframes. A path relative to the scene's folder. Without it: none: the
    mesh keeps its shape.
    """
    scale: Key[float | None, float | None] = key(default=None)
    """Metres per unit of the file: 0.01 for centimetres. A number greater than 0 [m]. Needed with shape mesh, unless
    the file says its unit.
    """
    up: Key[Literal["y", "z", "x", "yzx", "zxy", "xzy", "yxz", "zyx"], Literal["y", "z", "x", "yzx", "zxy", "xzy", "yxz", "zyx"]] = key(default="y")
    """Axis of the file that points up, or the axes of the file that become x, y and z; xzy, yxz and zyx mirror. One of
    "y", "z", "x", "yzx", "zxy", "xzy", "yxz", "zyx". Default "y".
    """
    resolution: Key[float | None, float | None] = key(default=None)
    """Spacing of the grid of distances from the mesh. A length in metres greater than 0. Without it: 0.002; less for a
    small mesh: 128 cells along its longest side; more for one whose grid would be too large.
    """


class Body(Table):
    """Bodies that hair and air stay out of; several as [[body]], each with a name: `[body]`."""

    _path = "body"

    name: Key[str, str] = key(default="body")
    """Name of the body, for dotted keys and errors. A string. Default "body"."""
    shape: Key[Literal["sphere", "capsule", "box", "plane", "mesh"], Literal["sphere", "capsule", "box", "plane", "mesh"] | Sphere | Capsule | Cuboid | Plane | MeshFile] = key(default="sphere", of=(Sphere, Capsule, Cuboid, Plane, MeshFile), kind="word")
    """Shape of the body: with center and radius, with start, end and radius, with center and size, with point and
    normal, or with file. One of "sphere", "capsule", "box", "plane", "mesh". Default "sphere".
    """
    center: Key[NDArray[float64] | None, ArrayLike | None] = key(default=None, kind="vector")
    """Centre of the sphere or of the box. Three numbers, [x, y, z] [m]. Needed with shape sphere."""
    radius: Key[float | None, float | None] = key(default=None)
    """Radius of the sphere, or about the capsule's axis. A length in metres greater than 0. Needed with shape sphere.
    """
    start: Key[NDArray[float64] | None, ArrayLike | None] = key(default=None, kind="vector")
    """Start of the capsule's axis. Three numbers, [x, y, z] [m]. Needed with shape capsule."""
    end: Key[NDArray[float64] | None, ArrayLike | None] = key(default=None, kind="vector")
    """End of the capsule's axis. Three numbers, [x, y, z] [m]. Needed with shape capsule."""
    size: Key[NDArray[float64] | None, ArrayLike | None] = key(default=None, kind="vector")
    """Sides of the box along its own axes. Three numbers, [x, y, z] [m]. Needed with shape box."""
    rotation: Key[NDArray[float64], ArrayLike] = key(default=[0.0, 0.0, 0.0], kind="vector")
    """Rotation vector of the box about its centre, axis times angle. Three numbers, [x, y, z] [rad]. Default [0.0, 0.0,
    0.0].
    """
    point: Key[NDArray[float64] | None, ArrayLike | None] = key(default=None, kind="vector")
    """A point of the plane, about which it turns, and about which a square of 2 m of it is drawn. Three numbers, [x, y,
    z] [m]. Needed with shape plane.
    """
    normal: Key[NDArray[float64] | None, ArrayLike | None] = key(default=None, kind="vector")
    """Normal of the plane, away from the body. Three numbers, [x, y, z], not all 0. Needed with shape plane."""
    file: Key[str | None, str | None] = key(default=None)
    """Mesh file whose triangles enclose the body (.obj, .ply, .glb). A path relative to the scene's folder. Needed
    without frames.
    """
    frames: Key[str | None, str | None] = key(default=None)
    """File of a mesh that deforms, in place of a mesh file (.npz): positions (T, n, 3), triangles (m, 3) and times (T)
    in s. It moves by these poses, and has no keyframes. A path relative to the scene's folder. Without it: none: the
    mesh keeps its shape.
    """
    scale: Key[float | None, float | None] = key(default=None)
    """Metres per unit of the file: 0.01 for centimetres. A number greater than 0 [m]. Needed with shape mesh, unless
    the file says its unit.
    """
    up: Key[Literal["y", "z", "x", "yzx", "zxy", "xzy", "yxz", "zyx"], Literal["y", "z", "x", "yzx", "zxy", "xzy", "yxz", "zyx"]] = key(default="y")
    """Axis of the file that points up, or the axes of the file that become x, y and z; xzy, yxz and zyx mirror. One of
    "y", "z", "x", "yzx", "zxy", "xzy", "yxz", "zyx". Default "y".
    """
    resolution: Key[float | None, float | None] = key(default=None)
    """Spacing of the grid of distances from the mesh. A length in metres greater than 0. Without it: 0.002; less for a
    small mesh: 128 cells along its longest side; more for one whose grid would be too large.
    """
    friction: Key[float, float] = key(default=0.3)
    """Coulomb's coefficient of friction of hair on the body. A number of at least 0. Default 0.3."""
    motion: Key[list[Keyframe], Keyframe | Sequence[Keyframe]] = key(factory=list, of=Keyframe, kind="tables")
    """Keyframes of the body, about its centre, or about the origin of its mesh file. Without it: it rests."""


class Strength(Table):
    """Keyframes of the strength, in place of a steady one: linear between them, held before and after:
    `[force.keyframes]`.
    """

    _path = "force.keyframes"

    time: Key[float, float] = key()
    """Time of the keyframe; each is later than the one before. A number of at least 0 [s]. Needed."""
    strength: Key[float, float] = key()
    """Strength at that time. A number [m/s]. Needed."""


class Force(Table):
    """Force fields: winds of their own; several as [[force]], each with a name: `[force]`."""

    _path = "force"

    name: Key[str, str] = key(default="force")
    """Name of the field, for dotted keys and errors. A string. Default "force"."""
    field: Key[Literal["jet", "vortex", "point"], Literal["jet", "vortex", "point"]] = key()
    """Shape of the field's wind: along the axis, about it, or away from the origin. One of "jet", "vortex", "point".
    Needed.
    """
    origin: Key[NDArray[float64], ArrayLike] = key(kind="vector")
    """Point where a jet begins, through which a vortex's axis goes, or from which a point blows. Three numbers, [x, y,
    z] [m]. Needed.
    """
    axis: Key[NDArray[float64] | None, ArrayLike | None] = key(default=None, kind="vector")
    """Direction of a jet, or axis that a vortex turns about, right-handed. Three numbers, [x, y, z], not all 0. Needed
    with fields jet and vortex.
    """
    reach: Key[float, float] = key()
    """Distance at which the field ends: along a jet, from a vortex's axis, from a point; from half of it on it fades. A
    length in metres greater than 0. Needed.
    """
    radius: Key[float | None, float | None] = key(default=None)
    """Radius of a jet, which fades from half of it on; or distance at which a vortex or a point blows with its
    strength: inside it is slower in proportion to the distance. At most half of reach with a vortex or a point. A
    length in metres greater than 0. Without it: a quarter of reach.
    """
    uptake: Key[float | None, float | None] = key(default=None)
    """Way over which air takes the field's wind up, at the strength's speed. A length in metres greater than 0. Without
    it: radius.
    """
    strength: Key[float | None, float | None] = key(default=None)
    """Largest speed of the field's wind; negative turns it round. A number [m/s]. Needed without keyframes."""
    keyframes: Key[list[Strength], Strength | Sequence[Strength]] = key(factory=list, of=Strength, kind="tables")
    """Keyframes of the strength, in place of a steady one: linear between them, held before and after. Without it: a
    steady strength.
    """


class Bounds(Table):
    """Periodic box of the air particles; none with models drag and none: `[air.box]`."""

    _path = "air.box"

    min: Key[NDArray[float64], ArrayLike] = key(kind="vector")
    """Lower corner. Three numbers, [x, y, z] [m]. Needed."""
    max: Key[NDArray[float64], ArrayLike] = key(kind="vector")
    """Upper corner. Three numbers, [x, y, z] [m]. Needed."""


class Gust(Table):
    """Keyframes of what is added to the wind: linear between them, held before and after: `[air.gust]`."""

    _path = "air.gust"

    time: Key[float, float] = key()
    """Time of the keyframe; each is later than the one before. A number of at least 0 [s]. Needed."""
    velocity: Key[NDArray[float64], ArrayLike] = key(kind="vector")
    """Velocity that is added to air.wind. Three numbers, [x, y, z] [m/s]. Needed."""


class Inflow(Table):
    """Turbulence that enters with the wind: `[air.inflow]`."""

    _path = "air.inflow"

    intensity: Key[float, float] = key()
    """How wild eddies are: the rms speed of their band over the wind's. A number of at least 0. Needed."""
    scale: Key[float, float] = key()
    """How large eddies are: s of their band (eq. 6). A length in metres greater than 0. Needed."""


class Air(Table):
    """Wind and air particles: `[air]`."""

    _path = "air"

    box: Key[Bounds | None, Bounds | ArrayLike | None] = key(default=None, of=Bounds, kind="table")
    """Periodic box of the air particles; none with models drag and none. Three numbers are a box of this size whose
    lower corner is the origin. Needed with models particles and two-way.
    """
    margin: Key[float | None, float | None] = key(default=None)
    """Distance about the hair's reach that the box is cut to at load, and the fringe's thickness more where wind
    enters. A number of at least 0 [m]. Without it: the whole box.
    """
    rest_density: Key[float, float] = key(default=1.29)
    """Rest density ρ0. A number greater than 0 [kg/m³]. Default 1.29."""
    spacing: Key[float, float] = key(default=0.004837129507268935)
    """Spacing d of the air particles, by which the air is fine or coarse: a box has its volume over d³ of them. It is
    rounded along each side of the box. The paper's particles of 1.46e-7 kg are 4.837 mm apart. A length in metres
    greater than 0. Default 0.004837129507268935.
    """
    kernel_radius: Key[float | None, float | None] = key(default=None)
    """Kernel radius h. A length in metres greater than 0. Without it: 1.923 spacings."""
    wind: Key[NDArray[float64] | None, ArrayLike | None] = key(default=None, kind="vector")
    """Mean wind U. Three numbers, [x, y, z] [m/s]. Needed with every model but none."""
    fringe: Key[float | None, float | None] = key(default=None)
    """Thickness of the fringe, in which entering air is conditioned; 0: none. A number of at least 0 [m]. Without it: 4
    kernel radii.
    """
    ramp: Key[float, float] = key(default=0.05)
    """Time over which the wind rises; 0: at once. A number of at least 0 [s]. Default 0.05."""
    kinematic_viscosity: Key[float, float] = key(default=1.5e-05)
    """Kinematic viscosity ν of the drag on segments: that of real air. A number greater than 0 [m²/s]. Default 1.5e-05.
    """
    skin_friction: Key[float, float] = key(default=0.1)
    """Skin friction coefficient C_f of air along bodies: a stress of ½ C_f ρ v² on the layer of one particle spacing. A
    number of at least 0. Default 0.1.
    """
    gust: Key[list[Gust], Gust | Sequence[Gust]] = key(factory=list, of=Gust, kind="tables")
    """Keyframes of what is added to the wind: linear between them, held before and after. Without it: no gusts."""
    jitter: Key[float | None, float | None] = key(default=None)
    """Largest offset of a particle from its site of the lattice at the start, along each axis, in particle spacings. A
    number from 0 to below 1. Without it: 0.05 with fluid.solver divergence, 0 with pbf.
    """
    seed: Key[int | None, int | None] = key(default=None)
    """Seed that draws jitter and inflow. A whole number of at least 0, at most 4294967295. Without it: seed."""
    follows: Key[str | None, str | None] = key(default=None)
    """Name of a body whose translation the box goes with: what is not held feels it as a wind against the motion.
    Frames and files are in the world. A string. Without it: the box stands still.
    """
    inflow: Key[Inflow | None, Inflow | None] = key(default=None, of=Inflow, kind="table")
    """Turbulence that enters with the wind. Without it: that of turbulence.scale and intensity, unless
    turbulence.inflow = false.
    """


class Interaction(Table):
    """Interaction of hair and air: `[interaction]`."""

    _path = "interaction"

    model: Key[Literal["particles", "two-way", "drag", "none"] | None, Literal["particles", "two-way", "drag", "none"] | None] = key(default=None)
    """Model of the interaction: one fluid of particles; hair and air particles that exchange drag; lift and drag of the
    mean wind; hair alone. One of "particles", "two-way", "drag", "none". Without it: "two-way", "particles" with method
    published.
    """
    lift: Key[float, float] = key(default=0.0)
    """Lift coefficient C_l of a segment across the wind (models two-way and drag, and hair outside the box of model
    particles). A number of at least 0. Default 0.0.
    """


class Fluid(Table):
    """Density constraint (eq. 1): `[fluid]`."""

    _path = "fluid"

    solver: Key[Literal["divergence", "pbf"] | None, Literal["divergence", "pbf"] | None] = key(default=None)
    """Solver of the air: a constraint on how its velocity diverges, or one on its density by moves (position-based
    fluids). One of "divergence", "pbf". Without it: "divergence", "pbf" with method published.
    """
    pressure_iterations: Key[int | None, int | None] = key(default=None)
    """Iterations of the pressure of solver divergence. A whole number of at least 1, at most 4. Without it: 2, or 4
    with model particles.
    """
    coarse: Key[bool, bool] = key(default=True)
    """Whether solver divergence solves for the pressure on a coarse grid first; not with model particles. True or
    false. Default True.
    """
    iterations: Key[int, int] = key(default=2)
    """Jacobi iterations of the density constraint: of solver pbf, and of hair on hair with model two-way; 0 leaves it
    out. A whole number of at least 0, at most 10000. Default 2.
    """
    relaxation: Key[float, float] = key(default=0.5)
    """Fraction of a Jacobi step that the density constraint takes. A number greater than 0. Default 0.5."""


class GridFilter(Table):
    """Three Gaussian passes on a grid. `turbulence.filter = "grid"`."""

    _path = "turbulence"
    _word = ("filter", "grid")

    spacing: Key[float, float] = key(default=0.65)
    """Spacing of the grid filter's nodes in units of the scale, at most 1; never more than a kernel radius. A number
    greater than 0. Default 0.65.
    """


class DirectFilter(Table):
    """The sum of eq. 5. `turbulence.filter = "direct"`."""

    _path = "turbulence"
    _word = ("filter", "direct")

    cutoff: Key[float | None, float | None] = key(default=None)
    """Cutoff of the direct filter in units of the scale. A number greater than 0. Without it: 4.5, 3.0 with method
    published.
    """


class Band(Table):
    """Bands of eddies to strengthen, instead of scale; each has a scale and an intensity of its own, and none enters
    with the wind: `[turbulence.bands]`.
    """

    _path = "turbulence.bands"

    scale: Key[float, float] = key()
    """Scale of the eddies to strengthen: s of the Mexican hat. A length in metres greater than 0. Needed."""
    strength: Key[float, float] = key(default=6.0)
    """Strength S of the band law, by which eddies come to their intensity sooner; the published law has a strength of
    its own. 0 leaves the band out. A number of at least 0. Default 6.0.
    """
    intensity: Key[float, float] = key(default=0.6)
    """Intensity I: the rms speed of the band over turbulence.speed. The band law strengthens no faster eddies, and none
    that pass a kernel radius in a substep. A number greater than 0. Default 0.6.
    """


class Turbulence(Table):
    """Vorticity confinement (eqs. 2-6): `[turbulence]`."""

    _path = "turbulence"

    bands: Key[list[Band], Band | Sequence[Band]] = key(factory=list, of=Band, kind="tables")
    """Bands of eddies to strengthen, instead of scale; each has a scale and an intensity of its own, and none enters
    with the wind. Without it: the band of scale and intensity.
    """
    speed: Key[float | None, float | None] = key(default=None)
    """Speed U of the law. A number of at least 0 [m/s]. Without it: the largest wind, those of jets and vortices
    included.
    """
    law: Key[Literal["band", "published"] | None, Literal["band", "published"] | None] = key(default=None)
    """Confinement law. One of "band", "published". Without it: "band", "published" with method published."""
    filter: Key[Literal["grid", "direct"] | None, Literal["grid", "direct"] | GridFilter | DirectFilter | None] = key(default=None, of=(GridFilter, DirectFilter), kind="word")
    """Filter that finds the band velocity; law published takes direct only. One of "grid", "direct". Without it:
    "grid", "direct" with method published.
    """
    spacing: Key[float, float] = key(default=0.65)
    """Spacing of the grid filter's nodes in units of the scale, at most 1; never more than a kernel radius. A number
    greater than 0. Default 0.65.
    """
    cutoff: Key[float | None, float | None] = key(default=None)
    """Cutoff of the direct filter in units of the scale. A number greater than 0. Without it: 4.5, 3.0 with method
    published.
    """
    conserve_momentum: Key[bool | None, bool | None] = key(default=None)
    """Whether the mean change of the air is taken out, so that confinement drives no wind. True or false. Without it:
    true with law band, false with published.
    """
    scale: Key[float | None, float | None] = key(default=None)
    """How large eddies are: s of eq. 6. A whirl of the band measures about 2 s across. A length in metres greater than
    0. Without it: no turbulence, unless there are bands.
    """
    intensity: Key[float | None, float | None] = key(default=None)
    """How wild eddies are: the rms speed of their band over the wind's (turbulence.speed). A number greater than 0.
    Without it: 0.6 with scale.
    """
    inflow: Key[bool | None, bool | None] = key(default=None)
    """Whether eddies of scale and intensity also enter with the wind; otherwise hair and bodies alone make them. True
    or false. Without it: true with scale, but false with method published.
    """


class Viscosity(Table):
    """XSPH viscosity (eqs. 7, 8): `[viscosity]`."""

    _path = "viscosity"

    hair: Key[float, float] = key(default=1.4)
    """Coefficient c of hair, per step as written. With interaction.model two-way it acts between strands; with
    particles it also acts between the points of one strand. A number of at least 0. Default 1.4.
    """
    air: Key[float, float] = key(default=0.014)
    """Coefficient c of air, per step as written. A number of at least 0. Default 0.014."""
    smagorinsky: Key[float | None, float | None] = key(default=None)
    """Constant C of the viscosity of eddies smaller than the spacing d of air, ν = (C d)² |∇v| (Smagorinsky 1963), on
    top of air's; 0 leaves it out. 0.34 is the usual 0.17 of a filter of two spacings. For fluid.solver divergence; at
    most 1. A number of at least 0. Without it: 0, or 0.34 with model particles and solver divergence.
    """
    form: Key[Literal["limited", "published"] | None, Literal["limited", "published"] | None] = key(default=None)
    """Form of the exchange: with or without the symmetric limiter. One of "limited", "published". Without it:
    "limited", "published" with method published.
    """
    kinematic_hair: Key[float | None, float | None] = key(default=None)
    """Kinematic viscosity ν of hair instead of hair: c = 22 ν Δt/h². A number of at least 0 [m²/s]. Without it: from
    viscosity.hair.
    """
    kinematic_air: Key[float | None, float | None] = key(default=None)
    """Kinematic viscosity ν of air instead of air: c = 22 ν Δt/h². A number of at least 0 [m²/s]. Without it: from
    viscosity.air.
    """


class Rods(Table):
    """Cosserat rods: `[rods]`."""

    _path = "rods"

    solver: Key[Literal["direct", "gauss-seidel"] | None, Literal["direct", "gauss-seidel"] | None] = key(default=None)
    """Solver of the rods. One of "direct", "gauss-seidel". Without it: "direct", "gauss-seidel" with method published.
    """
    integrator: Key[Literal["bdf2", "euler"] | None, Literal["bdf2", "euler"] | None] = key(default=None)
    """Time integration of hair. One of "bdf2", "euler". Without it: "bdf2", "euler" with method published."""
    iterations: Key[int, int] = key(default=10)
    """Sweeps of Gauss-Seidel in a step; gauss-seidel only. A whole number of at least 1, at most 10000. Default 10."""
    newton: Key[int, int] = key(default=8)
    """Newton steps at most; direct only: a strand stops when frames turn by less than 1e-3 rad, or a hundredth of the
    first turn. A whole number of at least 1, at most 100. Default 8.
    """
    damping: Key[float, float] = key(default=0.0)
    """Damping of absolute linear and angular velocity. A number of at least 0 [1/s]. Default 0.0."""
    sleep: Key[bool, bool] = key(default=True)
    """Whether strands at rest that nothing pushes are left alone (error below 1e-4 of their length). True or false.
    Default True.
    """


class Camera(Table):
    """Cameras; several as [[camera]], each with a name. A run's pictures are taken with the first: `[camera]`."""

    _path = "camera"

    name: Key[str, str] = key(default="camera")
    """Name of the camera, for dotted keys and to choose it by. A string. Default "camera"."""
    eye: Key[NDArray[float64] | None, ArrayLike | None] = key(default=None, kind="vector")
    """Place of the camera; eye and target go together. Three numbers, [x, y, z] [m]. Without it: frames the hair."""
    target: Key[NDArray[float64] | None, ArrayLike | None] = key(default=None, kind="vector")
    """Point that the camera looks at. Three numbers, [x, y, z] [m]. Without it: frames the hair."""
    fov: Key[float, float] = key(default=26.0)
    """Vertical field of view, below 180. A number greater than 0 [°]. Default 26.0."""
    width: Key[int, int] = key(default=960)
    """Width of a picture. A whole number of at least 16, at most 16384 [px]. Default 960."""
    height: Key[int, int] = key(default=540)
    """Height of a picture. A whole number of at least 16, at most 16384 [px]. Default 540."""


class Picture(Table):
    """Contents of pictures: `[picture]`."""

    _path = "picture"

    hairs: Key[int, int] = key(default=20000)
    """Hairs drawn in all, the strands and others that follow them; where a groom file has others, those first. A whole
    number of at least 1, at most 1000000. Default 20000.
    """
    air: Key[Literal["none", "vorticity", "band_energy"], Literal["none", "vorticity", "band_energy"]] = key(default="none")
    """Colour of the air particles, or none of them. One of "none", "vorticity", "band_energy". Default "none"."""


class Change(Table):
    """Values that change while the scene runs; several as [[change]]: `[change]`."""

    _path = "change"

    time: Key[float, float] = key()
    """Time from which the values hold, in the first step that begins then; no earlier than that of the change before. A
    number of at least 0 [s]. Needed.
    """
    over: Key[float, float] = key(default=0.0)
    """Time that numbers take from their values before to the new ones, evenly; 0: at once. A number of at least 0 [s].
    Default 0.0.
    """
    set: Key[Mapping[str, object], Mapping[str, object]] = key()
    """Keys and their new values: dotted keys in quotes, as those of --set. A table of keys in quotes and values, {
    "air.wind" = [3, 0, 0] }. Needed.
    """


class Scene(SceneTable):
    """A scene: what to simulate, in SI; `windswept.Simulation` runs it."""

    title: Key[str, str] = key(default="")
    """Free text, shown in reports. A string. Default ""."""
    method: Key[Literal["accurate", "published"], Literal["accurate", "published"]] = key(default="accurate")
    """Method, which sets the defaults of interaction.model, fluid.solver, rods.solver, rods.integrator, turbulence.law,
    .filter, .cutoff, viscosity.form. One of "accurate", "published". Default "accurate".
    """
    gravity: Key[NDArray[float64], ArrayLike] = key(default=[0.0, -9.81, 0.0], kind="vector")
    """Acceleration on hair; air has none. Three numbers, [x, y, z] [m/s²]. Default [0.0, -9.81, 0.0]."""
    seed: Key[int, int] = key(default=1)
    """Seed that draws root positions, length variation, curl phase, inflow turbulence. A whole number of at least 0, at
    most 4294967295. Default 1.
    """
    time: Key[Time, Time] = key(of=Time, kind="table")
    """Step, duration, frames. Needed."""
    hair: Key[list[Hair], Hair | Sequence[Hair]] = key(factory=list, of=Hair, kind="tables")
    """Groups of strands; several as [[hair]], each with a name. Without it: no hair but a groom that code gives; the
    command needs hair.
    """
    body: Key[list[Body], Body | Sequence[Body]] = key(factory=list, of=Body, kind="tables")
    """Bodies that hair and air stay out of; several as [[body]], each with a name. Without it: no bodies."""
    force: Key[list[Force], Force | Sequence[Force]] = key(factory=list, of=Force, kind="tables")
    """Force fields: winds of their own; several as [[force]], each with a name. Without it: no force fields."""
    air: Key[Air | None, Air | None] = key(default=None, of=Air, kind="table")
    """Wind and air particles. Without it: with model none only."""
    interaction: Key[Interaction, Interaction] = key(factory=Interaction, of=Interaction, kind="table")
    """Interaction of hair and air. Without it: its defaults."""
    fluid: Key[Fluid, Fluid] = key(factory=Fluid, of=Fluid, kind="table")
    """Density constraint (eq. 1). Without it: its defaults."""
    turbulence: Key[Turbulence, Turbulence] = key(factory=Turbulence, of=Turbulence, kind="table")
    """Vorticity confinement (eqs. 2-6). Without it: no confinement."""
    viscosity: Key[Viscosity, Viscosity] = key(factory=Viscosity, of=Viscosity, kind="table")
    """XSPH viscosity (eqs. 7, 8). Without it: its defaults."""
    rods: Key[Rods, Rods] = key(factory=Rods, of=Rods, kind="table")
    """Cosserat rods. Without it: its defaults."""
    camera: Key[list[Camera], Camera | Sequence[Camera]] = key(factory=list, of=Camera, kind="tables")
    """Cameras; several as [[camera]], each with a name. A run's pictures are taken with the first. Without it: one that
    frames the hair.
    """
    picture: Key[Picture, Picture] = key(factory=Picture, of=Picture, kind="table")
    """Contents of pictures. Without it: its defaults."""
    change: Key[list[Change], Change | Sequence[Change]] = key(factory=list, of=Change, kind="tables")
    """Values that change while the scene runs; several as [[change]]. Without it: no changes."""
