"""Force of a gear's transmission error on the flexible degrees of freedom."""

import numpy as np
from numpy.typing import NDArray

from model_gap.campaign import RecordSpectra
from model_gap.cell import axis_row, joint_spring, joint_vector, PoseSystem, Ripple
from model_gap.predict.ring_out import end_force
from structural_model import FlexibleJointModel, ModelSpec


def ripple_force(
    ripple: Ripple,
    item: RecordSpectra,
    model: FlexibleJointModel,
    spec: ModelSpec,
    system: PoseSystem,
) -> NDArray[np.complex128]:
    """Return w (k + iωc) θ_e(ω) with θ_e(t) = a sin(N q) + b cos(N q), (n_dof, 3 n_bins)."""
    record = item.record
    angle = (record.pose + record.motor_shift) @ axis_row(model, ripple.joint)
    phase = ripple.order_per_rad * angle
    twist = ripple.sine_rad * np.sin(phase) + ripple.cosine_rad * np.cos(phase)
    spectrum = transform_at(twist - twist.mean(), item)
    spring = joint_spring(spec, ripple.joint)
    weight = joint_vector(model, ripple.joint, system.dof_names)
    forced = np.outer(
        weight, (spring.stiffness + 1j * item.omega.ravel() * spring.damping) * spectrum
    )
    period_s = 1.0 / record.sample_rate_hz
    torque = spring.stiffness * (twist - twist[0]) + spring.damping * np.gradient(twist, period_s)
    return forced + end_force(torque, period_s, weight, item, system)


def transform_at(values: NDArray[np.float64], item: RecordSpectra) -> NDArray[np.complex128]:
    """Return the scaled rectangular spectrum of a series at a record's triples, (3 n_bins,)."""
    spectrum = np.fft.rfft(values) / np.sqrt(len(values))
    return np.asarray(spectrum[item.places])
