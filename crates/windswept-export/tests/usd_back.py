"""Reads FOLDER/hair.usda with USD's own library and compares it with the plain dumps beside it.

Usage: usd_back.py FOLDER RATE VERSION ADAPTER SEED; prints the number of frames found, or that there is no such library.
"""

import pathlib
import sys

import numpy as np

if sys.version_info < (3, 11):
    print("no usd-core for this Python")
    sys.exit()
from pxr import Gf, Usd, UsdGeom

folder, rate, version, adapter, seed = sys.argv[1:]
folder, rate = pathlib.Path(folder), float(rate)
times = np.fromfile(folder / "times.f64")
frames = len(times)


def dump(name, dtype, *shape):
    return np.fromfile(folder / name, dtype).reshape(*shape)


def equal(found, expected, what):
    """Ends the program unless `found` has the shape and bits of `expected`."""
    found = np.ascontiguousarray(found, expected.dtype)
    if found.shape != expected.shape or found.tobytes() != expected.tobytes():
        sys.exit(f"{what}: found {found.shape}\n{found}\nexpected {expected.shape}\n{expected}")


stage = Usd.Stage.Open(str(folder / "hair.usda"))
film = stage.GetDefaultPrim()
curves = UsdGeom.BasisCurves(film.GetChild("Hair"))
found = (UsdGeom.GetStageUpAxis(stage), UsdGeom.GetStageMetersPerUnit(stage), stage.GetTimeCodesPerSecond(), stage.GetFramesPerSecond())
if found != ("Y", 1.0, rate, rate):
    sys.exit(f"metadata: found {found}")
found = (curves.GetTypeAttr().Get(), curves.GetBasisAttr().Get(), curves.GetWrapAttr().Get(), curves.GetWidthsInterpolation())
if found != ("cubic", "catmullRom", "pinned", "vertex"):
    sys.exit(f"curves: found {found}")
source = stage.GetRootLayer().customLayerData["windswept"]
if source != {"scene": (folder / "scene.toml").read_text("utf-8"), "version": version, "adapter": adapter, "seed": int(seed)}:
    sys.exit(f"provenance: found {source}")

equal(curves.GetCurveVertexCountsAttr().Get(), np.diff(dump("offsets.u32", np.uint32, -1)).astype(np.int32), "curveVertexCounts")
radius = dump("radius.f32", np.float32, -1)
equal(curves.GetWidthsAttr().Get(), 2 * radius, "widths")
of_curves = {
    "groom_id": dump("ids.u32", np.int32, -1),
    "groom_group_id": dump("groups.u32", np.int32, -1),
    "groom_root_uv": dump("root_uvs.f32", np.float32, -1, 2),
}
for name, expected in of_curves.items():
    primvar = UsdGeom.PrimvarsAPI(curves).GetPrimvar(name)
    if primvar.GetInterpolation() != "uniform":
        sys.exit(f"{name} is {primvar.GetInterpolation()}")
    equal(primvar.Get(), expected, name)

positions = dump("positions.f32", np.float32, frames, -1, 3)
velocities = dump("velocities.f32", np.float32, frames, -1, 3)
codes = np.round(times * rate, 9)
for attribute in (curves.GetPointsAttr(), curves.GetVelocitiesAttr(), curves.GetExtentAttr()):
    equal(np.array(attribute.GetTimeSamples()), codes, f"time samples of {attribute.GetName()}")
if (stage.GetStartTimeCode(), stage.GetEndTimeCode()) != (0.0, codes[-1]):
    sys.exit(f"the stage is from {stage.GetStartTimeCode()} to {stage.GetEndTimeCode()}, expected 0 to {codes[-1]}")
for k, code in enumerate(codes):
    equal(curves.GetPointsAttr().Get(code), positions[k], f"points of frame {k}")
    equal(curves.GetVelocitiesAttr().Get(code), velocities[k], f"velocities of frame {k}")
    extent = np.array([positions[k].min(axis=0) - radius.max(), positions[k].max(axis=0) + radius.max()])
    equal(curves.GetExtentAttr().Get(code), extent, f"extent of frame {k}")

# Bodies: closed, seen from outside, and their points at the radius about the ends of the axis that the frame has.
found = {prim.GetDisplayName(): UsdGeom.Mesh(prim) for prim in film.GetChildren() if prim.IsA(UsdGeom.Mesh)}
if set(found) != {"left arm", "2nd"}:
    sys.exit(f"bodies: found {found}")
ends = dump("ends.f64", np.float64, frames, 2, 2, 3)
for body, (mesh, radius) in enumerate([(found["left arm"], 0.03), (found["2nd"], 0.07)]):
    own = np.array(mesh.GetPointsAttr().Get(), np.float64)
    corners = np.array(mesh.GetFaceVertexIndicesAttr().Get()).reshape(-1, 3)
    edges = corners[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2)
    if len(np.unique(edges, axis=0)) != len(edges) or set(map(tuple, edges)) != {(b, a) for a, b in edges}:
        sys.exit(f"body {body} is not closed")
    length = np.linalg.norm(ends[0, body, 1] - ends[0, body, 0])
    exact = np.pi * radius**2 * (length + 4 / 3 * radius)
    volume = np.linalg.det(own[corners]).sum() / 6
    if not 0.98 * exact < volume < exact:
        sys.exit(f"body {body} has a volume of {volume}, expected {exact}")
    equal(np.array(mesh.GetExtentAttr().Get()), np.array([own.min(axis=0), own.max(axis=0)], np.float32), "extent of a body")
    for k, code in enumerate(codes):
        world = np.array(UsdGeom.XformCache(code).GetLocalToWorldTransform(mesh.GetPrim()))
        x = own @ world[:3, :3] + world[3, :3]
        start, end = ends[k, body]
        axis = (end - start) / max(length, 1e-30)
        along = np.clip((x - start) @ axis, 0, length)
        off = np.abs(np.linalg.norm(x - start - along[:, None] * axis, axis=1) - radius).max()
        if off > 1e-7 or np.linalg.norm(x.mean(axis=0) - (start + end) / 2) > 1e-7:
            sys.exit(f"body {body} is {off} m off its surface in frame {k}")

# The camera sees places of the world where the pictures have them.
(camera,) = [UsdGeom.Camera(prim) for prim in film.GetChildren() if prim.IsA(UsdGeom.Camera)]
if (camera.GetPrim().GetName(), camera.GetPrim().GetDisplayName()) != ("Hair_2", "Hair"):
    sys.exit(f"the camera is called {camera.GetPrim().GetName()}")
camera = camera.GetCamera(0.0)
seen = dump("seen.f64", np.float64, -1, 5)
clip = camera.frustum.ComputeViewMatrix() * camera.frustum.ComputeProjectionMatrix()
for *place, right, down in seen:
    x, y, _ = clip.Transform(Gf.Vec3d(*place))
    at = [(0.5 + 0.5 * x) * 640, (0.5 - 0.5 * y) * 400]
    if np.abs(np.subtract(at, [right, down])).max() > 1e-3:
        sys.exit(f"the camera sees {place} at {at}, expected {right, down}")
    distance = np.linalg.norm(np.subtract(place, camera.frustum.position))
    if not camera.clippingRange.min < distance < camera.clippingRange.max:
        sys.exit(f"{place} is cut off: {camera.clippingRange}")
print(frames, "frames")
