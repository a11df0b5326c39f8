"""The arm from the side: where the gap is and what it is put down to."""

from collections.abc import Mapping

from markupsafe import escape, Markup
import numpy as np
from numpy.typing import NDArray

from modal_core.channel import SensorLayout
from model_gap.report.drawing import heat
from structural_model import FlexibleJointModel

Array = NDArray[np.float64]
SIZE, MARGIN = 420, 46


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
    points = model.geometry.skeleton(q)
    links = [link for link, _ in model.geometry.skeleton_points]
    sensors = model.geometry.positions(
        q[None, :], [(sensor.frame_id, np.array(sensor.position_m)) for sensor in layout]
    )[0]
    flat = _flattened(points, sensors)
    arm, dots = flat[: len(points)], flat[len(points) :]
    joints = _joint_points(model, links)
    parts = [_polyline(arm)]
    for place in places:
        parts.append(_mark(place, links, arm, joints))
    for name, index in joints.items():
        x, y = arm[index]
        parts.append(f'<circle class="joint" cx="{x:.1f}" cy="{y:.1f}" r="6"/>')
        hot = ' hot' if name in places else ''
        parts.append(
            f'<text class="tick{hot}" x="{x - 9:.1f}" y="{y + 16:.1f}" text-anchor="end">'
            f'{escape(name.replace("joint_", "J"))}</text>'
        )
    for sensor, (x, y) in zip(layout, dots, strict=True):
        value = left.get(sensor.name, 1.0)
        hot = ' hot' if f'sensor:{sensor.name}' in places else ''
        parts.append(
            f'<circle class="sensor{hot}" cx="{x:.1f}" cy="{y:.1f}" r="{9 if hot else 5}" '
            f'fill="{heat(value)}"><title>{escape(sensor.name)}: {value:.1f}</title>'
            '</circle>'
        )
    marked = ', '.join(places) or 'no place'
    return Markup(  # noqa: S704  numbers and escaped text only
        f'<svg viewBox="0 0 {SIZE} {SIZE}" role="img" '
        f'aria-label="the arm from the side; marked: {escape(marked)}">{"".join(parts)}</svg>'
    )


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


def _polyline(arm: Array) -> str:
    text = ' '.join(f'{x:.1f},{y:.1f}' for x, y in arm)
    return f'<polyline class="arm" points="{text}"/>'


def _mark(place: str, links: list[str], arm: Array, joints: Mapping[str, int]) -> str:
    if place in joints:
        x, y = arm[joints[place]]
        return f'<circle class="mark" cx="{x:.1f}" cy="{y:.1f}" r="20"/>'
    if place in links:
        index = links.index(place)
        last = min(index + 1, len(arm) - 1)
        (x1, y1), (x2, y2) = arm[index], arm[last]
        return f'<line class="mark" x1="{x1:.1f}" y1="{y1:.1f}" x2="{x2:.1f}" y2="{y2:.1f}"/>'
    if place == 'base':
        x, y = arm[0]
        return f'<circle class="mark" cx="{x:.1f}" cy="{y:.1f}" r="24"/>'
    return ''
