"""Inputs that are known: which of them count in a band, and what they do there line by line."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from oma_identifier.likelihood.band_model import accelerance, BandData, BandModel, KnownInputs
from oma_identifier.likelihood.known_mean import columns_at, Mean, RCOND

Real = NDArray[np.float64]
Complex = NDArray[np.complex128]
WEAKEST = 1e-2
"""Amplitude of a combination of inputs over that of the strongest in a band: what weaker ones
drive counts as unknown force."""
MOST_UNKNOWNS = 0.1
"""Of the complex values of a band, that B and D may have.  Damping of single modes under six
inputs was half a deviation low at 0.11; with some of the inputs left out it was off by seven."""


def principal_inputs(inputs: Complex, n_modes: int, n_channels: int) -> Complex:
    """Return uncorrelated combinations of inputs, (n_inputs, n_lines), of unit mean square.

    None where a band is too short to tell what all of them do: one that is left out is a force
    that moves the sensors too, which nothing describes.
    """
    n_lines = inputs.shape[1]
    each = (n_modes + 2 * n_channels) / (n_channels * n_lines)
    most = MOST_UNKNOWNS / each
    _, size, right = np.linalg.svd(inputs, full_matrices=False)
    kept = int(np.count_nonzero(size > WEAKEST * size[0]))
    kept = kept if kept <= most else 0
    return np.asarray(right[:kept] * np.sqrt(n_lines))


def averages_with(data: BandData, values: Complex, inputs: Complex) -> BandData:
    """Return averages with what the inputs hold.

    Parameters
    ----------
    data : BandData
        Of the values.
    values : (n_lines, n_channels) complex array
        At all lines.
    inputs : (n_inputs, n_lines) complex array
        Of :func:`principal_inputs`.
    """
    count = data.n_averaged.astype(np.intp)
    first = np.append(0, np.cumsum(count[:-1]))
    u = inputs.T
    cross = np.add.reduceat(values[:, :, None] * u[:, None, :].conj(), first, axis=0)
    power = np.add.reduceat(u[:, :, None] * u[:, None, :].conj(), first, axis=0)
    weight = data.n_averaged[:, None, None]
    middle = float(data.frequency_hz.mean())
    reach = max(float(np.ptp(data.frequency_hz)), 1e-9) / 2.0
    known = KnownInputs(
        np.asarray(cross / weight, dtype=complex),
        np.asarray(power / weight, dtype=complex),
        middle,
        reach,
    )
    return replace(data, known=known)


@dataclass(frozen=True, slots=True)
class KnownMotion:
    """What known inputs do in a band that was fitted, line by line.

    Parameters
    ----------
    inputs : (n_inputs, n_lines) complex array
        Of :func:`principal_inputs`.
    values : (n_lines, n_channels) complex array
        T u in the coordinates of the band.
    modes : (n_modes, n_lines) complex array
        H B u.
    beside : (n_regressors, n_lines) complex array
        What D stands for, u and (f - f₀) u, and what the ends of each stretch leave: free decays,
        a jump and a kink.
    bends : float
        Probability that chance alone leaves so much of the inputs undescribed.
    """

    inputs: Complex
    values: Complex
    modes: Complex
    beside: Complex
    bends: float = 1.0

    @classmethod
    def of(
        cls,
        frequency_hz: Real,
        stretch: NDArray[np.intp],
        inputs: Complex,
        data: BandData,
        model: BandModel,
        mean: Mean,
    ) -> 'KnownMotion':
        """Return it at all lines of a band, each of one stretch."""
        known = data.known
        if known is None:
            raise ValueError('no inputs are known')
        columns = columns_at(frequency_hz, known, model)
        driven = mean.coefficients @ inputs
        values = np.einsum('kcq,qk->kc', columns, driven)
        bare = accelerance(frequency_hz, model.frequency_hz, model.damping_ratio).T
        place = (frequency_hz - known.middle_hz) / known.reach_hz
        left = np.concatenate([np.ones((1, len(place))), place[None], bare[: model.n_free]])
        ends = [left * (stretch == each) for each in np.unique(stretch)]
        beside = np.concatenate([inputs, inputs * place, *ends])
        return cls(inputs, values, bare * driven[: len(bare)], beside)

    def without(self, rows: Complex) -> Complex:
        """Return rows of values at all lines without what can be of D or the ends."""
        share = np.linalg.lstsq(self.beside.T, rows.T, rcond=RCOND)[0]
        return np.asarray(rows - share.T @ self.beside)
