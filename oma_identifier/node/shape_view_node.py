"""Mode shapes that move on the moving arm: one mode after the other, slowly."""

from collections.abc import Callable, Iterable, Mapping
import itertools
import math
import time
from typing import Any

from geometry_msgs.msg import Point
import numpy as np
from numpy.typing import NDArray
from rclpy.node import Node
from visualization_msgs.msg import Marker, MarkerArray

from modal_core.channel import Channel
from modal_core.mode import Mode
from modal_core.nodes.ros_messages import LATCHED
from oma_identifier.result import WindowResult

FRAME_S, TURN_S, MODE_S = 0.1, 2.0, 6.0
"""Between two pictures; of one swing; of one mode before the next."""
SWING_M = 0.15
"""How far the sensor that moves most is drawn to move."""
LINE_M, BALL_M, TEXT_M = 0.01, 0.04, 0.1
SHAPE, REST, LABEL = 'mode shape', 'sensors', 'mode'
COLOURS = ((0.9, 0.2, 0.2), (0.2, 0.6, 0.9), (0.2, 0.7, 0.3), (0.9, 0.6, 0.1), (0.6, 0.3, 0.8))
ABOVE_M = 0.3
Places = Mapping[str, list[tuple[NDArray[np.float64], NDArray[np.complex128]]]]
"""Of each link: places of sensors (3,) [m] and how they move (3,)."""


class ShapeView:
    """Publishes ``~/mode_shapes``; moves only while somebody looks.

    Parameters
    ----------
    node : Node
        Gets publisher and timer.
    base_frame : str
        Where the words stand.
    channels : callable
        Returns the channels with their places, of a window's names.
    chosen : callable
        Returns the id of the mode to show; 0: one after the other.
    """

    def __init__(
        self,
        node: Node,
        base_frame: str,
        channels: Callable[[tuple[str, ...]], Iterable[Channel]],
        chosen: Callable[[], int],
    ) -> None:
        self._node, self._base_frame = node, base_frame
        self._channels, self._chosen = channels, chosen
        self._publisher = node.create_publisher(MarkerArray, '~/mode_shapes', LATCHED)
        self._shown: list[tuple[Mode, Places]] = []
        node.create_timer(FRAME_S, self._tick)

    def take(self, result: WindowResult) -> None:
        """Show the modes of a window from now on."""
        names = result.modes.channel_names
        known = {channel.name: channel for channel in self._channels(names)}
        shown = [(mode, places_of(mode, names, known)) for mode in result.modes]
        self._shown = [(mode, places) for mode, places in shown if places]
        # What was shown before may stand on links that are no longer seen.
        markers = [Marker(action=Marker.DELETEALL), *self._picture(0.0)]
        self._publisher.publish(MarkerArray(markers=markers))

    def _tick(self) -> None:
        if self._shown and self._publisher.get_subscription_count():
            self._publisher.publish(MarkerArray(markers=self._picture(time.monotonic())))

    def _picture(self, now_s: float) -> list[Marker]:
        chosen = self._chosen()
        shown = [item for item in self._shown if not chosen or item[0].id == chosen]
        if not shown:
            return [Marker(action=Marker.DELETEALL)]
        mode, places = shown[int(now_s / MODE_S) % len(shown)]
        return shape_markers(mode, places, 2.0 * math.pi * now_s / TURN_S, self._base_frame)


def places_of(mode: Mode, names: tuple[str, ...], known: Mapping[str, Channel]) -> Places:
    """Return where the sensors are and how a mode moves them, the farthest by one.

    Parameters
    ----------
    mode : Mode
        Its shape has a row for each name.
    names : tuple of str
        Channels.
    known : mapping of name to Channel
        Those with a place; others are left out.
    """
    moved: dict[tuple[str, tuple[float, ...]], NDArray[np.complex128]] = {}
    for name, value in zip(names, mode.shape, strict=True):
        channel = known.get(name)
        if channel is not None and channel.frame_id and channel.is_straight:
            key = (channel.frame_id, tuple(channel.position_m))
            way = np.asarray(channel.direction) * value
            moved[key] = moved.get(key, np.zeros(3, complex)) + way
    farthest = max((float(np.linalg.norm(way)) for way in moved.values()), default=0.0)
    found: dict[str, list[tuple[NDArray[np.float64], NDArray[np.complex128]]]] = {}
    if farthest > 0.0:
        for (frame_id, at), way in moved.items():
            found.setdefault(frame_id, []).append((np.array(at), way / farthest))
    return found


def shape_markers(mode: Mode, places: Places, phase: float, base_frame: str) -> list[Marker]:
    """Return one picture: a line and a ball for each sensor, and which mode it is."""
    colour = COLOURS[mode.id % len(COLOURS)]
    turn = complex(math.cos(phase), math.sin(phase))
    markers = []
    for number, (frame_id, sensors) in enumerate(places.items()):
        tips = [place + SWING_M * (way * turn).real for place, way in sensors]
        line = _marker(Marker.LINE_LIST, SHAPE, number, frame_id, colour, LINE_M)
        ends = zip((place for place, _ in sensors), tips, strict=True)
        line.points = [_point(each) for each in itertools.chain.from_iterable(ends)]
        balls = _marker(Marker.SPHERE_LIST, REST, number, frame_id, colour, BALL_M)
        balls.points = [_point(each) for each in tips]
        markers += [line, balls]
    words = _marker(Marker.TEXT_VIEW_FACING, LABEL, 0, base_frame, (1.0, 1.0, 1.0), TEXT_M)
    words.pose.position.z = -ABOVE_M
    damping = f'{100.0 * mode.damping_ratio:.2g} %'
    words.text = f'mode {mode.id}: {mode.frequency_hz:.2f} Hz, {damping}'
    return [*markers, words]


def _marker(
    kind: int, group: str, number: int, frame_id: str, colour: tuple[float, ...], size_m: float
) -> Marker:
    marker = Marker(ns=group, id=number, type=kind, action=Marker.ADD)
    marker.header.frame_id = frame_id
    # Drawn where the link is now, whatever the time of the window: it goes with the arm.
    marker.frame_locked = True
    marker.pose.orientation.w = 1.0
    marker.scale.x = marker.scale.y = marker.scale.z = size_m
    marker.color.r, marker.color.g, marker.color.b, marker.color.a = (*colour, 1.0)
    return marker


def _point(place: Any) -> Point:
    x, y, z = place
    return Point(x=float(x), y=float(y), z=float(z))
