"""Lines of machines: the same frequency everywhere, amplitude and phase free in every record."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from modal_core.channel import AXES, Channel
from model_gap.joint_vector import joint_vector
from model_gap.pose_system import PoseSystem
from model_gap.setup import Tone
from model_gap.spectra import RecordSpectra
from structural_model import FlexibleJointModel

Complex = NDArray[np.complex128]


def hann_line(offset_bins: NDArray[np.float64]) -> Complex:
    """Return the spectrum of a unit line under a Hann window, at offsets in bins.

    Source: the Dirichlet kernel for a long record, combined as in ``spectra.HANN``.
    """

    def kernel(offset: NDArray[np.float64]) -> Complex:
        return np.asarray(np.exp(-1j * np.pi * offset) * np.sinc(offset))

    return np.asarray(
        0.5 * kernel(offset_bins)
        - 0.25 * kernel(offset_bins - 1.0)
        - 0.25 * kernel(offset_bins + 1.0)
    )


def add_tones(
    tones: Sequence[Tone],
    records: Sequence[RecordSpectra],
    groups: Sequence[int],
    systems: Sequence[PoseSystem],
    model: FlexibleJointModel,
    predicted: Sequence[Complex],
) -> list[Complex]:
    """Add to every record the line that fits its residual best, one complex amplitude each."""
    found = []
    for item, group, reading in zip(records, groups, predicted, strict=True):
        for tone in tones:
            reading = reading + _line(tone, item, systems[group], model, reading)
        found.append(reading)
    return found


def _line(
    tone: Tone,
    item: RecordSpectra,
    system: PoseSystem,
    model: FlexibleJointModel,
    reading: Complex,
) -> Complex:
    omega = 2.0 * np.pi * tone.frequency_hz
    width = float(item.omega[0, 1] - item.omega[0, 0])
    line = hann_line((item.omega[:, 1] - omega) / width)
    pushes = _pushes(tone, item, system, model)
    motion = system.deflection(np.full(pushes.shape[1], omega), pushes.astype(complex))
    still = np.zeros((system.rigid.shape[1], pushes.shape[1]), dtype=complex)
    shapes = system.reading(np.full(pushes.shape[1], omega), motion, still, still)
    scale = 1.0 / np.sqrt(item.noise_power)
    patterns = np.array([((shape[:, None] * line) * scale).ravel() for shape in shapes.T]).T
    rest = ((item.measured - reading) * scale).ravel()
    gram = patterns.conj().T @ patterns
    size = float(np.trace(gram).real)
    if size <= 0.0:
        return np.zeros_like(reading)
    gram[np.diag_indices_from(gram)] += 1e-9 * size
    amplitude = np.linalg.solve(gram, patterns.conj().T @ rest)
    return np.asarray((patterns @ amplitude).reshape(reading.shape) / scale)


def _pushes(
    tone: Tone, item: RecordSpectra, system: PoseSystem, model: FlexibleJointModel
) -> NDArray[np.float64]:
    """Return unit loads on the degrees of freedom as columns."""
    if not tone.force:
        return joint_vector(model, tone.place, system.dof_names)[:, None]
    axes = tuple(
        Channel(f'{tone.place}.{axis}', tone.place, direction) for axis, direction in AXES.items()
    )
    rows = model.sensor_jacobian(item.record.pose, axes)
    if rows.shape[1] == len(system.dof_names):
        return np.asarray(rows.T)
    full = np.zeros((len(system.dof_names), 3))  # effects may have added degrees of freedom
    for column, name in enumerate(model.dof_names):
        full[system.dof_names.index(name)] = rows[:, column]
    return full
