"""A request brought together with a robot: names and pose resolved, every axis given its part."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from excitation_planner.amplitudes import informative_amplitudes, ROOM, ROOM_OF_PULSES
from excitation_planner.forecast import ExpectedModes
from excitation_planner.request import PlanRequest
from excitation_planner.signals import RANDOM_PULSES
from modal_core.channel import Channel, SensorLayout
from modal_core.errors import PlanError
from structural_model.flexible_joint_model import FlexibleJointModel

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Setting:
    """A request brought together with a robot.

    Parameters
    ----------
    request : PlanRequest
        What was asked.
    model : FlexibleJointModel
        The robot.
    channels : tuple of Channel
        Sensors of the cell.
    start : (n_joints,) array [rad]
        Serial joints.
    weights : (n_joints,) array
        Relative amplitude of every controller axis, 0 for one that rests.
    expected : ExpectedModes or None
        Of a map, at the start; None: what the model has.
    """

    request: PlanRequest
    model: FlexibleJointModel
    channels: tuple[Channel, ...]
    start: Array
    weights: Array
    expected: ExpectedModes | None = None


def bring_together(
    model: FlexibleJointModel, layout: SensorLayout | None, request: PlanRequest
) -> Setting:
    """Resolve the names and the pose of a request.

    Raises
    ------
    PlanError, ModelError, LayoutError
        An unknown axis or link, wrong weights, or a pose outside the range.
    """
    if layout is not None:
        model.check_layout(layout)
    start = start_of(model, request)
    return Setting(
        request=request,
        model=model,
        channels=layout.channels if layout is not None else (),
        start=start,
        weights=_weights(model, start, request),
    )


def start_of(model: FlexibleJointModel, request: PlanRequest) -> Array:
    """Return where a request starts, serial joints, (n_joints,) [rad]."""
    if request.start_position:
        return model.check_pose(np.array(request.start_position, dtype=float))
    if not model.poses_controller_rad:
        raise PlanError(
            'no start pose',
            where=model.robot_name,
            found='no named pose in its model.yaml',
            expected=f'{model.n_joints} joint values or the name of a pose',
            advice='no motion starts from a pose that nobody named',
        )
    return model.check_pose(model.usual_pose())


def _weights(model: FlexibleJointModel, start: Array, request: PlanRequest) -> Array:
    """Return the weights asked for; without them those that modes and torques need.

    All axes are alike where torques need not span space.
    """
    stated = stated_weights(model, request)
    if request.joint_weights or not request.require_full_rank:
        return stated
    room = ROOM_OF_PULSES if request.signal == RANDOM_PULSES else ROOM
    return informative_amplitudes(model, start, stated > 0.0, request.band_high_hz, room)


def stated_weights(model: FlexibleJointModel, request: PlanRequest) -> Array:
    """Return the relative amplitude of every controller axis, 1 of those that none is stated of.

    Raises
    ------
    PlanError
        A joint is not there, or there is not one weight for each that moves.
    """
    places = [_place(model, name) for name in request.joints or model.axis_names]
    shares = request.joint_weights or (1.0,)
    if len(shares) == 1:
        shares = shares * len(places)
    if len(shares) != len(places) or not any(shares):
        raise PlanError(
            'not one weight per moving joint, or all 0',
            where='joint_weights',
            found=list(shares),
            expected=f'{len(places)} numbers, or one for all',
        )
    weights = np.zeros(model.n_joints)
    weights[places] = shares
    return weights


def _place(model: FlexibleJointModel, name: str) -> int:
    """Find what moves by itself, a controller axis; the joint of its place may stand for it."""
    for names in (model.axis_names, model.joint_names):
        if name in names:
            return names.index(name)
    raise PlanError(
        'unknown axis', where='joints', found=name, expected=', '.join(model.axis_names)
    )
