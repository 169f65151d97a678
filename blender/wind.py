"""The wind of an empty or a force field."""

import numpy as np

from .axes import of_windswept, rounded


def blowing(wind, speed, graph):
    """Velocity of the wind now [m/s], Y up: along the object's Z axis, with the strength of a force field or else the speed."""
    if wind is None:
        return np.zeros(3)
    now = wind.evaluated_get(graph)
    direction = np.array(now.matrix_world)[:3, 2]
    field = now.field
    if field is not None and field.type == "WIND":
        speed = field.strength
    return of_windswept(speed * direction / np.linalg.norm(direction))


def keys(velocities, times):
    """Keys of `air` for these velocities `(T, 3)` [m/s]: their mean, and gusts about it where they change."""
    import windswept as ws

    mean = rounded(velocities.mean(axis=0))
    if np.allclose(velocities, mean, rtol=0, atol=1e-6):
        return {"wind": mean}
    return {"wind": mean, "gust": [ws.Gust(time=t, velocity=v) for t, v in zip(times, rounded(velocities - mean))]}
