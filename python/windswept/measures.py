"""Numbers that describe a film of hair."""

from __future__ import annotations

import json
from collections.abc import Iterable
from os import PathLike
from typing import TYPE_CHECKING, Any

from windswept._native import Frame, _measure_file, _measure_frames

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

__all__ = ["measure"]


def measure(
    film: str | PathLike[str] | Iterable[Frame],
    *,
    wind: ArrayLike | None = None,
    gravity: ArrayLike | None = None,
    start: float | None = None,
    end: float | None = None,
) -> dict[str, Any]:
    """Measures the hair of a film: how far and how fast its tips swing, how much its strands turn, gather and lean.

    Args:
        film: a run's folder, a `hair.vtkhdf`, or the frames of `sim.frames()`, at least 8 in the window, at even times.
        wind: mean wind [m/s], three numbers; swing is across it. Default: that of the scene in a run's folder; else
            none, and swing is across the mean direction from root to tip.
        gravity: three numbers, of any length, from which lean is measured. Default: that of the scene in a run's folder, else down.
        start, end: the time that is measured [s]. Default: from 0.2 s, or all of a film shorter than 0.4 s, to the last frame.

    Returns:
        Numbers by name; one without a meaning is None:

        * `strands`, `frames`, `from_s`, `to_s`, `axis`: what was measured, and the direction that sideways is across.
        * `swing_m`: rms of the tips' sideways displacement from their mean places. Its square is that of `swing_bundle_m`, of the mean of
          all tips, and that of `swing_strands_m`, relative to that mean.
        * `frequency_hz`: peak of the swing's spectrum, `spectrum_power_m2_per_hz` over `spectrum_frequency_hz`, both NumPy arrays.
        * `wavelength_m`: of the undulation along strands.
        * `turning_mean_degrees`, `turning_largest_degrees` (with `turning_strand` and `turning_time_s`): how far a strand turns along
          itself; 360 in a circle. `turns`: of a curl.
        * `gathering`: distance to the four nearest strands at 0.8 of the length over that at the roots.
        * `coherence`: correlation of neighbouring tips' velocities, 1 where they move alike.
        * `lean_degrees`: from gravity to the line from root to tip. `stretch`: of the most stretched segment, a part of its length.

    Raises:
        ExportError: a film that cannot be read or is too short.
        SceneError: a folder whose `scene.toml` is not a scene.
        ValueError: another argument.
    """
    import numpy as np

    def vector(name: str, value: ArrayLike) -> list[float]:
        array = np.asarray(value, dtype=float)
        if array.shape != (3,) or not np.isfinite(array).all():
            raise ValueError(f"{name}: expected three finite numbers, found {value!r}")
        return [float(x) for x in array]

    blows = None if wind is None else vector("wind", wind)
    down = None if gravity is None else vector("gravity", gravity)
    measured = _measure_file if isinstance(film, (str, PathLike)) else _measure_frames
    text = measured(film, blows, down, start, end)  # type: ignore[arg-type]
    numbers: dict[str, Any] = json.loads(text)
    for name in ("spectrum_frequency_hz", "spectrum_power_m2_per_hz"):
        numbers[name] = np.array(numbers[name])
    return numbers
