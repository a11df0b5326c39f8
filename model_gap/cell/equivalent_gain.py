"""What nonlinear joint torques do to small changes: equivalent linear springs and dampers."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from model_gap.cell.pose_system import PoseSystem

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]


def equivalent_gain(torque: Complex, twist: Complex, omega: Array) -> Complex:
    """Return d(ω) = k_e + iω c_e that comes closest to torque = d · twist, (n_bins,).

    For a Gaussian motion it is also the mean slope of the law, so that it says how the torque
    follows a small change of the motion.

    Parameters
    ----------
    torque, twist : (n_bins,) complex array
        Of one joint.
    omega : (n_bins,) array [rad/s]
        Evenly spaced in the logarithm.

    References
    ----------
    Caughey (1963), doi:10.1121/1.1918794; Bussgang's theorem.
    """
    rows = np.stack([twist, 1j * omega * twist], axis=1) * np.sqrt(omega)[:, None]
    size = np.maximum(np.linalg.norm(rows, axis=0), 1e-300)
    rows /= size
    right = torque * np.sqrt(omega)
    # Real unknowns: real and imaginary parts are separate equations.
    both = np.concatenate([rows.real, rows.imag])
    spring, damper = np.linalg.lstsq(both, np.concatenate([right.real, right.imag]))[0] / size
    return np.asarray(spring + 1j * omega * damper)


def closed_transfer(
    transfer: Complex,
    system: PoseSystem,
    omega: Array,
    places: Array,
    gains: Sequence[NDArray[np.complexfloating]],
) -> Complex:
    """Return readings per force when torques follow the twists, (n_channels, n, n_bins).

    Parameters
    ----------
    transfer : (n_channels, n, n_bins) complex array
        Readings per force on the arm without them.
    system : PoseSystem
        The arm.
    omega : (n_bins,) array [rad/s]
        Frequencies.
    places : (n, n_places) array
        Twist per deflection.
    gains : sequence of (n_bins,) array
        Torque per twist at every place.
    """
    per_force = np.array([system.twist_per_force(omega, place) for place in places.T])
    feedback = np.einsum('pnb,nq->bpq', per_force, places)
    gain = np.array(gains)  # (n_places, n_bins)
    loop = np.eye(len(gain)) + feedback * gain.T[:, None, :]
    followed = np.linalg.solve(loop, per_force.transpose(2, 0, 1))  # (n_bins, n_places, n)
    readings = np.einsum('cnb,nq->bcq', transfer, places) * gain.T[:, None, :]
    return np.asarray(transfer - (readings @ followed).transpose(1, 2, 0))
