"""Hair curves as a groom file."""

import numpy as np

from .axes import placed, read
from .error import Unfit

#: Value of the attribute `curve_type` of curves that do not go through their points.
NURBS = 3


def groom(hair, graph, unit):
    """The curves with their modifiers, as arrays of a groom file: points [m] in the world, Y up."""
    evaluated = hair.evaluated_get(graph)
    curves = evaluated.data
    if not len(curves.points):
        raise Unfit(f"{hair.name}: has no curves; add some in sculpt mode")
    attributes = curves.attributes
    types = attributes.get("curve_type")
    if types is not None and (read(types.data, "value") == NURBS).any():
        raise Unfit(f"{hair.name}: has NURBS, which pass beside their points; make them Catmull-Rom by Curves > Set Curve Type")
    arrays = {
        "points": placed(read(attributes["position"].data, "vector", 3), evaluated.matrix_world, unit),
        "offsets": read(curves.curve_offset_data, "value", kind=np.int32),
        "meters_per_unit": np.array(1.0),
    }
    if (uv := attributes.get("surface_uv_coordinate")) is not None:
        arrays["root_uv"] = read(uv.data, "vector", 2)
    if (radius := attributes.get("radius")) is not None:
        scale = abs(np.linalg.det(np.array(evaluated.matrix_world)[:3, :3])) ** (1 / 3)
        arrays["radius"] = unit * scale * read(radius.data, "value")
    return arrays
