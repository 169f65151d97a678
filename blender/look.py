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
    # Strands that could not be simulated are not in the film.
    own = np.array(UsdGeom.PrimvarsAPI(curves).GetPrimvar("groom_id").Get())
    if "radius" in arrays:
        radius = np.split(arrays["radius"], arrays["offsets"][1:-1])
        counts = curves.GetCurveVertexCountsAttr().Get()
        # The scene may have placed points anew, evenly.
        along = [np.interp(np.linspace(0, 1, n), np.linspace(0, 1, len(radius[k])), radius[k]) for k, n in zip(own, counts)]
        curves.GetWidthsAttr().Set(2 / float(unit) * np.concatenate(along).astype(np.float32))
        stage.GetRootLayer().Save()
