"""What modes beside a band do in it: channels without them, or tails in its model."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from oma_identifier.likelihood.band_model import accelerance
from oma_identifier.likelihood.indices import ModeIndex
from oma_identifier.likelihood.line_spectra import Spectra
from oma_identifier.likelihood.mode_groups import StartModes
from oma_identifier.likelihood.thresholds import LIKELIHOOD

PEAK_LINES = 9

Real = NDArray[np.float64]
Complex = NDArray[np.complex128]


def unit_columns(shapes: Complex) -> Complex:
    """Return shapes, one per column, of unit length."""
    return np.asarray(shapes / np.linalg.norm(shapes, axis=0))


@dataclass(frozen=True, slots=True)
class Subspaces:
    """Orthonormal bases along and across the shapes of some modes; what a mode shows there.

    Parameters
    ----------
    blocked, free : (n_channels, n) array
        Along and across the shapes.
    tails : list of int
        Modes beside the band of which more than noise is left across.
    planes : bool
        Across, complex shapes are described as well: each in a plane, not along a line.
    """

    blocked: Real
    free: Real
    tails: list[ModeIndex]
    planes: bool = False


def split_channels(
    spectra: Spectra,
    start: StartModes,
    group: list[ModeIndex],
    scale: Real,
    ends_hz: Real,
    *,
    reduce: bool,
    few_forces: bool = False,
) -> Subspaces:
    """Return what the channels see along and across the modes beside a band.

    Parameters
    ----------
    spectra : Spectra
        Of all channels.
    start : StartModes
        All modes.
    group : list of ModeIndex
        Those of the band.
    scale : (n_channels,) array
        That makes the noise of all channels equal.
    ends_hz : (2,) array [Hz]
        Of the band.
    few_forces : bool
        Whether all modes are coherent: then all are tails.
    reduce : bool
        Whether there are channels enough to project other modes out; else all are tails.
    """
    others = [mode for mode in start.indices() if mode not in group]
    if few_forces:
        tails = _largest(spectra, start, group, others, LIKELIHOOD.most_coherent)
        return Subspaces(np.empty((len(scale), 0)), np.eye(len(scale)), tails)
    apart = _apart(spectra, start, group, others, scale, ends_hz) if others and reduce else None
    if apart is not None:
        return apart
    tails = _largest(spectra, start, group, others, LIKELIHOOD.most_tails)
    return Subspaces(np.empty((len(scale), 0)), np.eye(len(scale)), tails)


def _apart(
    spectra: Spectra,
    start: StartModes,
    group: list[ModeIndex],
    others: list[ModeIndex],
    scale: Real,
    ends_hz: Real,
) -> Subspaces | None:
    """Return bases along and across the shapes of the others; None where that is not the way.

    The imaginary part of a shape is another direction.  It is projected out where it stands out
    of the noise, unless the modes of the group would not be seen any more: the imaginary parts
    of a structure with uneven damping lie along the shapes of its other modes.  What is left of
    them then is for the model.
    """
    shapes = unit_columns(start.shapes * scale[:, None])
    by_length = np.full(len(others), 1.0 / LIKELIHOOD.least_part)
    over_noise = _tails(spectra, start, others, scale, ends_hz)
    by_noise = np.maximum(over_noise / LIKELIHOOD.least_tail, by_length)
    for planes, weight in ((True, by_noise), (False, by_length)):
        weighted = shapes[:, others] * weight
        blocked = np.concatenate([weighted.real, weighted.imag], axis=1)
        left, values, _ = np.linalg.svd(blocked, full_matrices=True)
        rank = int(np.count_nonzero(values > 1.0))
        free = left[:, rank:]
        if free.shape[1] >= len(group) + 2:
            visible = np.linalg.svd(free.T @ shapes[:, group], compute_uv=False)
            if visible[-1] > LIKELIHOOD.least_visible:
                remainder = over_noise * np.linalg.norm(free.T @ shapes[:, others], axis=0)
                largest = np.argsort(-remainder)[: LIKELIHOOD.most_remainders]
                strong = remainder[largest] > LIKELIHOOD.least_remainder
                tails = [others[at] for at in largest[strong]]
                return Subspaces(left[:, :rank], free, tails, planes)
    return None


def _tails(
    spectra: Spectra, start: StartModes, modes: list[ModeIndex], scale: Real, ends_hz: Real
) -> Real:
    """Return the amplitudes of modes beside a band, at the end nearer to each, over the noise.

    From a few lines at the peak of each: their order of magnitude is enough.
    """
    frequency, damping = start.frequency_hz[modes], start.damping_ratio[modes]
    places = frequency + np.linspace(-1.0, 1.0, PEAK_LINES)[:, None] * damping * frequency
    lines = np.searchsorted(spectra.frequency_hz, places - 0.5 * spectra.spacing_hz)
    lines = np.clip(lines, 1, len(spectra.frequency_hz) - 1)
    near = spectra.values[:, lines]
    shapes = unit_columns(start.shapes[:, modes] * scale[:, None])
    response = np.einsum('cm,clm->lm', scale[:, None] * shapes.conj(), near)
    beta = frequency / spectra.frequency_hz[lines]
    level = np.mean(np.abs(response * (1.0 - beta**2 - 2j * damping * beta)) ** 2, axis=0)
    gain = np.abs(accelerance(ends_hz, frequency, damping)).max(axis=0)
    return np.asarray(np.sqrt(level) * gain)


def _largest(
    spectra: Spectra, start: StartModes, group: list[ModeIndex], others: list[ModeIndex], most: int
) -> list[ModeIndex]:
    """Return the modes that reach furthest into the band of a group."""
    if len(others) <= most:
        return others
    centre = start.frequency_hz[group].mean()
    level = force_levels(spectra, start, others, np.ones(len(start.shapes)), None)
    frequency, damping = start.frequency_hz[others], start.damping_ratio[others]
    tail = level * np.abs(accelerance(np.array([centre]), frequency, damping)[0]) ** 2
    return [others[index] for index in np.sort(np.argsort(tail)[::-1][:most])]


def force_levels(
    spectra: Spectra,
    start: StartModes,
    modes: list[ModeIndex],
    scale: Real,
    projector: Real | None,
) -> Real:
    """Return the force density that each mode's own peak suggests, for its projected shape."""
    levels = np.empty(len(modes))
    shapes = start.shapes * scale[:, None]
    shapes = unit_columns(shapes)
    if projector is not None:
        shapes = projector @ shapes
    for index, mode in enumerate(modes):
        width = max(start.half_width_hz[mode], 2.0 * spectra.spacing_hz)
        near = spectra.near(start.frequency_hz[mode], width)
        shape = shapes[:, mode]
        length = np.linalg.norm(shape)
        response = spectra.along(scale * shape.conj(), near) / length
        gain = accelerance(
            spectra.frequency_hz[near], start.frequency_hz[[mode]], start.damping_ratio[[mode]]
        )
        levels[index] = np.mean(np.abs(response[:, None] / gain) ** 2)
    return levels
