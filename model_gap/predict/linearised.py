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

from modal_core.work.side_by_side import side_by_side
from model_gap.campaign import Band, GapRecord, record_spectra
from model_gap.cell import CellModel, joint_vector, pose_system, PoseSystem, sag
from model_gap.laws import Follow
from model_gap.predict.followed import free_torques, measured_share
from structural_model import FlexibleJointModel
from structural_model.equations import remainder

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

    def beyond(record: GapRecord) -> Array:
        system = pose_system(arm, record.pose, cell.channels)
        return second_order(record, arm, cell, system, high_hz)

    return [
        dataclasses.replace(record, acceleration=record.acceleration - extra)
        for record, extra in zip(records, side_by_side(beyond, records), strict=True)
    ]


def second_order(
    record: GapRecord,
    model: FlexibleJointModel,
    cell: CellModel,
    system: PoseSystem,
    high_hz: float,
) -> Array:
    """Return the reading of the second-order motion, (n_samples, n_channels) [m/s²]."""
    expansion = _Expansion.of(record, model, cell, system, high_hz)
    _, reading = expansion.beyond(expansion.linear)
    return expansion.read(reading)


def third_order(
    record: GapRecord,
    model: FlexibleJointModel,
    cell: CellModel,
    system: PoseSystem,
    high_hz: float,
) -> Array:
    """Return what one more order of the expansion reads, (n_samples, n_channels) [m/s²].

    It is what records hold that the second order was taken out of: little where an arm only
    shakes, more than all else where its joints travel far.
    """
    expansion = _Expansion.of(record, model, cell, system, high_hz)
    second, reading = expansion.beyond(expansion.linear)
    _, further = expansion.beyond(expansion.linear + second)
    return expansion.read(further - reading)


@dataclasses.dataclass(frozen=True)
class _Expansion:
    """The motion of one record by orders; spectra are of a grid of their own."""

    record: GapRecord
    model: FlexibleJointModel
    cell: CellModel
    system: PoseSystem
    series: '_Series'
    motors: tuple[Array, Array, Array]
    linear: Complex

    @classmethod
    def of(
        cls,
        record: GapRecord,
        model: FlexibleJointModel,
        cell: CellModel,
        system: PoseSystem,
        high_hz: float,
    ) -> '_Expansion':
        """Return the motion to first order."""
        count, rate_hz = record.acceleration.shape[0], record.sample_rate_hz
        # Sums of two frequencies fold above the band.
        steps = round(count / rate_hz * 3.0 * high_hz)
        series = _Series(count, steps, rate_hz, high_hz)
        shift = series.spectrum(record.motor_shift)
        acceleration = series.spectrum(record.motor_acceleration)
        acceleration, shift = cell.driven(series.omega, acceleration, shift)
        push = system.force(acceleration, shift)
        if cell.forces:
            push = push - shown_torques(record, model, cell, system)[:, : len(series.omega)]
        rate = 1j * series.omega * shift
        motors = (series.back(shift), series.back(rate), series.back(acceleration))
        linear = system.deflection(series.omega, push)
        return cls(record, model, cell, system, series, motors, linear)

    def beyond(self, flexible: Complex) -> tuple[Complex, Complex]:
        """Return the deflection beyond the first order along a deflection, and all it reads."""
        series, system, turn = self.series, self.system, 1j * self.series.omega
        force, reading = remainder(
            self.model.dynamics,
            self.record.pose,
            sag(self.model, self.record.pose, hanging=True),
            self.motors,
            (series.back(flexible), series.back(turn * flexible), series.back(turn**2 * flexible)),
            self.cell.channels,
        )
        more = system.deflection(series.omega, series.forward(force))
        moved = system.flexible @ (turn**2 * more) + system.gravity @ more
        return more, series.forward(reading) + moved

    def read(self, spectrum: Complex) -> Array:
        """Return a reading behind the outputs' steps, in time."""
        return self.series.fine(self.cell.seen(self.series.omega, spectrum))


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
