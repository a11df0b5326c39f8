"""Poles to begin with: poly-reference least squares over many orders, clustered."""

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from impact_testing.responses import PointData
from impact_testing.thresholds import IMPACT
from oma_identifier.methods import HalfSpectra, NormalEquations
from oma_identifier.selection import BandPoles, cluster_poles
from oma_identifier.subspace import RawPoles

Complex = NDArray[np.complex128]
Real = NDArray[np.float64]
TWO_PI = 2.0 * np.pi
MARGIN = 1.25
"""A part of the band is solved with so much more on either side."""
MOST_REFERENCES = 4
HIGHEST_DEGREE = 24
LEAST_SHARE = 0.3
"""Of the orders that must show a pole: the likelihood decides later, so few are missed here."""
NEAR, BEYOND = 1.1, 2.0
"""Modes beyond the end of the band bend it, and are looked for up to twice as high.  Poles within
are sharper told where the polynomials reach no further than near its end."""


def start_poles(data: Sequence[PointData]) -> Complex:
    """Return poles that several polynomial orders agree on, part of the band by part.

    Parameters
    ----------
    data : sequence of PointData
        One per point that was hit; channels may differ where set-ups rove.

    Returns
    -------
    (n_poles,) complex array [rad/s]
    """
    frequency_hz = data[0].frequency_hz
    value = _table([each.frf.h1[each.lines] for each in data])
    weight = sum((1.0 / each.course for each in data), np.zeros(1))
    edges = _edges(float(frequency_hz[0]), float(frequency_hz[-1]), value.shape[2], frequency_hz)
    found = [np.empty(0, dtype=complex)]
    for low, high in pairwise(edges):
        seen = (frequency_hz >= low / MARGIN) & (frequency_hz <= high * MARGIN)
        part = frequency_hz[seen], value[seen], weight[seen]
        found.append(_between(low, high, _of_part(*part, NEAR)))
        if high == edges[-1]:
            found.append(_between(high, BEYOND * high, _of_part(*part, BEYOND)))
    together = np.concatenate(found)
    return np.asarray(together[np.argsort(np.abs(together))])


def _edges(low: float, high: float, n_references: int, frequency_hz: Real) -> list[float]:
    """Return ends of parts, each twice the last or as wide as the lines it takes."""
    least = 8 * n_references * float(frequency_hz[1] - frequency_hz[0])
    edges = [high]
    while edges[-1] / 2.0 > low and edges[-1] / 2.0 > least:
        edges.append(edges[-1] / 2.0)
    return [low, *edges[-2::-1], high] if len(edges) > 1 else [low, high]


def _between(low_hz: float, high_hz: float, poles: Complex) -> Complex:
    size_hz = np.abs(poles) / TWO_PI
    return np.asarray(poles[(size_hz >= low_hz) & (size_hz < high_hz)])


def _of_part(frequency_hz: Real, value: Complex, weight: Real, reach: float) -> Complex:
    n_references = value.shape[2]
    top = float(frequency_hz[-1]) * reach
    spectra = HalfSpectra(np.pi * frequency_hz / top, value, 0.0)
    # Each order has as many poles as references; no more coefficients than a third of the lines.
    highest = max(4, min(HIGHEST_DEGREE, len(frequency_hz) // (3 * n_references)))
    equations = NormalEquations(spectra, highest, weight / weight.mean())
    found = [equations.solve(order) for order in range(max(2, highest // 3), highest + 1, 2)]
    poles = _together(found, top)
    eligible = np.flatnonzero(
        (poles.damping_ratio > 0.0)
        & (poles.damping_ratio < IMPACT.most_damping)
        & np.isfinite(poles.pole)
    )
    clusters = cluster_poles(poles, eligible)
    kept = [each for each in clusters if len(each) >= LEAST_SHARE * len(found)]
    return np.asarray(poles.pole[[each.centre for each in kept]])


def _table(responses: Sequence[Complex]) -> Complex:
    """Return FRFs as (n_lines, n_outputs, n_references), references few."""
    n_lines = len(responses[0])
    if len({each.shape[1] for each in responses}) > 1 or len(responses) == 1:
        columns = np.concatenate([each / _size(each) for each in responses], axis=1)
        return columns[:, :, None]
    value = np.stack(responses, axis=2)
    value = value / np.sqrt(np.mean(np.abs(value) ** 2, axis=(0, 2)))[None, :, None]
    flat = value.reshape(-1, value.shape[2])
    if value.shape[2] > MOST_REFERENCES:
        # The points hit, mixed into the few that tell most.
        power = np.real(flat.conj().T @ flat)
        mix = np.linalg.eigh(power)[1][:, -MOST_REFERENCES:]
        value = value @ mix
    return np.asarray(value.reshape(n_lines, value.shape[1], -1))


def _size(columns: Complex) -> NDArray[np.float64]:
    return np.asarray(np.sqrt(np.mean(np.abs(columns) ** 2, axis=0)) + 1e-300)


def _together(found: Sequence[RawPoles], top_hz: float) -> BandPoles:
    eigenvalue = np.concatenate([each.eigenvalue for each in found])
    return BandPoles(
        model_order=np.concatenate([each.model_order for each in found]),
        eigenvalue=eigenvalue,
        pole=2.0 * top_hz * np.log(eigenvalue),
        shape=np.concatenate([each.shape for each in found], axis=1),
    )
