"""Single passes of the step on arrays of your own.

Positions and velocities are `(n, 3)`, float32 or float64 in, float32 out. `box=(Lx, Ly, Lz)` makes space periodic on
[0, L): positions are wrapped, and a side below 3 radii is a ValueError. They run on the adapter that WGPU_ADAPTER_NAME
names, else on the best.

All raise ValueError naming an argument that does not fit (a shape, a dtype, a NaN, a value), and GpuError without an adapter.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from windswept import _native

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import ArrayLike, NDArray

__all__ = ["band_velocity", "density", "solve_density", "viscosity", "vorticity"]


def density(positions: ArrayLike, *, mass: float, radius: float, box: ArrayLike | None = None) -> NDArray[np.float32]:
    """ρ = m Σ_j W(x_i − x_j), self included, W = 315/(64πh⁹)(h² − r²)³ (Poly6; Müller et al. 2003, eq. 20).

    Args:
        positions: `(n, 3)` [m].
        mass: of each particle [kg].
        radius: kernel radius h [m].
        box: sides of the periodic box [m].

    Returns:
        `(n,)` float32 [kg/m³].
    """
    return _native.ops_density(positions, mass, radius, box)


def vorticity(
    positions: ArrayLike,
    velocities: ArrayLike,
    *,
    mass: float,
    rest_density: float,
    radius: float,
    box: ArrayLike | None = None,
) -> NDArray[np.float32]:
    """ω = Σ_j V (v_j − v_i) × ∇_j W, Spiky's gradient, the plain sum (Demura et al. 2019, eq. 2 with its missing 1/ρ).

    On the simple cubic lattice a rigid rotation Ω reads 0.945 of 2Ω.

    Args:
        positions: `(n, 3)` [m].
        velocities: `(n, 3)` [m/s].
        mass: of each particle [kg].
        rest_density: ρ0 [kg/m³]; V = mass / ρ0.
        radius: kernel radius h [m].
        box: sides of the periodic box [m].

    Returns:
        `(n, 3)` float32 [1/s].
    """
    return _native.ops_vorticity(positions, velocities, mass, rest_density, radius, box)


def band_velocity(
    positions: ArrayLike,
    velocities: ArrayLike,
    *,
    mass: float,
    rest_density: float,
    scale: float,
    filter: str = "grid",
    cutoff: float | None = None,
    box: ArrayLike | None = None,
) -> NDArray[np.float32]:
    """û, the velocity of eddies of one size: the Mexican hat over the particles' velocities (Demura et al. 2019, eqs. 5, 6).

    Unit gain at the band's centre, k s = √2, wavelength 4.44 s.

    Args:
        positions: `(n, 3)` [m].
        velocities: `(n, 3)` [m/s], about the mean flow: the cut filter lets some of a mean through.
        mass: of each particle [kg].
        rest_density: ρ0 [kg/m³].
        scale: s [m].
        filter: "grid" (cost falls as s grows) or "direct" (the sum itself).
        cutoff: of the direct filter, in units of s; None: as a scene's `turbulence.cutoff` by default.
        box: sides of the periodic box [m], each at least 5.77 particle spacings, (mass / rest_density)^⅓: 3 radii of the paper.

    Returns:
        `(n, 3)` float32 [m/s].
    """
    return _native.ops_band_velocity(positions, velocities, mass, rest_density, scale, filter, cutoff, box)


def viscosity(
    positions: ArrayLike,
    velocities: ArrayLike,
    *,
    mass: float,
    radius: float,
    coefficient: float,
    box: ArrayLike | None = None,
) -> NDArray[np.float32]:
    """Velocities after one XSPH update (Demura et al. 2019, eq. 7), limited where it could overshoot.

    Args:
        positions: `(n, 3)` [m].
        velocities: `(n, 3)` [m/s].
        mass: of each particle [kg].
        radius: kernel radius h [m].
        coefficient: c, dimensionless; the viscosity is c h²/(22 Δt).
        box: sides of the periodic box [m].

    Returns:
        `(n, 3)` float32 [m/s].
    """
    return _native.ops_viscosity(positions, velocities, mass, radius, coefficient, box)


def solve_density(
    positions: ArrayLike,
    *,
    mass: float,
    rest_density: float,
    radius: float,
    iterations: int,
    relaxation: float = 0.5,
    box: ArrayLike | None = None,
) -> NDArray[np.float32]:
    """Positions after Jacobi iterations of the density constraint ρ = ρ0 (Demura et al. 2019, eq. 1; Macklin & Müller 2013).

    Args:
        positions: `(n, 3)` [m].
        mass: of each particle [kg].
        rest_density: ρ0 [kg/m³].
        radius: kernel radius h [m], at least 1.2 particle spacings.
        iterations: 0 to 10000; neighbours are searched once.
        relaxation: part of a Jacobi step.
        box: sides of the periodic box [m].

    Returns:
        `(n, 3)` float32 [m], wrapped into the box.
    """
    return _native.ops_solve_density(positions, mass, rest_density, radius, iterations, relaxation, box)
