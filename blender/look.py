"""Gives the curves of a film the radii of a groom: `python look.py FILM GROOM UNIT`, without Blender.

Simulated fibres are as thin as hair; what is drawn may be thicker. UNIT: metres per unit of the film.
"""

import sys

import numpy as np
from pxr import Usd, UsdGeom

film, groom, unit = sys.argv[1:]
stage = Usd.Stage.Open(film)
curves = next(UsdGeom.BasisCurves(prim) for prim in stage.Traverse() if prim.IsA(UsdGeom.BasisCurves))
with np.load(groom) as arrays:
    counts = np.diff(arrays["offsets"])
    own = np.array(UsdGeom.PrimvarsAPI(curves).GetPrimvar("groom_id").Get())
    # Strands that could not be simulated are not in the film; strands of another number of points were placed anew.
    if "radius" in arrays and np.array_equal(counts[own], curves.GetCurveVertexCountsAttr().Get()):
        radius = np.split(arrays["radius"], arrays["offsets"][1:-1])
        curves.GetWidthsAttr().Set(2 / float(unit) * np.concatenate([radius[k] for k in own]).astype(np.float32))
        stage.GetRootLayer().Save()
