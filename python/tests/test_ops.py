"""Single passes against their formulas, in NumPy and float64."""

import numpy as np
import pytest

import windswept as ws

MASS, REST, H = 1.46e-7, 1.29, 9.3e-3
D = (MASS / REST) ** (1 / 3)
BOX = np.array([9, 8, 8]) * D


@pytest.fixture
def particles():
    rng = np.random.default_rng(7)
    seats = np.stack(np.meshgrid(*[np.arange(n) + 0.5 for n in (9, 8, 8)], indexing="ij"), -1).reshape(-1, 3)
    positions = (seats + rng.uniform(-0.3, 0.3, seats.shape)) * D
    return positions, rng.normal(size=positions.shape)


def pairs(positions):
    """Differences x_i - x_j to the nearest image, and distances."""
    r = positions[:, None] - positions[None]
    r -= BOX * np.round(r / BOX)
    return r, np.linalg.norm(r, axis=-1)


def poly6(r):
    return np.where(r < H, 315 / (64 * np.pi * H**9) * np.maximum(H**2 - r**2, 0) ** 3, 0.0)


def spiky_gradient(difference, r):
    safe = np.where(r > 0, r, 1.0)
    size = np.where((r > 0) & (r < H), -45 / (np.pi * H**6) * (H - r) ** 2 / safe, 0.0)
    return size[..., None] * difference


def assert_near(found, expected, tolerance):
    assert found.dtype == np.float32 and found.shape == expected.shape
    assert np.abs(found - expected).max() <= tolerance * np.abs(expected).max()


def test_density(particles):
    x, _ = particles
    _, r = pairs(x)
    # Measured 3e-6: f32.
    assert_near(ws.ops.density(x, mass=MASS, radius=H, box=BOX), MASS * poly6(r).sum(1), 2e-5)
    assert_near(ws.ops.density(x[:1], mass=MASS, radius=H), MASS * poly6(np.zeros(1)), 1e-6)


def test_vorticity(particles):
    x, v = particles
    difference, r = pairs(x)
    terms = np.cross(v[None] - v[:, None], -spiky_gradient(difference, r))  # by x_j
    found = ws.ops.vorticity(x, v, mass=MASS, rest_density=REST, radius=H, box=BOX)
    assert_near(found, MASS / REST * terms.sum(1), 2e-5)


def test_a_rigid_rotation_reads_as_twice_its_rate():
    seats = np.stack(np.meshgrid(*[np.arange(9) - 4.0] * 3, indexing="ij"), -1).reshape(-1, 3) * D
    velocities = np.cross([0.0, 0.0, 5.0], seats)
    omega = ws.ops.vorticity(seats, velocities, mass=MASS, rest_density=REST, radius=H)
    # The plain sum on the simple cubic lattice: 0.945 of 2 Ω.
    assert omega[4 * 81 + 4 * 9 + 4] == pytest.approx([0, 0, 0.945 * 10.0], abs=0.01)


def test_viscosity(particles):
    x, v = particles
    _, r = pairs(x)
    w = poly6(r)
    np.fill_diagonal(w, 0.0)
    theta = MASS / REST * poly6(r).sum(1)
    weight = 0.1 * 2 * MASS / REST * w / (theta[:, None] + theta[None])
    expected = v + np.einsum("ij,ijk->ik", weight, v[None] - v[:, None])
    assert_near(ws.ops.viscosity(x, v, mass=MASS, radius=H, coefficient=0.1, box=BOX), expected, 2e-5)
    assert_near(ws.ops.viscosity(x, v, mass=MASS, radius=H, coefficient=0.0, box=BOX), v, 1e-6)


def test_band_velocity(particles):
    x, v = particles
    s, cutoff = 0.0035, 2.5
    difference, _ = pairs(x)
    expected = np.zeros_like(v)
    images = np.stack(np.meshgrid(*[[-1, 0, 1]] * 3, indexing="ij"), -1).reshape(-1, 3) * BOX
    for image in images:
        r2 = ((difference + image) ** 2).sum(-1) / s**2
        hat = np.where(r2 < cutoff**2, (3 - r2) * np.exp(-r2 / 2), 0.0)
        expected += hat @ v
    # Unit gain at the band's centre: the hat ψ = (3 - r²/s²) exp(-r²/2s²) has the transform (2π)^1.5 s³ (ks)²
    # exp(-(ks)²/2).
    expected *= MASS / REST / ((2 * np.pi) ** 1.5 * s**3 * 2 / np.e)
    found = ws.ops.band_velocity(x, v, mass=MASS, rest_density=REST, scale=s, filter="direct", cutoff=cutoff, box=BOX)
    assert_near(found, expected, 1e-4)


def test_band_velocity_on_a_grid_is_nearly_the_sum(particles):
    x, _ = particles
    k = 2 * np.pi / BOX[1]
    v = np.stack([np.sin(k * x[:, 1]), np.zeros(len(x)), np.cos(k * x[:, 1])], -1)
    known = {"mass": MASS, "rest_density": REST, "scale": np.sqrt(2) / k, "box": BOX}
    summed = ws.ops.band_velocity(x, v, filter="direct", cutoff=6.0, **known)
    # Measured 1.2e-3; margin 8.
    assert_near(ws.ops.band_velocity(x, v, **known), summed, 0.01)
    # At the band's centre the gain is 1; measured 1.047, of a jittered lattice.
    assert np.abs(summed).max() == pytest.approx(1.0, abs=0.1)


def test_solve_density(particles):
    x, _ = particles
    crowd = x[:200] * 0.8

    def excess(positions):
        density = ws.ops.density(positions, mass=MASS, radius=H)
        return np.maximum(density / REST - 1, 0).mean()

    moved = ws.ops.solve_density(crowd, mass=MASS, rest_density=REST, radius=H, iterations=30)
    assert excess(moved) < 0.3 * excess(crowd)
    same = ws.ops.solve_density(crowd, mass=MASS, rest_density=REST, radius=H, iterations=0)
    assert np.allclose(same, crowd, atol=1e-7)
    wrapped = ws.ops.solve_density(crowd + BOX, mass=MASS, rest_density=REST, radius=H, iterations=0, box=BOX)
    assert np.allclose(wrapped, crowd, atol=1e-7)


def test_none_at_all():
    none = np.zeros((0, 3))
    assert ws.ops.density(none, mass=MASS, radius=H).shape == (0,)
    assert ws.ops.vorticity(none, none, mass=MASS, rest_density=REST, radius=H).shape == (0, 3)


def test_faults_are_named(particles):
    x, v = particles
    good = {"mass": MASS, "rest_density": REST, "radius": H}
    for change, name in [
        ({"positions": x[:, :2]}, "positions"),
        ({"positions": x * np.nan}, "positions"),
        ({"positions": x.astype(object)}, "positions"),
        ({"positions": np.zeros((4, 3), int)}, "positions"),
        ({"velocities": v[1:]}, "velocities"),
        ({"velocities": v[0]}, "velocities"),
        ({"mass": 0.0}, "mass"),
        ({"rest_density": -1.0}, "rest_density"),
        ({"radius": float("nan")}, "radius"),
        ({"box": (2.9 * H, 1.0, 1.0)}, "box"),
        ({"box": (1.0, 1.0)}, "box"),
        ({"box": 1.0}, "box"),
    ]:
        with pytest.raises(ValueError, match=name):
            ws.ops.vorticity(**{"positions": x, "velocities": v, **good, **change})
    with pytest.raises(ValueError, match="filter"):
        ws.ops.band_velocity(x, v, mass=MASS, rest_density=REST, scale=0.006, filter="fast")
    for bad in (0.0, -1.0, float("nan"), 1e-7):
        with pytest.raises(ValueError, match="scale"):
            ws.ops.band_velocity(x, v, mass=MASS, rest_density=REST, scale=bad)
    with pytest.raises(ValueError, match="box"):
        ws.ops.band_velocity(x, v, mass=MASS, rest_density=REST, scale=0.006, box=(0.02, 0.1, 0.1))
    with pytest.raises(ValueError, match="iterations"):
        ws.ops.solve_density(x, iterations=-1, **good)
