"""Torques of the rigid arm, and how they change with every mass of it: linear, exactly."""

import dataclasses
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
import pinocchio as pin

from model_gap.trajectory.motion import Motion
from structural_model import FlexibleJointModel
from structural_model.description import BaseSpec, JointSpec

Array = NDArray[np.float64]
# Of a body in pinocchio's order: mass, mass times centre (3), inertia about the joint (6).
NUMBERS = 10


def rigid_of(model: FlexibleJointModel) -> FlexibleJointModel:
    """Return the arm without its flexibility: masses, gears and compensators stay."""
    joints = tuple(
        JointSpec(item.name, dataclasses.replace(item.drive, spring=type(item.drive.spring)()))
        for item in model.spec.joints
    )
    spec = dataclasses.replace(
        model.spec, joints=joints, base=BaseSpec(), hinges=(), beams=(), absorbers=(), rods=()
    )
    return dataclasses.replace(model, spec=spec)


@dataclass(frozen=True)
class RigidTorque:
    """The rigid arm along one motion.

    Parameters
    ----------
    total : (n, n_joints) array [N m]
        Drive torque, rotors included.
    load : (n, n_joints) array [N m]
        Of it what passes through the gear: without the rotor.
    bodies : (n, n_joints, n_bodies, 10) array
        Change of the load per inertial number of every moving body.
    """

    total: Array
    load: Array
    bodies: Array


def rigid_torque(model: FlexibleJointModel, motion: Motion) -> RigidTorque:
    """Return the torques of a rigid arm along a motion.

    Parameters
    ----------
    model : FlexibleJointModel
        From :func:`rigid_of`.
    motion : Motion
        Serial joint motion.
    """
    states = motion.joint_rad, motion.rate, motion.acceleration
    total = np.asarray(model.drive_torque(*states))
    axis = model.axes.to_controller(motion.acceleration)
    rotor = np.array(
        [item.drive.gear_ratio**2 * item.drive.rotor_inertia_kg_m2 for item in model.spec.joints]
    )
    arm = model.assembly.model
    data = arm.createData()
    rows = np.array(
        [pin.computeJointTorqueRegressor(arm, data, *row) for row in zip(*states, strict=True)]
    )
    drives = rows.reshape(motion.count, model.n_joints, -1)
    turned = np.einsum('ij,njk->nik', np.linalg.inv(model.axes.matrix).T, drives)
    bodies = turned.reshape(motion.count, model.n_joints, -1, NUMBERS)
    return RigidTorque(total, total - rotor * axis, bodies)


def lower(matrix: Array) -> Array:
    """Return the six numbers of a symmetric matrix in pinocchio's order, xx xy yy xz yz zz."""
    return matrix[[0, 0, 1, 0, 1, 2], [0, 1, 1, 2, 2, 2]]


def steiner(one: Array, two: Array) -> Array:
    """Return what a unit mass at c adds to the inertia about the origin, bilinear in c."""
    mixed = np.outer(one, two)
    return lower(float(one @ two) * np.eye(3) - 0.5 * (mixed + mixed.T))
