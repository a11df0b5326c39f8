"""Where a first set of sensors may sit: one on each body, one at the tip."""

import numpy as np

from modal_core.channel import Sensor, SensorLayout
from structural_model.description import RigidRobot
from structural_model.first_model.shapes import body_link, box_of


def guessed_layout(robot: RigidRobot, tip: str) -> SensorLayout:
    """Return three axes on every moving body, far from its joint, and at the tip.

    Parameters
    ----------
    robot : RigidRobot
        The arm.
    tip : str
        Its last link.
    """
    sensors = []
    for body in range(1, robot.model.njoints):
        link = body_link(robot, body)
        edges, axes, centre = box_of(robot.model.inertias[body])
        longest = int(np.argmax(edges))
        along = 0.5 * edges[longest] * axes[:, longest]
        place = centre + (along if along @ centre >= 0.0 else -along)
        x, y, z = (float(part) for part in np.round(place, 4))
        sensors.append(Sensor(link, link, (x, y, z)))
    sensors.append(Sensor('tip', tip))
    return SensorLayout(tuple(sensors))
