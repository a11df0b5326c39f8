"""Shapes of strong modes that a list of modes lacks.

A likelihood of listed modes is biased by what they leave unexplained.  Where channels outnumber
modes, what is left after projecting out all listed shapes shows where an unlisted mode resonates,
and the channels there show its shape.
"""

import numpy as np
from numpy.typing import NDArray

from oma_identifier.likelihood import Spectra, StartModes

MOST_UNLISTED = 4
STANDS_OUT = 10.0
"""Largest over median singular value of the residual spectrum, as powers."""
LINES = 8
VALUES_AT_ONCE = 1 << 21
ASSUMED_DAMPING = 0.02
SHAPE_ERROR = 0.02
"""Share of the power at a listed mode's peak that an error of its shape may leave."""


def with_unlisted(spectra: Spectra, start: StartModes, usable: NDArray[np.bool_]) -> StartModes:
    """Return the modes followed by stand-ins for strong modes that are missing.

    They are rough and want refining with the others.
    """
    lines = np.flatnonzero(usable)
    values = spectra.at(lines)
    parts = [values[:, here] for here in spectra.stretches(len(lines))]
    plain = _products(values).astype(complex) / len(lines)
    power = np.diag(plain).real
    frequency, damping, shapes = start.frequency_hz, start.damping_ratio, start.shapes
    scale = 1.0 / np.sqrt(power)
    explained = shapes * scale[:, None]
    scaled_covariance = plain * np.outer(scale, scale)
    for _ in range(MOST_UNLISTED):
        n_channels, n_explained = explained.shape
        if n_channels < 2 * n_explained:
            break
        basis = np.linalg.svd(explained, full_matrices=True)[0][:, n_explained:].conj()
        # The whole spectrum at once: one strong direction of the residual is one mode.
        levels, vectors = np.linalg.eigh(basis.conj().T @ scaled_covariance @ basis)
        if levels[-1] < STANDS_OUT * np.median(levels):
            break
        weight = scale * (basis @ vectors[:, -1])
        track = np.abs(np.concatenate([weight @ part for part in parts])) ** 2
        smooth = np.convolve(track, np.full(LINES, 1.0 / LINES), mode='same')
        peak = int(np.argmax(smooth))
        at = spectra.frequency_hz[lines[peak]]
        near = values[:, max(0, peak - LINES) : peak + LINES + 1].T * scale
        listed = np.any(np.abs(frequency - at) < damping * frequency)
        if listed and smooth[peak] < SHAPE_ERROR * np.mean(np.sum(np.abs(near) ** 2, axis=1)):
            explained = np.column_stack([explained, basis.conj() @ vectors[:, -1].conj()])
            continue
        scaled = np.linalg.eigh(near.T @ near.conj())[1][:, -1]
        explained = np.column_stack([explained, scaled])
        shape = scaled / scale
        shapes = np.column_stack([shapes, shape / np.linalg.norm(shape)])
        frequency = np.append(frequency, at)
        damping = np.append(damping, ASSUMED_DAMPING)
    return StartModes(frequency, damping, shapes)


def _products(values: NDArray[np.complex64]) -> NDArray[np.complex64]:
    """Return the products of the channels' conjugate values with one another, summed."""
    at_once = VALUES_AT_ONCE // len(values)
    parts = (values[:, i : i + at_once] for i in range(0, values.shape[1], at_once))
    return np.asarray(sum(part.conj() @ part.T for part in parts))
