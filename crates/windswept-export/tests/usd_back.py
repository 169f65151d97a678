"""Reads FOLDER/hair.usda with USD's own library and compares it with the plain dumps beside it.

Usage: usd_back.py FOLDER RATE VERSION ADAPTER SEED; prints the number of frames found, or that there is no such library.
"""

import pathlib
import sys

import numpy as np

if sys.version_info < (3, 11):
    print("no usd-core for this Python")
    sys.exit()
from pxr import Usd, UsdGeom

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
curves = UsdGeom.BasisCurves(stage.GetDefaultPrim())
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
print(frames, "frames")
