"""The shape of a mode in a set-up that did not show it, read out of its covariances.

Other set-ups tell the pole of the mode and its shape at the references.  Half spectra of all
channels with the references are a sum of the poles of all modes; near the pole they are regressed
on them, and what belongs to the pole is a product of the shape with what the references take part
in it.  That is the second step of PreGER with the poles of all set-ups.

References
----------
Döhler, Lam and Mevel (2013), doi:10.1016/j.ymssp.2012.10.018, section 3; Guillaume et al. (2003),
A poly-reference implementation of the least-squares complex frequency-domain estimator, IMAC XXI
(regression on known poles).
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
import math

import numpy as np
from numpy.typing import NDArray

from modal_core.mode import Mode
from modal_core.samples import Samples
from oma_identifier.compare.joined_shape import PartialShape
from oma_identifier.compare.thresholds import COMPARISON
from oma_identifier.covariance import Band, BandConditioner, plan_bands
from oma_identifier.methods import half_spectra, LagSums
from oma_identifier.settings import IdentificationSettings

LAGS = 1024
N_BLOCKS = 20
N_SMOOTH = 3
"""Widths of that stretch from which on other poles are smooth in it: parabolas leave 1 % of them.
"""

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]


@dataclass(frozen=True, slots=True)
class _Rows:
    """One band of a set-up.

    Parameters
    ----------
    band : Band
        Which.
    sums : LagSums
        Of its rows, each scaled to a root mean square of 1.
    n_rows : int
        How many.
    scale : (n_channels,) array
        Root mean squares before.
    """

    band: Band
    sums: LagSums
    n_rows: int
    scale: Array

    def parts(self) -> Iterator[tuple[int, int] | None]:
        """Yield nothing, then each stretch to be left out in turn."""
        yield None
        edges = np.linspace(0, self.n_rows, N_BLOCKS + 1).round().astype(int)
        yield from ((int(first), int(last)) for first, last in pairwise(edges))


def shapes_at_poles(
    samples: Samples, references: Sequence[str], modes: Sequence[Mode], wanted: Sequence[Mode]
) -> list[PartialShape | None]:
    """Return what a set-up tells of shapes whose poles are known.

    Parameters
    ----------
    samples : Samples
        Of the set-up.
    references : sequence of str
        Channels of the samples.
    modes : sequence of Mode
        That the set-up shows.
    wanted : sequence of Mode
        That it does not; their shapes are those of the references.

    Returns
    -------
    list of PartialShape or None
        Rows are columns of the samples; None where the references do not respond as they should,
        or where only one could.
    """
    if len(references) < 2:
        return [None] * len(wanted)
    places = np.array([samples.channel_names.index(name) for name in references])
    found: list[PartialShape | None] = [None] * len(wanted)
    for rows in _bands(samples, places):
        inside = [
            index
            for index, mode in enumerate(wanted)
            if rows.band.low_hz <= mode.frequency_hz < rows.band.high_hz
        ]
        if not inside:
            continue
        covariances = [rows.sums.covariance(left_out) for left_out in rows.parts()]
        for index in inside:
            beside = [*modes, *(mode for other, mode in enumerate(wanted) if other != index)]
            residues = np.array(
                [_residue(each, rows.band, wanted[index], beside) for each in covariances]
            )
            found[index] = _shape(residues, places, wanted[index].shape, rows.scale)
    return found


def _bands(samples: Samples, references: NDArray[np.intp]) -> Iterator[_Rows]:
    settings = IdentificationSettings()
    for band in plan_bands(samples.sample_rate_hz, samples.duration_s, settings):
        rows = BandConditioner(band).condition(samples.acceleration)
        n_lags = min(LAGS, len(rows) // N_BLOCKS)
        if n_lags < COMPARISON.fewest_lines:
            continue
        scale = rows.std(axis=0)
        rows = np.divide(rows, scale, out=np.zeros_like(rows), where=scale > 0.0)
        yield _Rows(band, LagSums(rows, references, n_lags), len(rows), scale)


def _residue(covariance: Array, band: Band, mode: Mode, others: Sequence[Mode]) -> Complex:
    """Return the matrix of a pole, (n_channels, n_references)."""
    rate = band.sample_rate_hz
    spectra = half_spectra(covariance, 0.0, 0.5)
    pole = _pole(mode, rate)
    width = -pole.real + spectra.decay
    apart = np.abs(spectra.angle - abs(pole))
    near = apart <= max(COMPARISON.pole_reach * width, np.sort(apart)[COMPARISON.fewest_lines])
    angle, value = spectra.angle[near], spectra.value[near]
    reach = COMPARISON.far_pole * float(np.ptp(angle))
    beside = [_pole(other, rate) for other in others]
    poles = [pole, *(p for p in beside if abs(abs(p) - abs(pole)) < reach)]
    point = np.exp(1j * angle + spectra.decay)[:, None]
    step = np.exp(np.array(poles))
    # What is farther away is smooth here.
    smooth = np.vander((angle - angle.mean()) / np.ptp(angle), N_SMOOTH)
    basis = np.concatenate([step / (point - step), smooth], axis=1)
    parts = np.linalg.lstsq(basis, value.reshape(len(angle), -1), rcond=None)[0]
    return np.asarray(parts[0].reshape(value.shape[1:]))


def _pole(mode: Mode, rate_hz: float) -> complex:
    damping = mode.damping_ratio
    turn = 2.0 * math.pi * mode.frequency_hz / rate_hz
    return turn * complex(-damping, math.sqrt(1.0 - damping**2))


def _shape(
    residues: Complex, references: NDArray[np.intp], known: Complex, scale: Array
) -> PartialShape | None:
    """Return a shape from the matrices of its pole, the first of all data, the others of parts."""
    known = known / scale[references]
    takes_part = np.einsum('r,brs->bs', known.conj(), residues[:, references]) / np.vdot(
        known, known
    )
    if (
        np.sum(np.abs(takes_part[0]) ** 2)
        < COMPARISON.present**2 * _variance(takes_part[1:]).sum()
    ):
        return None
    power = np.sum(np.abs(takes_part) ** 2, axis=1)
    shapes = np.einsum('bcs,bs->bc', residues, takes_part.conj()) / power[:, None]
    variance = _variance(shapes[1:])
    off = np.abs(shapes[0, references] - known) ** 2
    if np.sum(off / variance[references]) > COMPARISON.largest_misfit * (len(references) - 1):
        return None
    return PartialShape(np.arange(len(scale)), shapes[0] * scale, variance * scale**2)


def _variance(parts: Complex) -> Array:
    """Return the variance from estimates that leave out one stretch each (jackknife)."""
    return np.asarray(
        (len(parts) - 1.0) * np.mean(np.abs(parts - parts.mean(axis=0)) ** 2, axis=0)
    )
