"""Take the second-order part of the motion out of recordings, for comparison with linear arms.

An arm that shakes turns its inertia and its load of gravity along: a percent of the response at
the accelerations an excitation has.  To second order this part follows from the linear motion:
x = x₁ + x₂ with x₁ the linear response and M x₂'' + C x₂' + K x₂ the force that the linear model
misses along x₁.  It hardly depends on what is fitted, and is computed for one cell of the arm;
torques of its joints that are not linear are those that the recording shows.

References
----------
Nayfeh and Mook (1979), Nonlinear Oscillations, ISBN 0-471-03555-6, sec. 2.3 (straightforward
expansion).
"""

from collections.abc import Sequence
import dataclasses

import numpy as np
from numpy.typing import NDArray

from model_gap.campaign import Band, GapRecord, record_spectra
from model_gap.cell import CellModel, joint_vector, pose_system, PoseSystem, sag
from model_gap.laws import Follow
from model_gap.predict.followed import free_torques, measured_share
from structural_model import FlexibleJointModel
from structural_model.remainder import remainder

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]


def linearised(
    records: Sequence[GapRecord], model: FlexibleJointModel, cell: CellModel, high_hz: float
) -> list[GapRecord]:
    """Return records less the second-order response of an arm.

    Parameters
    ----------
    records : sequence of GapRecord
        As measured.
    model : FlexibleJointModel
        Gives kinematics.
    cell : CellModel
        The arm, its sensors and what changes its input.
    high_hz : float [Hz]
        Slower motion counts; products of two such that fall below are right.
    """
    arm = dataclasses.replace(model, spec=cell.spec)
    found = []
    for record in records:
        system = pose_system(arm, record.pose, cell.channels)
        extra = second_order(record, arm, cell, system, high_hz)
        found.append(dataclasses.replace(record, acceleration=record.acceleration - extra))
    return found


def second_order(
    record: GapRecord,
    model: FlexibleJointModel,
    cell: CellModel,
    system: PoseSystem,
    high_hz: float,
) -> Array:
    """Return the reading of the second-order motion, (n_samples, n_channels) [m/s²]."""
    count, rate_hz = record.acceleration.shape[0], record.sample_rate_hz
    steps = round(count / rate_hz * 3.0 * high_hz)  # sums of two frequencies fold above the band
    series = _Series(count, steps, rate_hz, high_hz)
    shift = series.spectrum(record.motor_shift)
    acceleration = series.spectrum(record.motor_acceleration)
    acceleration, shift = cell.driven(series.omega, acceleration, shift)
    turn = 1j * series.omega
    push = system.force(acceleration, shift)
    if cell.forces:
        push = push - shown_torques(record, model, cell, system)[:, : len(series.omega)]
    flexible = system.deflection(series.omega, push)
    rest = sag(model, record.pose, hanging=True)
    force, reading = remainder(
        model.dynamics,
        record.pose,
        rest,
        (series.back(shift), series.back(turn * shift), series.back(acceleration)),
        (series.back(flexible), series.back(turn * flexible), series.back(turn**2 * flexible)),
        cell.channels,
    )
    second = system.deflection(series.omega, series.forward(force))
    moved = system.flexible @ (turn**2 * second) + system.gravity @ second
    return series.fine(cell.seen(series.omega, series.forward(reading) + moved))


def shown_torques(
    record: GapRecord, model: FlexibleJointModel, cell: CellModel, system: PoseSystem
) -> Complex:
    """Return the load on the deflections that joints with a law of their own show, (n_dof, n)."""
    joints = dict.fromkeys(force.joint for force in cell.forces)
    places = [joint_vector(model, joint, system.dof_names) for joint in joints]
    item = record_spectra(record, Band())
    torques, _ = free_torques(item, system, places, cell)
    return np.asarray(
        np.array(places).T @ (torques * measured_share(item.long_motion[0], Follow.MEASURED))
    )


@dataclasses.dataclass(frozen=True)
class _Series:
    """Between a record and a coarse grid, by spectra of twice the length: nothing wraps around."""

    count: int
    steps: int
    rate_hz: float
    high_hz: float

    @property
    def omega(self) -> Array:
        frequency = np.fft.rfftfreq(2 * self.count, 1.0 / self.rate_hz)
        return np.asarray(2.0 * np.pi * frequency[frequency <= self.high_hz])

    def spectrum(self, values: Array) -> Complex:
        """Return the spectrum of a series on the record's grid, (n, n_omega)."""
        return np.asarray(np.fft.rfft(values, 2 * self.count, axis=0)[: len(self.omega)].T)

    def back(self, spectrum: Complex) -> Array:
        """Return a series on the coarse grid, (n_steps, n)."""
        return self._inverse(spectrum, self.steps)

    def forward(self, values: Array) -> Complex:
        """Return the spectrum of a series on the coarse grid, (n, n_omega)."""
        scale = self.count / self.steps
        found = np.fft.rfft(values, 2 * self.steps, axis=0)[: len(self.omega)].T
        return np.asarray(found * scale)

    def fine(self, spectrum: Complex) -> Array:
        """Return a series on the record's grid, (n_samples, n)."""
        return self._inverse(spectrum, self.count)

    def _inverse(self, spectrum: Complex, steps: int) -> Array:
        wide = np.zeros((len(spectrum), steps + 1), dtype=complex)
        wide[:, : spectrum.shape[1]] = spectrum
        return np.asarray(np.fft.irfft(wide, 2 * steps)[:, :steps].T * (steps / self.count))
