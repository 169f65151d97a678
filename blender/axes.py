"""From Blender's axes and unit to windswept's: metres, Y up."""

import numpy as np

#: x stays, Blender's z is up, which is windswept's y.
TURN = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]])


def unit(scene):
    """Metres per unit of a Blender scene."""
    return scene.unit_settings.scale_length if scene.unit_settings.system != "NONE" else 1.0


def of_windswept(vectors):
    """Vectors `(..., 3)` of Blender in windswept's axes."""
    return np.asarray(vectors, dtype=float) @ TURN.T


def placed(points, matrix, unit):
    """Points `(n, 3)` of an object with this matrix in the world of windswept [m]."""
    matrix = np.array(matrix)
    return of_windswept(unit * (points @ matrix[:3, :3].T + matrix[:3, 3]))


def rounded(numbers):
    """Numbers of a scene to nine decimals: it takes none between 0 and 1e-18, as rounding leaves them."""
    return np.round(numbers, 9)


def read(collection, name, width=1, kind=np.float32):
    """What each element of a Blender collection has under a name: `(n, width)`, or `(n,)`."""
    values = np.empty(width * len(collection), kind)
    collection.foreach_get(name, values)
    values = values.astype(np.int64 if kind == np.int32 else np.float64)
    return values.reshape(-1, width) if width > 1 else values
