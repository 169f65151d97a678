"""Plots of a simulation's air. Needs Matplotlib: `pip install matplotlib`."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from numpy.typing import ArrayLike, NDArray

    from windswept._native import Simulation

__all__ = ["energy_spectrum", "profile", "spectrum"]

_AXES = {"x": 0, "y": 1, "z": 2}


def energy_spectrum(
    positions: ArrayLike, velocities: ArrayLike, box: ArrayLike, *, spacing: float | None = None
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Kinetic energy of the fluctuations by wave number.

    Particles are averaged on a grid (nearest cell; empty cells have the mean), which damps waves shorter than a few cells.

    Args:
        positions: `(n, 3)` [m].
        velocities: `(n, 3)` [m/s].
        box: `(2, 3)` lower and upper corner of the periodic box [m].
        spacing: of the grid [m]; None: twice the mean distance of particles.

    Returns:
        k [rad/m] and E(k) [m³/s²]; the sum of E dk is ½ ⟨u'²⟩ on the grid.
    """
    x, v, corners = (np.asarray(a, dtype=float) for a in (positions, velocities, box))
    if x.ndim != 2 or x.shape[1] != 3 or x.shape != v.shape or len(x) == 0:
        raise ValueError(f"positions, velocities: expected two arrays (n, 3), found {x.shape} and {v.shape}")
    if corners.shape != (2, 3) or not (corners[1] > corners[0]).all():
        raise ValueError("box: expected (2, 3), lower and upper corner")
    size = corners[1] - corners[0]
    spacing = 2.0 * float(np.prod(size) / len(x)) ** (1 / 3) if spacing is None else spacing
    if not spacing > 0.0:
        raise ValueError(f"spacing: expected a length above 0, found {spacing}")
    cells = np.maximum(np.round(size / spacing), 2).astype(int)
    index = np.minimum(((x - corners[0]) / size * cells).astype(int), cells - 1)
    flat = np.ravel_multi_index(tuple(index.T), tuple(cells), mode="wrap")
    count = np.bincount(flat, minlength=int(np.prod(cells)))
    energy = np.zeros(tuple(cells), dtype=np.float64)
    for axis in range(3):
        fluctuation = v[:, axis] - v[:, axis].mean()
        mean = np.bincount(flat, fluctuation, minlength=len(count)) / np.maximum(count, 1)
        wave = np.fft.fftn(mean.reshape(tuple(cells))) / len(count)
        energy += 0.5 * np.abs(wave) ** 2
    waves = [2 * np.pi * np.fft.fftfreq(n, side / n) for n, side in zip(cells, size)]
    length = np.sqrt(sum(w**2 for w in np.meshgrid(*waves, indexing="ij")))
    # Shells as wide as the longest wave of the box, up to what every axis carries.
    width = 2 * np.pi / float(size.max())
    shells = int(np.pi * float((cells / size).min()) / width)
    shell = np.round(length / width).astype(int).ravel()
    total = np.bincount(shell, energy.ravel(), minlength=shells + 1)[1 : shells + 1].astype(np.float64)
    return width * np.arange(1, shells + 1, dtype=np.float64), total / width


def spectrum(sim: Simulation, *, ax: Axes | None = None, label: str | None = None) -> Axes:
    """Draws the energy spectrum of a simulation's air, both axes logarithmic.

    Raises:
        ValueError: the simulation has no air particles.
    """
    _has_air(sim)
    k, energy = energy_spectrum(sim.air.positions, sim.air.velocities, sim.air.box)
    ax = _axes(ax)
    ax.loglog(k, energy, label=label)
    ax.set_xlabel("wave number k [rad/m]")
    ax.set_ylabel("E(k) [m³/s²]")
    return ax


def profile(
    sim: Simulation,
    *,
    along: str = "y",
    component: str = "x",
    bins: int = 24,
    ax: Axes | None = None,
    label: str | None = None,
) -> Axes:
    """Draws the mean of one component of the air's velocity along an axis of the box, with its standard deviation.

    Args:
        along: "x", "y" or "z", upwards in the plot [m].
        component: the same [m/s].
        bins: slices of the box; those without a particle are left out.

    Raises:
        ValueError: another axis, or the simulation has no air particles.
    """
    for name, value in (("along", along), ("component", component)):
        if value not in _AXES:
            raise ValueError(f"{name}: expected 'x', 'y' or 'z', found {value!r}")
    if bins < 1:
        raise ValueError(f"bins: expected at least 1, found {bins}")
    _has_air(sim)
    x, v = sim.air.positions[:, _AXES[along]], sim.air.velocities[:, _AXES[component]]
    low, high = sim.air.box[:, _AXES[along]]
    edges = np.linspace(low, high, bins + 1)
    which = np.clip(np.digitize(x, edges) - 1, 0, bins - 1)
    count = np.bincount(which, minlength=bins).astype(float)
    count[count == 0] = np.nan
    mean = np.bincount(which, v, minlength=bins) / count
    spread = np.sqrt(np.bincount(which, (v - mean[which]) ** 2, minlength=bins) / count)
    middle = 0.5 * (edges[1:] + edges[:-1])
    ax = _axes(ax)
    (line,) = ax.plot(mean, middle, label=label)
    ax.fill_betweenx(middle, mean - spread, mean + spread, alpha=0.2, color=line.get_color())
    ax.set_xlabel(f"mean velocity in {component} [m/s]")
    ax.set_ylabel(f"{along} [m]")
    return ax


def _has_air(sim: Simulation) -> None:
    if len(sim.air.positions) == 0:
        raise ValueError("sim: has no air particles to plot")


def _axes(ax: Axes | None) -> Axes:
    if ax is not None:
        return ax
    try:
        from matplotlib import pyplot
    except ImportError as error:
        raise ImportError("windswept.plot needs Matplotlib: pip install matplotlib") from error
    return pyplot.subplots()[1]
