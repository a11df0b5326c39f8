"""What a torque in a joint acts on: the twist of the linear arm, and how it gives way."""

import dataclasses
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
import scipy.fft

from model_gap.campaign import RecordSpectra
from model_gap.cell import axis_row, CellModel, joint_spring, joint_vector, PoseSystem
from model_gap.laws import Follow
from model_gap.predict.followed import (
    free_torques,
    measured_share,
    PARTING_1_S,
    parting_residues,
    predicted_share,
)
from model_gap.predict.thresholds import PREDICTION
from structural_model import FlexibleJointModel

Complex = NDArray[np.complex128]
Array = NDArray[np.float64]


@dataclass(frozen=True)
class JointPath:
    """From torque to twist of one joint in one record, and what the linear arm does.

    Parameters
    ----------
    poles, residues : (n_modes,) complex array
        twist(s) = Re-sum residues/(s - poles) · force, one of each pair.
    instant : float [rad/(N m)]
        Compliance of the faster poles.
    twist, rate, speed : (n_steps,) array
        Linear twist, its rate, and the motor speed of the joint.
    vector : (n_dof,) array
        Twist per deflection.
    stiffness, static_twist : float
        Linear spring, and its twist under gravity.
    steps_per_s : float [Hz]
        Of the series.
    noisy : ((n_steps,) array, (n_steps,) array) or None
        Twist and rate once more, with as much noise again as a measured twist has.
    start_s : float [s]
        When the record begins, from the beginning of the campaign.
    damping : float [N m s/rad]
        Of the linear spring.
    """

    poles: Complex
    residues: Complex
    instant: float
    twist: Array
    rate: Array
    speed: Array
    vector: Array
    stiffness: float
    static_twist: float
    steps_per_s: float = PREDICTION.steps_per_s
    noisy: tuple[Array, Array] | None = None
    start_s: float = 0.0
    damping: float = 0.0

    def with_noise(self) -> 'JointPath':
        """Return the path along the noisier twist."""
        if self.noisy is None:
            return self
        return dataclasses.replace(self, twist=self.noisy[0], rate=self.noisy[1])


def joint_path(
    model: FlexibleJointModel,
    joint: str,
    item: RecordSpectra,
    system: PoseSystem,
    cell: CellModel,
    steps_per_s: float,
    follow: Follow,
) -> JointPath:
    """Prepare a joint of a record."""
    record = item.record
    seconds = len(record.motor_acceleration) / record.sample_rate_hz
    # A few more: Fourier transforms of numbers with large prime factors take times as long.
    steps_per_s = scipy.fft.next_fast_len(round(seconds * steps_per_s), real=True) / seconds
    vector = joint_vector(model, joint, system.dof_names)
    spring = joint_spring(model.spec, joint)
    residues = (vector @ system.shapes) * (system.drives @ vector)
    quick = np.abs(system.poles) >= PREDICTION.slow_pole_1_s
    instant = float(np.sum((-residues / system.poles)[quick].real))
    instant += float(vector @ system.instant @ vector)
    places, count = system.one_of_pairs
    slow = ~quick[places]
    poles, residues = system.poles[places][slow], (count * residues[places])[slow]
    omega, *motion = item.long_motion
    row = system.twist_per_force(omega, vector)
    twist = np.einsum('nf,nf->f', row, system.force(*cell.driven(omega, *motion)))
    noisy = None
    if follow is not Follow.PREDICTED:
        torques, noise = free_torques(item, system, [vector], cell)
        share, give = measured_share(omega, follow), row.T @ vector
        twist = twist - give * torques[0] * share
        if follow is Follow.PARTED:
            # One sample; half of it falls behind the record.
            normal = np.random.default_rng(PREDICTION.noise_seed).standard_normal((2, len(share)))
            error = share * np.sqrt(noise[0]) * (normal[0] + 1j * normal[1])
            noisy = with_rate(twist - give * error, item, steps_per_s)
            low = np.sum((residues / (-PARTING_1_S[:, None] - poles)).real, axis=1) + instant
            residues = np.r_[residues * predicted_share(poles), parting_residues() * low]
            poles = np.r_[poles, -PARTING_1_S]
        else:
            poles, residues = np.zeros(0, dtype=complex), np.zeros(0, dtype=complex)
        instant = 0.0
    linear, rate = with_rate(twist, item, steps_per_s)
    speed = record.motor_velocity @ axis_row(model, joint)
    return JointPath(
        poles=poles,
        residues=residues,
        instant=instant,
        twist=linear,
        rate=rate,
        speed=resampled(speed, record.sample_rate_hz, len(linear), steps_per_s),
        steps_per_s=steps_per_s,
        vector=vector,
        stiffness=spring.stiffness,
        static_twist=static_twist(model, vector, record.pose),
        noisy=noisy,
        start_s=record.start_s,
        damping=spring.damping,
    )


def static_twist(model: FlexibleJointModel, vector: Array, pose: Array) -> float:
    """Return the twist of a drive spring under gravity at a pose."""
    return float(vector @ model.dynamics.sag(pose))


def with_rate(twist: Complex, item: RecordSpectra, steps_per_s: float) -> tuple[Array, Array]:
    """Return twists (..., n) that start from rest, and their rates, at the steps of a record."""
    record, omega = item.record, item.long_motion[0]
    seconds = len(record.motor_acceleration) / record.sample_rate_hz
    steps = round(seconds * steps_per_s)
    return on_steps(twist, item, steps), on_steps(1j * omega * twist, item, steps)


def on_steps(spectrum: Complex, item: RecordSpectra, steps: int) -> Array:
    """Return spectra (..., n) on the frequencies of the long motion as series of a record."""
    size = 2 * steps
    count = len(item.record.motor_acceleration)
    return np.asarray(scipy.fft.irfft(spectrum, size)[..., :steps] * (steps / count))


def resampled(values: Array, rate_hz: float, steps: int, steps_per_s: float) -> Array:
    """Return a series at the steps."""
    times = np.arange(steps) / steps_per_s
    return np.asarray(np.interp(times, np.arange(len(values)) / rate_hz, values))
