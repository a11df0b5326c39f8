"""What a model linearised about a pose leaves out of a motion: all beyond the first order."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray
import pinocchio as pin

from modal_core.channel import Channel
from structural_model.equations import sensing
from structural_model.equations.dynamics import Dynamics
from structural_model.equations.linearise import reading_rows

Array = NDArray[np.float64]
_States = tuple[Array, Array, Array]
"""Position, velocity and acceleration, by time."""


def remainder(
    dynamics: Dynamics,
    q: ArrayLike,
    deflection: Array,
    motors: _States,
    flexible: _States,
    channels: Sequence[Channel],
) -> tuple[Array, Array]:
    """Return force and reading of a motion less those of the model linearised about a pose.

    Inertia that turns with the arm, centrifugal and Coriolis force, the bend of gravity's load.

    Parameters
    ----------
    dynamics : Dynamics
        Of the arm.
    q : (n_joints,) array [rad]
        The pose.
    deflection : (n_dof,) array
        At rest there.
    motors : three (n_samples, n_joints) arrays
        Motor-side departure from q, its rate and its acceleration.
    flexible : three (n_samples, n_dof) arrays
        Departure from the deflection at rest, its rate and its acceleration.
    channels : sequence of Channel
        Accelerometers.

    Returns
    -------
    (n_samples, n_dof) array, (n_samples, n_channels) array
        Force on the deflections [N m], [N], and acceleration [m/s²] as the sensors read it.
    """
    assembly = dynamics.assembly
    count = len(assembly.flexible)
    full = dynamics.position(q, deflection)
    moves = [_full(dynamics, *parts) for parts in zip(motors, flexible, strict=True)]
    still = np.zeros((1, len(full)))
    torque, reading = _exact(dynamics, full, (still, still, still), channels)
    exact, seen = _exact(dynamics, full, (moves[0], moves[1], moves[2]), channels)
    force = np.zeros((len(moves[0]), dynamics.n_dof))
    slope = pin.computeGeneralizedGravityDerivatives(assembly.model, assembly.data, full)
    linear = torque + moves[0] @ slope.T + moves[2] @ dynamics.mass(full)
    force[:, :count] = (linear - exact)[:, assembly.flexible]
    for item in dynamics.spec.compensators:
        name = f'{item.joint}/drive'
        if name in assembly.dof_names:
            place = assembly.drives[dynamics.joint_names.index(item.joint)]
            turn, move = full[place] - dynamics.neutral(item), moves[0][:, place]
            bend = np.sin(turn) + np.cos(turn) * move - np.sin(turn + move)
            force[:, assembly.dof_names.index(name)] += item.strength_nm * bend
    rows, tilt = reading_rows(dynamics, q, channels, deflection)
    rise, shift = (np.hstack([flexible[order], motors[order]]) for order in (2, 0))
    return force, seen - reading - rise @ rows.T - shift @ tilt.T


def _full(dynamics: Dynamics, motor: Array, flexible: Array) -> Array:
    """Return a motion in pinocchio's coordinates."""
    assembly = dynamics.assembly
    found = np.zeros((len(motor), assembly.model.nv))
    found[:, assembly.drives] = motor
    found[:, assembly.flexible] += flexible[:, : len(assembly.flexible)]
    return found


def _exact(
    dynamics: Dynamics, full: Array, motion: _States, channels: Sequence[Channel]
) -> tuple[Array, Array]:
    """Return generalised force and readings of a motion about a position."""
    assembly = dynamics.assembly
    model, data = assembly.model, assembly.data
    places = sensing.sensor_map(assembly, tuple(channels))
    torque = np.empty((len(motion[0]), model.nv))
    joints = [joint for joint, _ in places.groups]
    twists = np.empty((len(motion[0]), len(joints), 2, 6))
    # Asked for once: they are what the last call of ``rnea`` has left.
    kept = [(data.v[joint], data.a_gf[joint]) for joint in joints]
    for sample, (place, rate, rise) in enumerate(
        zip(full + motion[0], motion[1], motion[2], strict=True)
    ):
        torque[sample] = pin.rnea(model, data, place, rate, rise)
        twists[sample] = [(speed.vector, change.vector) for speed, change in kept]
    reading = np.empty((len(torque), len(channels)))
    for number, (_, members) in enumerate(places.groups):
        speed, change = twists[:, number, 0], twists[:, number, 1]
        turn = speed[:, None, 3:]
        along = places.direction[members]
        reading[:, members] = change @ places.wrench[members].T
        place = places.position[members]
        whole = np.cross(turn, speed[:, None, :3] + np.cross(turn, place[None]))
        reading[:, members] += np.einsum('nci,ci->nc', whole, along)
    return torque, reading
