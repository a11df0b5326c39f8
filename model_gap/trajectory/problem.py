"""Everything a fit needs of the recordings: columns of all laws, noise whitened, as sums."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from model_gap.trajectory.term import Array, Term, Track

Index = NDArray[np.intp]
# What one sample still tells of the next is taken out: two numbers describe a resonance.
AR_ORDER = 2


@dataclass(frozen=True)
class Layout:
    """Where the columns of every term are.

    Parameters
    ----------
    terms : tuple of Term
        All that may be in a fit.
    places : tuple of slice
        Columns of the term's own weights.
    local : tuple of (n_records,) tuple of slice
        Columns of its weights that are every recording's own.
    scale : (n_columns,) array
        Prior standard deviations.
    """

    terms: tuple[Term, ...]
    places: tuple[slice, ...]
    local: tuple[tuple[slice, ...], ...]
    scale: Array

    def columns_of(self, chosen: Sequence[int]) -> Index:
        """Return the columns of some terms, local ones behind each term's own."""
        parts = [
            np.r_[self.places[item], *(self.local[item])] if self.local[item] else
            np.r_[self.places[item]]
            for item in chosen
        ]  # fmt: skip
        return np.concatenate(parts).astype(np.intp) if parts else np.zeros(0, np.intp)


@dataclass(frozen=True)
class Problem:
    """Columns and data along some recordings.

    Parameters
    ----------
    layout : Layout
        Where the terms' columns are.
    columns : tuple of (n, n_rows, n_columns) array
        By recording.
    data : tuple of (n, n_rows) array
        Measured minus what the model says, by recording.
    known : set of (type, location)
        Laws that the model has.
    """

    layout: Layout
    columns: tuple[Array, ...]
    data: tuple[Array, ...]
    known: frozenset[tuple[str, str]] = frozenset()

    @property
    def n_rows(self) -> int:
        """How many axes (or encoders) there are."""
        return int(self.data[0].shape[1])

    def residuals(self, weights: Array) -> tuple[Array, ...]:
        """Return what weights leave over, by recording."""
        return tuple(
            y - np.einsum('nqp,p->nq', x, weights)
            for x, y in zip(self.columns, self.data, strict=True)
        )


def problem_of(tracks: Sequence[Track], terms: Sequence[Term]) -> Problem:
    """Return the columns of all terms of one quantity along recordings.

    Parameters
    ----------
    tracks : sequence of Track
        Recordings.
    terms : sequence of Term
        Of one quantity.
    """
    places, local, scale, begin = [], [], [], 0
    blocks: list[list[Array]] = [[] for _ in tracks]
    for term in terms:
        own = [term.columns(track) for track in tracks]
        own_local = [term.local_columns(track) for track in tracks]
        width, extra = own[0].shape[2], own_local[0].shape[2]
        places.append(slice(begin, begin + width))
        begin += width
        scale += [item.scale for item in term.weights()]
        ends = []
        for number in range(len(tracks) if extra else 0):
            ends.append(slice(begin, begin + extra))
            begin += extra
            scale += [term.local_scale()] * extra
            own = [
                np.concatenate(
                    [values, own_local[place] * (1.0 if place == number else 0.0)], axis=2
                )
                for place, values in enumerate(own)
            ]
        local.append(tuple(ends))
        for block, values in zip(blocks, own, strict=True):
            block.append(values)
    layout = Layout(tuple(terms), tuple(places), tuple(local), np.array(scale))
    quantity = terms[0].quantity
    return Problem(
        layout,
        tuple(np.concatenate(block, axis=2) for block in blocks),
        tuple(track.left(quantity) for track in tracks),
    )


@dataclass(frozen=True)
class Sums:
    """A whitened problem as normal equations, by row.

    Parameters
    ----------
    gram : (n_rows, n_columns, n_columns) array
        XᵀX.
    moment : (n_rows, n_columns) array
        Xᵀy.
    square : (n_rows,) array
        yᵀy.
    count : (n_rows,) array
        Number of whitened samples.
    """

    gram: Array
    moment: Array
    square: Array
    count: Array

    def __sub__(self, other: 'Sums') -> 'Sums':
        """Return the sums without those of a part of the data."""
        return Sums(
            self.gram - other.gram,
            self.moment - other.moment,
            self.square - other.square,
            self.count - other.count,
        )


def memory_of(residuals: Sequence[Array]) -> Array:
    """Return how every sample follows from those before, (n_rows, AR_ORDER), by least squares.

    Parameters
    ----------
    residuals : sequence of (n, n_rows) array
        By recording.
    """
    found = []
    for row in range(residuals[0].shape[1]):
        past = np.concatenate(
            [
                np.column_stack(
                    [item[AR_ORDER - lag - 1 : -lag - 1, row] for lag in range(AR_ORDER)]
                )
                for item in residuals
            ]
        )
        now = np.concatenate([item[AR_ORDER:, row] for item in residuals])
        found.append(np.linalg.lstsq(past, now, rcond=None)[0])
    return np.array(found)


def whitened(values: Array, memory: Array) -> Array:
    """Return series (n, n_rows, ...) without what follows from the samples before."""
    found = values[AR_ORDER:].copy()
    for lag in range(AR_ORDER):
        weight = memory[:, lag].reshape(1, -1, *([1] * (values.ndim - 2)))
        found -= weight * values[AR_ORDER - lag - 1 : len(values) - lag - 1]
    return found


def sums_of(problem: Problem, memory: Array, blocks: int = 1) -> list[Sums]:
    """Return the whitened sums of every block of every recording.

    Parameters
    ----------
    problem : Problem
        Columns and data.
    memory : (n_rows, AR_ORDER) array
        Of the noise.
    blocks : int
        Into how many each recording is divided.
    """
    found = []
    for x, y in zip(problem.columns, problem.data, strict=True):
        white_x, white_y = whitened(x, memory), whitened(y, memory)
        for part in np.array_split(np.arange(len(white_y)), blocks):
            some, right = white_x[part].transpose(1, 0, 2), white_y[part].T
            found.append(
                Sums(
                    some.transpose(0, 2, 1) @ some,
                    np.einsum('qnp,qn->qp', some, right),
                    np.einsum('qn,qn->q', right, right),
                    np.full(problem.n_rows, float(len(part))),
                )
            )
    return found


def total(parts: Sequence[Sums]) -> Sums:
    """Return the sums of all parts."""
    return Sums(
        np.sum([item.gram for item in parts], axis=0),
        np.sum([item.moment for item in parts], axis=0),
        np.sum([item.square for item in parts], axis=0),
        np.sum([item.count for item in parts], axis=0),
    )
