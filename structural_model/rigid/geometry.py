"""Simple shapes of the arm: drawing, speed of every point, distance to itself."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray
import pinocchio as pin

from modal_core.channel import AXES, Channel
from modal_core.errors import ModelError
from structural_model.description import RigidRobot, Shape
from structural_model.rigid.kinematics import point_position, point_velocity, RigidKinematics

try:
    import coal
except ImportError:  # the name of the same library before its version 3
    import hppfcl as coal

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Capsules:
    """Capsules at one pose, in base axes.

    Parameters
    ----------
    links : tuple of str
        Link of each.
    start, end : (n_capsules, 3) array [m]
        Centres of the round ends.
    radius : (n_capsules,) array [m]
        Radius.
    """

    links: tuple[str, ...]
    start: Array
    end: Array
    radius: Array


@dataclass(frozen=True)
class PointSpeed:
    """The fastest point of the arm.

    Parameters
    ----------
    speed_m_s : (n_samples,) array [m/s]
        Of the fastest point at each instant.
    link : tuple of str
        Where it is at each instant.
    """

    speed_m_s: Array
    link: tuple[str, ...]


@dataclass(frozen=True)
class Clearance:
    """Smallest distance between two parts of the arm.

    Parameters
    ----------
    distance_m : float [m]
        Negative when they penetrate.
    first, second : str
        Links.
    sample : int
        Row of the pose.
    """

    distance_m: float
    first: str
    second: str
    sample: int = 0


class RobotGeometry:
    """Shapes of the collision elements on the rigid arm.

    Parameters
    ----------
    robot : RigidRobot
        Shapes and joint tree.
    kinematics : RigidKinematics
        Of the same arm.
    ignore : sequence of (link, link)
        Pairs that may touch, besides links joined by one joint.
    """

    def __init__(
        self,
        robot: RigidRobot,
        kinematics: RigidKinematics,
        ignore: Sequence[tuple[str, str]] = (),
    ) -> None:
        self.robot = robot
        self.kinematics = kinematics
        self.ignore = {frozenset(pair) for pair in ignore}
        self._balls = [ball for shape in robot.shapes for ball in self._enclosing(shape)]

    # -- drawing -------------------------------------------------------------------------------

    @cached_property
    def skeleton_points(self) -> tuple[tuple[str, Array], ...]:
        """Link and place of the points that draw the arm: origins of links, from base to tip."""
        frames = self.robot.model.frames
        frame = self.robot.tip_frame
        way = []
        while frame > 0:  # the first one is the world, its own parent
            if frames[frame].type == pin.FrameType.BODY:
                way.append((frames[frame].name, np.zeros(3)))
            frame = frames[frame].parentFrame
        return tuple(way[::-1])

    @cached_property
    def skeleton_channels(self) -> tuple[Channel, ...]:
        """Three channels a skeleton point, in link axes."""
        return tuple(
            Channel(name=f'{link}.{axis}', frame_id=link, direction=AXES[axis])
            for link, _ in self.skeleton_points
            for axis in ('x', 'y', 'z')
        )

    def skeleton(self, q: ArrayLike) -> Array:
        """Return the skeleton's points, (n_points, 3) or (n_poses, n_points, 3) [m]."""
        motion = self.kinematics.motion(q)
        points = np.stack(
            [
                point_position(motion, joint, placement.act(place))
                for joint, placement, place in self._placed(self.skeleton_points)
            ],
            axis=1,
        )
        return points[0] if np.ndim(q) == 1 else points

    def to_base(self, q: ArrayLike, vectors: Array) -> Array:
        """Turn one vector per skeleton point from link axes to base axes, (n_points, 3)."""
        motion = self.kinematics.motion(q)
        turned = np.empty_like(vectors)
        for number, (joint, placement, _) in enumerate(self._placed(self.skeleton_points)):
            turned[number] = motion.rotation[0, joint] @ placement.rotation @ vectors[number]
        return turned

    def capsules(self, q: ArrayLike) -> Capsules:
        """Return all capsules and spheres at one pose; a box gives a capsule along its length."""
        motion = self.kinematics.motion(q)
        links: list[str] = []
        starts: list[Array] = []
        ends: list[Array] = []
        radii: list[float] = []
        for shape in self.robot.shapes:
            joint, placement = self.robot.links[shape.link]
            half, radius, axis = _axis_of(shape)
            links.append(shape.link)
            radii.append(radius)
            for store, sign in ((starts, -1.0), (ends, 1.0)):
                place = placement.act(shape.position + sign * half * axis)
                store.append(point_position(motion, joint, place)[0])
        return Capsules(
            tuple(links),
            np.array(starts).reshape(-1, 3),
            np.array(ends).reshape(-1, 3),
            np.array(radii),
        )

    # -- points --------------------------------------------------------------------------------

    def positions(self, q: ArrayLike, points: Sequence[tuple[str, ArrayLike]]) -> Array:
        """Return where points of links are, (n_samples, n_points, 3) [m], in base axes.

        Parameters
        ----------
        q : (n_samples, n_joints) array [rad]
            Serial joint angles.
        points : sequence of (link, (3,) array [m])
            Places in link frames.
        """
        motion = self.kinematics.motion(q)
        return np.stack(
            [
                point_position(motion, joint, placement.act(np.asarray(place, dtype=float)))
                for joint, placement, place in self._placed(points)
            ],
            axis=1,
        )

    def extent(self, q: ArrayLike) -> Array:
        """Return the axis-aligned box around the whole arm over all poses, (2, 3) [m]."""
        self._check_shapes()
        motion = self.kinematics.motion(q)
        lows, highs = [], []
        for _, joint, place, radius in self._balls:
            points = point_position(motion, joint, place)
            lows.append(points.min(axis=0) - radius)
            highs.append(points.max(axis=0) + radius)
        return np.stack([np.min(lows, axis=0), np.max(highs, axis=0)])

    def moving_extent(self, q: ArrayLike) -> Array:
        """Return the same box without the base, (2, 3) [m]."""
        self._check_shapes()
        motion = self.kinematics.motion(q)
        boxes = [
            (points.min(axis=0) - radius, points.max(axis=0) + radius)
            for _, joint, place, radius in self._balls
            if joint > 0
            for points in (point_position(motion, joint, place),)
        ]
        return np.stack(
            [
                np.min([low for low, _ in boxes], axis=0),
                np.max([high for _, high in boxes], axis=0),
            ]
        )

    def fastest_point(self, q: ArrayLike, qd: ArrayLike) -> PointSpeed:
        """Return an upper bound on the speed of any point of the arm, at each instant.

        A point within r of a centre moves at most |v| + |ω| r; a shape is covered by balls around
        its ends, and the speed of a rigid body is convex between them.

        Parameters
        ----------
        q, qd : (n_samples, n_joints) array [rad], [rad/s]
            Serial joint motion.
        """
        self._check_shapes()
        motion = self.kinematics.motion(q, qd, accelerations=False)
        spins = np.linalg.norm(motion.spin, axis=2)
        speeds = np.stack(
            [
                np.linalg.norm(point_velocity(motion, joint, place), axis=1)
                + radius * spins[:, joint]
                for _, joint, place, radius in self._balls
            ],
            axis=1,
        )
        fastest = speeds.argmax(axis=1)
        return PointSpeed(
            speed_m_s=speeds.max(axis=1), link=tuple(self._balls[index][0] for index in fastest)
        )

    def _check_shapes(self) -> None:
        """Refuse to bound an arm of unknown size."""
        if not any(joint > 0 for _, joint, _, _ in self._balls):
            raise ModelError(
                'no moving link has a simple shape',
                where=self.robot.name,
                expected='<collision> with a cylinder, sphere or box',
                advice='meshes are not read',
            )

    def _placed(
        self, points: Sequence[tuple[str, ArrayLike]]
    ) -> list[tuple[int, pin.SE3, ArrayLike]]:
        return [(*self.robot.links[link], place) for link, place in points]

    def _enclosing(self, shape: Shape) -> list[tuple[str, int, Array, float]]:
        """Return (link, joint, centre in joint frame, radius) of balls whose hull covers it."""
        joint, placement = self.robot.links[shape.link]
        if shape.box is not None:
            corners = np.array(np.meshgrid(*[(-0.5, 0.5)] * 3)).reshape(3, -1).T
            places = [shape.position + shape.rotation @ (c * shape.box) for c in corners]
            return [(shape.link, joint, np.array(placement.act(p)), 0.0) for p in places]
        half, radius, axis = _axis_of(shape)
        ends = [shape.position + sign * half * axis for sign in ((-1, 1) if half > 0.0 else (0,))]
        return [(shape.link, joint, np.array(placement.act(end)), radius) for end in ends]

    # -- self-collision ------------------------------------------------------------------------

    @cached_property
    def collision_model(self) -> pin.GeometryModel:
        """Pinocchio's collision model: cylinders as capsules, joined links left out."""
        model = pin.GeometryModel()
        for number, shape in enumerate(self.robot.shapes):
            joint, placement = self.robot.links[shape.link]
            solid = (
                coal.Box(*shape.box)
                if shape.box is not None
                else coal.Capsule(shape.radius, shape.length)
                if shape.length > 0.0
                else coal.Sphere(shape.radius)
            )
            model.addGeometryObject(
                pin.GeometryObject(
                    f'{shape.link}#{number}',
                    joint,
                    placement * pin.SE3(shape.rotation, shape.position),
                    solid,
                )
            )
        for first in range(len(self.robot.shapes)):
            for second in range(first + 1, len(self.robot.shapes)):
                if self._may_collide(first, second):
                    model.addCollisionPair(pin.CollisionPair(first, second))
        return model

    def _may_collide(self, first: int, second: int) -> bool:
        links = (self.robot.shapes[first].link, self.robot.shapes[second].link)
        joints = [self.robot.links[link][0] for link in links]
        parents = self.kinematics.parents
        joined = joints[0] == joints[1] or any(
            joints[a] > 0 and parents[joints[a]] == joints[b] for a, b in ((0, 1), (1, 0))
        )
        return not joined and frozenset(links) not in self.ignore

    def clearance(self, q: ArrayLike) -> Clearance | None:
        """Return the smallest distance between any two parts over all poses.

        Parameters
        ----------
        q : (n_joints,) or (n_poses, n_joints) array [rad]
            Serial joint angles.

        Returns
        -------
        Clearance or None
            None when no pair is to be checked.
        """
        geometry = self.collision_model
        if len(geometry.collisionPairs) == 0:
            return None
        data, work = self.robot.model.createData(), geometry.createData()
        best: Clearance | None = None
        for sample, pose in enumerate(np.atleast_2d(np.asarray(q, dtype=float))):
            pin.computeDistances(self.robot.model, data, geometry, work, pose)
            distances = [result.min_distance for result in work.distanceResults]
            pair = int(np.argmin(distances))
            if best is None or distances[pair] < best.distance_m:
                ids = geometry.collisionPairs[pair]
                best = Clearance(
                    distance_m=float(distances[pair]),
                    first=self.robot.shapes[ids.first].link,
                    second=self.robot.shapes[ids.second].link,
                    sample=sample,
                )
        return best


def _axis_of(shape: Shape) -> tuple[float, float, Array]:
    """Return half length, radius and axis of the capsule that stands for a shape."""
    if shape.box is None:
        return shape.length / 2.0, shape.radius, shape.rotation[:, 2]
    longest = int(np.argmax(shape.box))
    others = [edge for number, edge in enumerate(shape.box) if number != longest]
    radius = float(np.mean(others)) / 2.0
    return max(shape.box[longest] / 2.0 - radius, 0.0), radius, shape.rotation[:, longest]
