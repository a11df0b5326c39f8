"""Few forces drive many modes: how many they are, and where the fit of their spectra begins.

The cross spectral density of the modal forces then has a low rank, S = L Lᴴ with a column of L
for each force.  The tails of all modes are coherent with one another, and stay in the model of a
band: what is projected out, or left out, would not be noise.

References
----------
Dempster, Laird, Rubin (1977), doi:10.1111/j.2517-6161.1977.tb01600.x (expectation-maximisation);
Marchenko and Pastur (1967), doi:10.1070/SM1967v001n04ABEH001994 (eigenvalues of noise).
"""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from oma_identifier.likelihood.band_model import (
    BandData,
    BandModel,
    forced_gain,
    with_root,
)
from oma_identifier.likelihood.thresholds import LIKELIHOOD

EM_STEPS = 6
"""From uncorrelated forces to a root that scoring starts from."""
LEAST_SHARE = 1e-6
"""Of a mode's force, that each column of the root has at least."""
FAR, FAR_DAMPING = (0.1, 10.0), 0.01
"""Frequency of residuals over that of their band: what one does is alike within 2 % over an
octave."""

Real = NDArray[np.float64]
Complex = NDArray[np.complex128]


def count_forces(values: Complex) -> int:
    """Return how many forces the lines around a mode show; 0 where too few lines tell.

    Neighbouring lines hold as many independent motions as there are forces, however many modes
    these drive.  Where the response turns within a block the count is too high, which costs time
    alone.

    Parameters
    ----------
    values : (n_lines, n_channels) complex array
        Transforms at these lines.
    """
    n_lines, n_channels = values.shape
    length = 2 * n_channels
    n_blocks = n_lines // length
    if n_blocks < 1 or n_channels < 3:
        return 0
    blocks = values[: n_blocks * length].reshape(n_blocks, length, n_channels)
    covariance = blocks.transpose(0, 2, 1) @ blocks.conj() / length
    ridge = 1e-12 * np.einsum('bcc->b', covariance).real / n_channels
    covariance += ridge[:, None, None] * np.eye(n_channels)
    inverse = np.linalg.inv(covariance)
    # What the other channels do not explain is noise where forces are fewer than channels.
    noise = 1.0 / np.einsum('bcc->bc', inverse).real * length / (length - n_channels + 1)
    scale = 1.0 / np.sqrt(np.quantile(noise, LIKELIHOOD.quiet_blocks, axis=0))
    whitened = covariance * np.outer(scale, scale)
    edge = LIKELIHOOD.common_power[0] * (1.0 + np.sqrt(n_channels / length)) ** 2
    count = np.count_nonzero(np.linalg.eigvalsh(whitened) > edge, axis=1)
    return int(np.ceil(np.quantile(count, LIKELIHOOD.turning_blocks)))


def under_few_forces(data: BandData, model: BandModel, n_forces: int) -> BandModel:
    """Return a model under the few forces that the data suggest."""
    return with_root(model, root_of(_expected(data, model), n_forces))


def with_residuals(model: BandModel) -> BandModel:
    """Return a model whose forces move every channel beside the modes as well.

    As modes far below do, by accelerations alike at all frequencies, and as those far above, by
    displacements alike.
    """
    n = len(model.shapes)
    power = np.mean(np.diag(model.force).real[: model.n_free])
    ratio = np.repeat(FAR, n)
    # About as much as a mode does beside its peak.
    force = np.append(np.diag(model.force), power * np.maximum(1.0, ratio**4))
    return replace(
        model,
        frequency_hz=np.append(model.frequency_hz, ratio * model.reference_hz),
        damping_ratio=np.append(model.damping_ratio, np.full(len(ratio), FAR_DAMPING)),
        shapes=np.concatenate([model.shapes, *[np.eye(n)] * len(FAR)], axis=1),
        force=np.diag(force).astype(complex),
    )


def _expected(data: BandData, model: BandModel) -> Complex:
    """Return the force after a few steps of expectation and maximisation, always a covariance."""
    amplitude = model.shapes * forced_gain(data, model)[:, None, :]
    adjoint = amplitude.conj().transpose(0, 2, 1)
    force, noise = model.force, np.diag(model.noise)
    weight = data.n_averaged / data.n_averaged.sum()
    for _ in range(EM_STEPS):
        covariance = amplitude @ force @ adjoint + noise
        gain = np.linalg.solve(covariance, amplitude @ force).conj().transpose(0, 2, 1)
        seen = gain @ data.periodogram @ gain.conj().transpose(0, 2, 1)
        every = force - gain @ amplitude @ force + seen
        force = np.tensordot(weight, every, axes=1)
        force = 0.5 * (force + force.conj().T)
    return np.asarray(force)


def root_of(force: Complex, n_forces: int) -> Complex:
    """Return the root of the strongest part of a force, (n_modes, n_forces)."""
    level = np.sqrt(np.maximum(np.diag(force).real, 1e-300))
    power, directions = np.linalg.eigh(force / np.outer(level, level))
    power = np.maximum(power[::-1][:n_forces], LEAST_SHARE)
    return np.asarray(level[:, None] * directions[:, ::-1][:, :n_forces] * np.sqrt(power))


def turns(root: Complex) -> Real:
    """Return the changes of a root that leave the force as it is, orthonormal columns.

    Rows are real and imaginary parts of the root's entries in turn.
    """
    n_forces = root.shape[1]
    first, second = np.triu_indices(n_forces)
    skew = np.zeros((2, len(first), n_forces, n_forces), dtype=complex)
    each = np.arange(len(first))
    skew[0, each, first, second] = skew[0, each, second, first] = 1j
    off = np.flatnonzero(first != second)
    skew[1, off, first[off], second[off]], skew[1, off, second[off], first[off]] = 1.0, -1.0
    every = root @ np.concatenate([skew[0], skew[1, off]])
    columns = np.stack([every.real, every.imag], axis=-1).reshape(len(every), -1)
    return np.asarray(np.linalg.qr(columns.T)[0])
