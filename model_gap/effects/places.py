"""Places on an arm that effects are attached to, and what is usual for its size."""

from collections.abc import Iterable, Sequence
import itertools
import math
from typing import Protocol

import numpy as np
from numpy.typing import NDArray
import pinocchio as pin

from modal_core.channel import AXES
from model_gap.campaign import CAMPAIGN
from model_gap.effects.effect import Scene

Place = tuple[float, float, float]


class Named(Protocol):
    """A part of a model."""

    @property
    def name(self) -> str:
        """Its name."""


def unused_name(base: str, parts: Iterable[Named]) -> str:
    """Return a name for one more part: numbered if a corrected model has one of that name."""
    names = {part.name for part in parts}
    numbers = (f'{base}_{number}' for number in itertools.count(2))
    return next(name for name in itertools.chain([base], numbers) if name not in names)


def arm_mass(scene: Scene) -> float:
    """Return the mass of the moving links [kg]."""
    inertias = scene.model.robot.model.inertias
    return float(sum(inertias[index].mass for index in range(1, len(inertias))))


def stiffest(scene: Scene) -> float:
    """Return the stiffness of the stiffest drive [N m/rad], the scale of the structure."""
    return max(
        item.drive.spring.stiffness
        for item in scene.cell.spec.joints
        if not item.drive.spring.rigid
    )


def moving_links(scene: Scene) -> list[str]:
    """Return one link for every body that moves on its own: not what is only fixed to it."""
    names: dict[int, str] = {}
    for frame in scene.model.robot.model.frames:
        if frame.type.name == 'BODY' and frame.parentJoint > 0:
            names.setdefault(int(frame.parentJoint), str(frame.name))
    return list(names.values())


def body_of(scene: Scene, link: str) -> int:
    """Return the moving joint a link rides on."""
    return next(
        int(frame.parentJoint)
        for frame in scene.model.robot.model.frames
        if frame.type.name == 'BODY' and frame.name == link
    )


def centre(scene: Scene, link: str) -> Place:
    """Return the centre of mass of a link and all that is fixed to it, in the link's axes."""
    robot = scene.model.robot
    for frame in robot.model.frames:
        if frame.name == link and frame.type.name == 'BODY':
            place = frame.placement.actInv(np.array(robot.model.inertias[frame.parentJoint].lever))
            return float(place[0]), float(place[1]), float(place[2])
    return 0.0, 0.0, 0.0


def centre_at_zero(scene: Scene, link: str) -> Place:
    """Return the same in the base's axes, all joints at zero or as near as their ranges allow."""
    model = scene.model.robot.model
    ends = model.lowerPositionLimit, model.upperPositionLimit
    data, frame = model.createData(), model.getFrameId(link, pin.FrameType.BODY)
    pin.framesForwardKinematics(model, data, np.clip(pin.neutral(model), *ends))
    x, y, z = data.oMf[frame].act(np.array(centre(scene, link)))
    return float(x), float(y), float(z)


def on_link(
    scene: Scene, point: Sequence[float], link: str, other: str, pose: NDArray[np.float64]
) -> Place:
    """Return a point of one link in the axes of another one, the joints at a pose."""
    model = scene.model.robot.model
    data = model.createData()
    pin.framesForwardKinematics(model, data, pose)
    one, two = (data.oMf[model.getFrameId(name, pin.FrameType.BODY)] for name in (link, other))
    x, y, z = two.actInv(one.act(np.array(point)))
    return float(x), float(y), float(z)


def spans(scene: Scene) -> dict[str, Place]:
    """Return the way to the next joint of every moving link that has one."""
    robot = scene.model.robot
    found = {}
    for link in moving_links(scene):
        index = body_of(scene, link)
        for child in range(1, len(robot.joints) + 1):
            place = np.array(robot.model.jointPlacements[child].translation)
            if int(robot.model.parents[child]) == index and np.linalg.norm(place) > 0.05:
                found[link] = (float(place[0]), float(place[1]), float(place[2]))
                break
    return found


def reach(scene: Scene) -> float:
    """Return how far the arm reaches when it is stretched out [m].

    From the base joint by joint, sliding ones at the farther end, then to the farthest point that
    is known of a link: a frame (a flange, a tool), its centre of mass, a sensor.
    """
    robot = scene.model.robot
    longest = [0.0]
    for index, joint in enumerate(robot.joints, start=1):
        way = float(np.linalg.norm(robot.model.jointPlacements[index].translation))
        ends = (robot.model.lowerPositionLimit, robot.model.upperPositionLimit)
        start = int(robot.model.idx_qs[index])
        slide = max(abs(float(end[start])) for end in ends) if joint.prismatic else 0.0
        longest.append(
            longest[int(robot.model.parents[index])]
            + way
            + (slide if slide < CAMPAIGN.longest_travel_m else 0.0)
        )
    points = [
        (int(frame.parentJoint), frame.placement.translation) for frame in robot.model.frames
    ]
    points += [(index, robot.model.inertias[index].lever) for index in range(1, len(longest))]
    frames = {frame.name: frame for frame in robot.model.frames if frame.type.name == 'BODY'}
    for channel in scene.cell.channels:
        frame = frames.get(channel.frame_id)
        if frame is not None:
            place = frame.placement.act(np.array(channel.position_m))
            points.append((int(frame.parentJoint), place))
    carried = [(body, point) for body, point in points if body > 0]
    farthest = [longest[body] + float(np.linalg.norm(point)) for body, point in carried]
    return max(farthest, default=0.0) or 1.0


def turned(axis: str, turns: Sequence[float]) -> Place:
    """Return one of the axes, a unit vector, turned (2,) [rad] towards the two after it."""
    first, second = ('xyz'[('xyz'.index(axis) + step) % 3] for step in (1, 2))
    vector = np.array(AXES[axis]) + np.tan(turns) @ np.array([AXES[first], AXES[second]])
    x, y, z = vector / np.linalg.norm(vector)
    return float(x), float(y), float(z)


def turns(axis: str, along: Sequence[float]) -> tuple[float, float]:
    """Return how far one of the axes is turned, (2,) [rad], to lie along a line."""
    here = 'xyz'.index(axis)
    own, first, second = (float(along[(here + step) % 3]) for step in range(3))
    sign = math.copysign(1.0, own)
    return math.atan2(sign * first, abs(own)), math.atan2(sign * second, abs(own))
