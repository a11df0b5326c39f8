"""Shapes in all channels, and their errors, from the fit of a band in few combinations of them.

The fit tells how the modes moved, frequency by frequency; what the other combinations of the
channels hold is regressed on that motion.  To first order this is the maximum of the likelihood
in all channels: across the shapes of all modes the noise is white, and along the shapes of the
modes beside the band it is their tails.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from oma_identifier.likelihood import (
    accelerance,
    averaged_blocks,
    BandFit,
    BandIndex,
    expected_motion,
    force_colour,
    GroupFit,
    LIKELIHOOD,
    ModeIndex,
    parts_along,
    ReducedBand,
    Spectra,
    StartModes,
    TailData,
)

TINY = 1e-300

Real = NDArray[np.float64]
Complex = NDArray[np.complex128]


@dataclass(frozen=True, slots=True)
class ShapeEstimate:
    """One mode shape.

    Parameters
    ----------
    shape : (n_channels,) complex array
        In any scale.
    scatter : (n_channels, n_directions) complex array
        Its errors along independent directions, of one standard deviation each.
    """

    shape: Complex
    scatter: Complex


@dataclass(frozen=True, slots=True)
class _Outside:
    """What the scaled shapes hold outside the combinations that were fitted.

    Parameters
    ----------
    parts : (n_channels, n_free) complex array
        Estimates.
    scatter : (n_free, n_channels, n_directions) complex array
        Their errors that have nothing to do with those inside.
    mixing : (n_free, n_channels, n_free) complex array
        Their errors by the shares of the modes that the shapes inside hold too much of.
    """

    parts: Complex
    scatter: Complex
    mixing: Complex


class WholeShapes:
    """Shapes of the modes of one record, made when asked for.

    Parameters
    ----------
    spectra : Spectra
        Of the record.
    now : StartModes
        All modes as refined.

    References
    ----------
    Au (2017), doi:10.1007/978-981-10-4118-1, chapter 12.
    """

    def __init__(self, spectra: Spectra, now: StartModes) -> None:
        self._spectra, self._now = spectra, now
        self._known: dict[ModeIndex, list[ShapeEstimate]] = {}

    def of(self, each: GroupFit, position: BandIndex) -> ShapeEstimate:
        """Return the shape of one mode of a group that was fitted."""
        if each.band is None or each.fit is None:
            raise ValueError('a group that was not fitted has no shapes')
        if (first := each.group[0]) not in self._known:
            self._known[first] = _estimates(
                self._spectra, self._now, each.group, each.band, each.fit
            )
        return self._known[first][position]


def _estimates(
    spectra: Spectra, now: StartModes, group: list[ModeIndex], band: ReducedBand, fit: BandFit
) -> list[ShapeEstimate]:
    inside, errors = fit.model.shapes[:, : len(group)], fit.shape_scatter
    shapes, scatter = band.basis @ inside, band.basis @ errors
    if not band.is_whole:
        outside = _outside(spectra, now, group, band, fit)
        shapes = shapes + outside.parts
        # Modes mistaken for one another inside are so outside.
        mixed = outside.mixing @ (np.linalg.pinv(inside, rcond=LIKELIHOOD.separable) @ errors)
        scatter = np.concatenate([scatter + mixed, outside.scatter], axis=2)
    return [
        ShapeEstimate(shape / band.scale, error / band.scale[:, None])
        for shape, error in zip(shapes.T, scatter, strict=True)
    ]


def _outside(
    spectra: Spectra, now: StartModes, group: list[ModeIndex], band: ReducedBand, fit: BandFit
) -> _Outside:
    n_own = len(group)
    others = [mode for mode in now.indices() if mode not in group]
    n_reduced = band.basis.shape[1]
    kept = np.concatenate([band.basis, band.blocked], axis=1) * band.scale[:, None]
    reduced, blocked = np.split(spectra.combined(kept, band.lines), [n_reduced])
    motion, blocked = _motion(band, fit, reduced), _undriven(band, blocked)
    beside = _Beside.of(band, now.shapes[:, others])
    # Across the shapes of all others there is nothing but the modes of the band, and noise.
    known = np.concatenate([band.basis, beside.directions], axis=1)
    across = np.eye(len(known)) - known @ known.conj().T
    moment = motion @ motion.conj().T
    inverse = np.linalg.pinv(moment, hermitian=True)
    rest = across @ (band.scale[:, None] * _products(spectra, band, motion)) @ inverse
    noise = _noise(band, fit, rest, moment)
    deviation = np.sqrt(0.5 * noise * np.diag(inverse).real[:n_own])
    half = deviation[:, None, None] * across
    shapes, scatter = rest[:, :n_own], np.concatenate([half, 1j * half], axis=2)
    if beside.directions.shape[1]:
        tails = _tail_data(
            band,
            fit,
            np.concatenate([motion[:n_own], beside.dual @ blocked]),
            accelerance(
                band.data.frequency_hz, now.frequency_hz[others], now.damping_ratio[others]
            ),
        )
        along = parts_along(tails)
        shapes = shapes + beside.shapes @ along.parts
        scatter = np.concatenate([scatter, beside.shapes @ along.scatter], axis=2)
        return _Outside(shapes, scatter, shapes + beside.shapes @ along.by_mixing)
    return _Outside(shapes, scatter, np.broadcast_to(shapes, (n_own, *shapes.shape)))


def _motion(band: ReducedBand, fit: BandFit, reduced: Complex) -> Complex:
    """Return how all modes moved, without what no regression on it may hold."""
    known = band.motion
    if known is None:
        return expected_motion(band.data, fit.model, reduced)
    left = reduced - known.values.T
    return known.without(known.modes + expected_motion(band.data, fit.model, left))


def _undriven(band: ReducedBand, values: Complex) -> Complex:
    return values if band.motion is None else band.motion.without(values)


def _products(spectra: Spectra, band: ReducedBand, motion: Complex) -> Complex:
    """Return the products of all channels with the complex conjugate motions, summed.

    Two real products of matrices: half as much work as a complex one.
    """
    total = np.zeros((len(spectra.values), len(motion)), dtype=complex)
    for here, parts in spectra.parts(band.lines):
        own = np.ascontiguousarray(motion[:, here])
        total += parts @ own.view(np.float64).T
        total += 1j * (parts @ (1j * own).view(np.float64).T)
    return total


@dataclass(frozen=True, slots=True)
class _Beside:
    """The modes beside a band, where they were projected out.

    Parameters
    ----------
    shapes : (n_channels, n_tails) complex array
        In scaled channels.
    directions : (n_channels, n_directions) complex array
        Orthonormal basis of them.
    dual : (n_tails, n_blocked) complex array
        What makes their coordinates of the combinations that were projected out.
    """

    shapes: Complex
    directions: Complex
    dual: Complex

    @classmethod
    def of(cls, band: ReducedBand, shapes: Complex) -> '_Beside':
        inside = band.blocked.T @ (band.scale[:, None] * shapes)
        inside /= np.maximum(np.linalg.norm(inside, axis=0), TINY)
        left, values, right = np.linalg.svd(inside, full_matrices=False)
        kept = values > LIKELIHOOD.separable * values.max(initial=0.0)
        dual = (right[kept].conj().T / values[kept]) @ left[:, kept].conj().T
        return cls(band.blocked @ inside, band.blocked @ left[:, kept], dual)


def _noise(band: ReducedBand, fit: BandFit, rest: Complex, moment: Complex) -> float:
    """Return the power of the noise of each scaled channel, from what no mode explains."""
    if not band.n_noise:
        return float(fit.model.noise.mean())
    free = rest - band.blocked @ (band.blocked.T @ rest)
    explained = np.einsum('ca,ab,cb->', free, moment, free.conj()).real
    return float(max(band.noise_power - explained / band.n_noise, 0.0))


def _tail_data(band: ReducedBand, fit: BandFit, values: Complex, tail: Complex) -> TailData:
    """Return the averages for the regression of the tails.

    Parameters
    ----------
    values : (n_own + n_tails, n_lines) complex array
        Motions of the own modes and coordinates of the tails.
    tail : (n_averages, n_tails) complex array
        Accelerance.
    """
    data, model = band.data, fit.model
    n_own = model.n_free
    natural, damping = model.frequency_hz[:n_own], model.damping_ratio[:n_own]
    beta = natural / data.frequency_hz[:, None]
    by_damping = -2j * damping * beta * fit.damping_ratio_std
    by_frequency = (-2j * damping * beta - 2.0 * beta**2) * fit.frequency_std
    level = force_colour(data, model)
    blocks = averaged_blocks(data, values)
    moment = np.stack([block @ block.conj().T for block in blocks], axis=-1)
    return TailData(
        data.n_averaged,
        np.asarray(moment / data.n_averaged),
        accelerance(data.frequency_hz, natural, damping).T * level,
        np.asarray(np.stack([by_frequency.T, by_damping.T]) / level, dtype=complex),
        tail.T * level,
    )
