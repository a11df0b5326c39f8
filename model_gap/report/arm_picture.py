"""The arm from the side: where the gap is and what it is put down to."""

from collections.abc import Mapping

from markupsafe import Markup
import numpy as np
from numpy.typing import NDArray

from modal_core.channel import SensorLayout
from modal_reports import HeatScale, svg
from structural_model import FlexibleJointModel

Array = NDArray[np.float64]
Point = tuple[float, float]
SIZE, MARGIN = 420, 46
# Width of a letter of a joint's name, and size of a sensor's dot, in pixels.
LETTER, DOT = 6, 6
# From the noise to thirty times it.
TIMES_THE_NOISE = HeatScale(1.0, 10.0**1.5, logarithmic=True)


def arm_picture(
    model: FlexibleJointModel,
    q: Array,
    layout: SensorLayout,
    left: Mapping[str, float],
    places: tuple[str, ...],
) -> Markup:
    """Draw skeleton, joints and sensors in the vertical plane the arm reaches out in.

    Parameters
    ----------
    model : FlexibleJointModel
        The robot.
    q : (n_joints,) array [rad]
        Pose.
    layout : SensorLayout
        Sensors.
    left : mapping of sensor name to float
        Gap before, times the noise.  It colours the sensors.
    places : tuple of str
        Locations to mark: joints, links, ``sensor:<name>``, or ``base``.
    """
    links = [link for link, _ in model.geometry.skeleton_points]
    points = np.vstack([model.geometry.skeleton(q), *_tip(model, q, layout)])
    sensors = model.geometry.positions(
        q[None, :], [(sensor.frame_id, np.array(sensor.position_m)) for sensor in layout]
    )[0]
    flat = _flattened(points, sensors)
    arm, dots = flat[: len(points)], flat[len(points) :]
    joints = _joint_points(model, links)
    parts = [svg.polyline('arm', arm.tolist())]
    parts += [_mark(place, links, arm, joints) for place in places]
    for name, index in joints.items():
        x, y = arm[index].tolist()
        kind = 'tick hot' if name in places else 'tick'
        parts.append(svg.circle('joint', x, y, 6))
        label = name.replace('joint_', 'J')
        at, anchor = _beside((x, y), label, np.delete(flat, index, axis=0))
        parts.append(svg.text(*at, label, kind, anchor))
    for sensor, (x, y) in zip(layout, dots.tolist(), strict=True):
        value = left.get(sensor.name, 1.0)
        hot = f'sensor:{sensor.name}' in places
        kind = f'sensor heat-{TIMES_THE_NOISE.step(value)}{" hot" if hot else ""}'
        parts.append(svg.circle(kind, x, y, 9 if hot else 5, f'{sensor.name}: {value:.1f}'))
    marked = ', '.join(places) or 'no place'
    return svg.svg((SIZE, SIZE), f'the arm from the side; marked: {marked}', parts)


def _tip(model: FlexibleJointModel, q: Array, layout: SensorLayout) -> Array:
    """Return the farthest known point of the last link, (1, 3), where it has one; else (0, 3).

    Without it an arm would end at its last joint, and sensors float in the air.
    """
    link, start = model.geometry.skeleton_points[-1]
    own = [np.array(item.position_m) for item in layout if item.frame_id == link]
    for frame in model.robot.model.frames:
        if frame.name == link and frame.type.name == 'BODY' and frame.parentJoint > 0:
            lever = np.array(model.robot.model.inertias[frame.parentJoint].lever)
            own.append(frame.placement.actInv(lever))
    if not own:
        return np.zeros((0, 3))
    far = max(own, key=lambda point: float(np.linalg.norm(point - start)))
    return np.asarray(model.geometry.positions(q[None, :], [(link, far)])[0])


def _flattened(points: Array, sensors: Array) -> Array:
    """Project onto the vertical plane of the widest reach, and fit into the picture."""
    everything = np.vstack([points, sensors])
    level = points[:, :2] - points[0, :2]
    reach = np.linalg.svd(level, full_matrices=False)[2][0]
    reach = reach if float(level[-1] @ reach) >= 0.0 else -reach
    flat = np.column_stack([(everything[:, :2] - points[0, :2]) @ reach, everything[:, 2]])
    low, high = flat.min(axis=0), flat.max(axis=0)
    scale = (SIZE - 2 * MARGIN) / max(float((high - low).max()), 1e-6)
    centred = (flat - (low + high) / 2.0) * scale
    return np.column_stack([SIZE / 2.0 + centred[:, 0], SIZE / 2.0 - centred[:, 1]])


def _joint_points(model: FlexibleJointModel, links: list[str]) -> dict[str, int]:
    """Return the skeleton point each joint is at: the origin of the link it moves."""
    found = {}
    for number, name in enumerate(model.joint_names, start=1):
        for frame in model.robot.model.frames:
            at_joint = frame.parentJoint == number and frame.name in links
            if at_joint and not np.abs(frame.placement.translation).max() > 1e-9:
                found[name] = links.index(frame.name)
                break
    return found


def _beside(point: Point, label: str, dots: Array) -> tuple[Point, str]:
    """Return where a label stands beside a point, and its end there: where fewest dots lie."""
    width = LETTER * len(label)

    def covered(choice: tuple[Point, str]) -> int:
        (x, y), end = choice
        left = x - width if end == 'end' else x
        across = (dots[:, 0] > left - DOT) & (dots[:, 0] < left + width + DOT)
        return int(np.sum(across & (dots[:, 1] > y - 10 - DOT) & (dots[:, 1] < y + DOT)))

    x, y = point
    sides: list[tuple[Point, str]] = [
        ((x - 9, y + 16), 'end'), ((x + 9, y + 16), 'start'),
        ((x - 9, y - 8), 'end'), ((x + 9, y - 8), 'start'),
    ]  # fmt: skip
    return min(sides, key=covered)


def _mark(place: str, links: list[str], arm: Array, joints: Mapping[str, int]) -> str:
    if place in links and place not in joints:
        index = links.index(place)
        start, end = arm[index].tolist(), arm[min(index + 1, len(arm) - 1)].tolist()
        return svg.line('mark', (start[0], start[1]), (end[0], end[1]))
    if place in joints or place == 'base':
        x, y = arm[joints.get(place, 0)].tolist()
        return svg.circle('mark', x, y, 20 if place in joints else 24)
    return ''
