"""Points on the curves of USD: each a weighted sum of a curve's vertices, as many as it has vertices, or between its ends."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray


@dataclass
class Weights:
    """Points on curves: `indices` of vertices with `weights`, a row for each point, and how many points each curve has."""

    indices: NDArray[np.int64]
    weights: NDArray[np.float64]
    counts: NDArray[np.int64]

    def of(self, values: NDArray[Any]) -> NDArray[np.float64]:
        """What the points have, of what there is for each vertex."""
        found: NDArray[np.float64] = np.einsum("pk,pk...->p...", self.weights, values[self.indices])
        return found


def _joined(of_each: list[tuple[NDArray[np.int64], NDArray[np.float64]]], firsts: NDArray[np.int64]) -> Weights:
    """The weights of all curves, from those of each and its first vertex."""
    width = max((indices.shape[1] for indices, _ in of_each), default=1)

    def wide(rows: NDArray[Any]) -> NDArray[Any]:
        return np.pad(rows, ((0, 0), (0, width - rows.shape[1])))

    indices = [wide(indices) + first for (indices, _), first in zip(of_each, firsts)]
    weights = [wide(weights) for _, weights in of_each]
    counts = np.array([len(rows) for rows in indices], dtype=np.int64)
    return Weights(np.concatenate([np.empty((0, width), np.int64), *indices]), np.concatenate([np.empty((0, width)), *weights]), counts)


def _firsts(counts: NDArray[np.int64]) -> NDArray[np.int64]:
    return np.concatenate([[0], np.cumsum(counts)[:-1]]).astype(np.int64)


def _between(places: NDArray[np.float64], most: int) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """Linear between values 0 to `most`, at these places."""
    low = np.clip(np.floor(places).astype(np.int64), 0, max(most - 1, 0))
    part = places - low
    return np.stack([low, np.minimum(low + 1, most)], axis=1), np.stack([1 - part, part], axis=1)


def vertices(counts: NDArray[np.int64], without_ends: bool = False) -> Weights:
    """Curves through their vertices; `without_ends`: through all but the first and the last, as Catmull-Rom splines that are not pinned."""
    cut = 1 if without_ends else 0
    each = [np.arange(cut, max(count - cut, cut))[:, None] for count in counts]
    return _joined([(indices, np.ones(indices.shape)) for indices in each], _firsts(counts))


def b_spline(counts: NDArray[np.int64], pinned: bool) -> Weights:
    """Uniform cubic B-splines at their knots; pinned ones begin and end in a vertex."""

    def one(count: int) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
        inner: NDArray[np.int64] = np.arange(1, max(count - 1, 1))[:, None] + np.array([-1, 0, 1])
        weights = np.tile([1 / 6, 4 / 6, 1 / 6], (len(inner), 1))
        if not pinned or count < 2:
            return inner, weights
        first, last, one_alone = np.zeros((1, 3), np.int64), np.full((1, 3), count - 1, np.int64), np.array([[1.0, 0.0, 0.0]])
        return np.concatenate([first, inner, last]), np.concatenate([one_alone, weights, one_alone])

    return _joined([one(count) for count in counts], _firsts(counts))


def bezier(counts: NDArray[np.int64]) -> Weights:
    """Cubic Bézier curves at thirds of their segments."""

    def one(count: int) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
        if count < 4:
            return np.arange(count)[:, None], np.ones((count, 1))
        at = np.arange(count)
        segment = np.minimum(at // 3, (count - 1) // 3 - 1)
        t = (at - 3 * segment) / 3
        weights = np.stack([(1 - t) ** 3, 3 * t * (1 - t) ** 2, 3 * t * t * (1 - t), t**3], axis=1)
        return 3 * segment[:, None] + np.arange(4), weights

    return _joined([one(count) for count in counts], _firsts(counts))


def bezier_of_hermite(points: NDArray[Any], tangents: NDArray[Any], counts: NDArray[np.int64]) -> tuple[NDArray[Any], NDArray[np.int64]]:
    """The vertices of Bézier curves that are these Hermite curves, and how many each has."""
    triples = np.stack([points - tangents / 3, points, points + tangents / 3], axis=1).reshape(-1, 3)
    inner = np.ones(len(triples), dtype=bool)
    firsts = 3 * _firsts(counts)
    some = counts > 0
    inner[firsts[some]] = False
    inner[(firsts + 3 * counts - 1)[some]] = False
    return triples[inner], np.where(some, 3 * counts - 2, 0)


def nurbs(counts: NDArray[np.int64], orders: NDArray[np.int64], knots: NDArray[np.float64], rational: NDArray[np.float64]) -> Weights:
    """NURBS, each evenly in its parameter, at as many places as it has vertices; `rational`: the weight of each vertex."""

    def one(count: int, order: int, own: NDArray[np.float64], rational: NDArray[np.float64]) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
        u = np.linspace(own[order - 1], own[count], count)
        span = np.clip(np.searchsorted(own, u, side="right") - 1, order - 1, count - 1)
        # Cox and de Boor: the basis functions that are not 0 in the span, degree by degree.
        basis = np.ones((count, 1))
        for degree in range(1, order):
            k = np.arange(degree)
            right, left = own[span[:, None] + 1 + k], own[span[:, None] + 1 - degree + k]
            part = basis / np.where(right > left, right - left, 1) * (right > left)
            basis = np.zeros((count, degree + 1))
            basis[:, :-1] += part * (right - u[:, None])
            basis[:, 1:] += part * (u[:, None] - left)
        indices = span[:, None] - order + 1 + np.arange(order)
        weights = basis * rational[indices]
        return indices, weights / weights.sum(axis=1, keepdims=True)

    firsts, first_knots = _firsts(counts), _firsts(counts + orders)
    each = [
        one(count, order, knots[knot : knot + count + order], rational[first : first + count])
        for count, order, first, knot in zip(counts, orders, firsts, first_knots)
    ]
    return _joined(each, firsts)


def varying(points: NDArray[np.int64], ends: NDArray[np.int64]) -> Weights:
    """Curves of so many points, evenly in the parameter, of what there is for the ends of segments, of which each curve has so many."""
    each = [_between(np.linspace(0, max(end - 1, 0), count), max(end - 1, 0)) for count, end in zip(points, ends)]
    return _joined(each, _firsts(ends))
