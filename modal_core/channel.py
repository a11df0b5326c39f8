"""A channel is one axis of one sensor; a sensor layout is all channels and where they sit."""

from collections.abc import Collection, Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from itertools import compress
import math

from modal_core.errors import LayoutError
from modal_core.settings.near_names import refuse_unknown
from modal_core.units import ACCELERATION, DISPLACEMENT, response_unit, TIMES_DERIVED, VELOCITY

AXES = {'x': (1.0, 0.0, 0.0), 'y': (0.0, 1.0, 0.0), 'z': (0.0, 0.0, 1.0)}
LAYOUT_FILE = 'sensors.yaml'
"""A sensor layout's file: beside a robot, in a campaign, inside a recording."""
Vector = tuple[float, float, float]


@dataclass(frozen=True, slots=True)
class Channel:
    """One sensor axis.

    Parameters
    ----------
    name : str
        Unique name, for example ``elbow.x``.
    frame_id : str
        Link the sensor is fixed to; empty when unknown.
    direction : (3,) tuple
        What the channel reads per unit motion along x, y and z of the frame: a unit vector when
        its gain is 1.
    position_m : (3,) tuple [m]
        Place of the sensor in the frame.
    unit : str
        SI unit of the samples, which says what they measure (`modal_core.units`).
    scale : float
        From what its source sends to that unit.
    delay_s : float [s]
        By how much the samples are later than their stamps.
    since_ns : int [ns]
        Time since when the channel is what it is; before it was plugged, mounted or amplified
        otherwise.  0: always.
    """

    name: str
    frame_id: str = ''
    direction: Vector = AXES['x']
    position_m: Vector = (0.0, 0.0, 0.0)
    unit: str = ACCELERATION
    scale: float = 1.0
    delay_s: float = 0.0
    since_ns: int = 0

    @property
    def sensor(self) -> str:
        """What it shares its clock with: axes of a sensor are ``<name>.<axis>``."""
        return self.name.rpartition('.')[0] or self.name

    @property
    def times_derived(self) -> int:
        """How often what it measures was differentiated: 2 of an acceleration."""
        return TIMES_DERIVED[self.unit]

    @property
    def is_straight(self) -> bool:
        """Whether it measures motion along its direction, no rotation and no strain."""
        return self.unit in (ACCELERATION, VELOCITY, DISPLACEMENT)


@dataclass(frozen=True, slots=True)
class Sensor:
    """One device with one or more axes; the YAML layout lists these.

    Parameters
    ----------
    name : str
        Unique name; channels are called ``<name>.<axis>``.
    frame_id : str
        Link the device is fixed to.
    position_m : (3,) tuple [m]
        Place of the device in the frame.
    axes : tuple of str
        Sensitive axes, out of x, y, z.
    rotation_quaternion : (4,) tuple
        Rotation from sensor axes to the frame as (x, y, z, w).
    topic : str
        Topic of a per-sample device; empty for channels of an AccelerationBlock.
    sensitivity : tuple of (3,) tuple
        One vector per axis, instead of the rotation, for a device with gains, swapped or reversed
        axes: what the axis reads per unit motion along x, y and z of the frame.  Empty: none.
    delay_s : float [s]
        By how much its samples are later than their stamps.
    unit : str
        Unit of what it sends (m/s^2, g, mm/s, um, rad/s, ...), which says what it measures.
    """

    name: str
    frame_id: str
    position_m: Vector = (0.0, 0.0, 0.0)
    axes: tuple[str, ...] = ('x', 'y', 'z')
    rotation_quaternion: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 1.0)
    topic: str = ''
    sensitivity: tuple[Vector, ...] = ()
    delay_s: float = 0.0
    unit: str = ACCELERATION

    def channels(self) -> tuple[Channel, ...]:
        """Return one channel per sensitive axis."""
        directions = self.sensitivity or tuple(
            rotate(self.rotation_quaternion, AXES[axis]) for axis in self.axes
        )
        unit = response_unit(self.unit, f'sensor {self.name}', LayoutError)
        return tuple(
            Channel(
                name=f'{self.name}.{axis}',
                frame_id=self.frame_id,
                direction=direction,
                position_m=self.position_m,
                unit=unit.si,
                scale=unit.factor,
                delay_s=self.delay_s,
            )
            for axis, direction in zip(self.axes, directions, strict=True)
        )

    def to_mapping(self) -> dict[str, object]:
        """Return the sensor as the YAML layout lists it, fields at their defaults left out."""
        entry: dict[str, object] = {
            'name': self.name,
            'frame_id': self.frame_id,
            'position_m': list(self.position_m),
        }
        if self.axes != tuple(AXES):
            entry['axes'] = list(self.axes)
        if self.sensitivity:
            entry['sensitivity'] = {
                axis: list(vector)
                for axis, vector in zip(self.axes, self.sensitivity, strict=True)
            }
        elif self.rotation_quaternion != (0.0, 0.0, 0.0, 1.0):
            entry['rotation_quaternion'] = list(self.rotation_quaternion)
        if self.delay_s:
            entry['delay_s'] = self.delay_s
        if self.unit != ACCELERATION:
            entry['unit'] = self.unit
        if self.topic:
            entry['topic'] = self.topic
        return entry


@dataclass(frozen=True, slots=True)
class SensorLayout:
    """All sensors of one cell.

    Parameters
    ----------
    sensors : tuple of Sensor
        In the order their channels appear.
    name : str
        What to call the layout, usually its file.
    """

    sensors: tuple[Sensor, ...]
    name: str = ''

    @property
    def channels(self) -> tuple[Channel, ...]:
        """All channels, sensor after sensor."""
        return tuple(channel for sensor in self.sensors for channel in sensor.channels())

    def __iter__(self) -> Iterator[Sensor]:
        """Iterate over the sensors."""
        return iter(self.sensors)

    def channel(self, name: str) -> Channel:
        """Return the channel of this name.

        Raises
        ------
        LayoutError
            There is none.
        """
        for channel in self.channels:
            if channel.name == name:
                return channel
        raise LayoutError('unknown channel', where=self.name, found=name)

    def only(self, names: Collection[str]) -> 'SensorLayout':
        """Return the layout of the channels that are named, in its own order."""
        sensors = []
        for sensor in self.sensors:
            kept = [f'{sensor.name}.{axis}' in names for axis in sensor.axes]
            if any(kept):
                axes = tuple(compress(sensor.axes, kept))
                vectors = tuple(compress(sensor.sensitivity, kept))
                sensors.append(replace(sensor, axes=axes, sensitivity=vectors))
        return SensorLayout(tuple(sensors), self.name)

    def check_links(self, links: Iterable[str], robot: str) -> None:
        """Refuse a sensor on a link the robot does not have.

        Raises
        ------
        LayoutError
            Naming sensor, link and the links there are.
        """
        known = tuple(links)
        for sensor in self.sensors:
            if sensor.frame_id not in known:
                raise LayoutError(
                    f'sensor {sensor.name} sits on an unknown link',
                    where=self.name,
                    found=sensor.frame_id,
                    expected=f'a link of {robot}: {", ".join(known)}',
                )

    def to_mapping(self) -> dict[str, object]:
        """Return the content of a layout file; ``from_mapping`` gives the same layout."""
        return {'sensors': [sensor.to_mapping() for sensor in self.sensors]}

    @classmethod
    def from_mapping(cls, data: object, name: str = '') -> 'SensorLayout':
        """Build a layout from a parsed YAML mapping with a ``sensors`` list.

        Raises
        ------
        LayoutError
            Naming the sensor and field that is missing, unknown or malformed.
        """
        mapping = data if isinstance(data, Mapping) else {}
        entries = mapping.get('sensors')
        if not isinstance(entries, list) or not entries:
            raise LayoutError('no sensors', where=name, expected='a non-empty list "sensors"')
        refuse_unknown(mapping, ('sensors',), where=name, error=LayoutError)
        sensors = tuple(_sensor(entry, index, name) for index, entry in enumerate(entries))
        names = [sensor.name for sensor in sensors]
        for sensor_name in names:
            if names.count(sensor_name) > 1:
                raise LayoutError('sensor named twice', where=name, found=sensor_name)
        return cls(sensors=sensors, name=name)


def rotate(quaternion: tuple[float, float, float, float], vector: Vector) -> Vector:
    """Rotate a vector by a unit quaternion (x, y, z, w)."""
    x, y, z, w = quaternion
    vx, vy, vz = vector
    # v + 2 q x (q x v + w v)
    cx, cy, cz = y * vz - z * vy + w * vx, z * vx - x * vz + w * vy, x * vy - y * vx + w * vz
    return (
        vx + 2.0 * (y * cz - z * cy),
        vy + 2.0 * (z * cx - x * cz),
        vz + 2.0 * (x * cy - y * cx),
    )


FIELDS = (
    'name', 'frame_id', 'position_m', 'axes', 'rotation_quaternion', 'topic', 'sensitivity',
    'delay_s', 'unit',
)  # fmt: skip


def _sensor(entry: object, index: int, where: str) -> Sensor:
    field_of = f'{where}: sensors[{index}]'
    if not isinstance(entry, Mapping):
        raise LayoutError('not a mapping', where=field_of, found=repr(entry))
    refuse_unknown(entry, FIELDS, where=field_of, error=LayoutError)
    for key in ('name', 'frame_id'):
        if not isinstance(entry.get(key), str) or not entry[key]:
            raise LayoutError(f'{key} missing', where=field_of, expected='a non-empty text')
    position = _numbers(entry.get('position_m', (0.0, 0.0, 0.0)), 3, f'{field_of}.position_m')
    quaternion = _numbers(
        entry.get('rotation_quaternion', (0.0, 0.0, 0.0, 1.0)),
        4,
        f'{field_of}.rotation_quaternion',
    )
    norm = math.hypot(*quaternion)
    if not math.isclose(norm, 1.0, abs_tol=1e-3):
        raise LayoutError(
            'not a unit quaternion', where=f'{field_of}.rotation_quaternion', found=f'norm {norm}'
        )
    axes = tuple(entry.get('axes', ('x', 'y', 'z')))
    if not axes or len(set(axes)) != len(axes) or any(axis not in AXES for axis in axes):
        raise LayoutError('bad axes', where=f'{field_of}.axes', found=axes, expected='of x, y, z')
    return Sensor(
        name=entry['name'],
        frame_id=entry['frame_id'],
        position_m=(position[0], position[1], position[2]),
        axes=axes,
        rotation_quaternion=(
            quaternion[0] / norm,
            quaternion[1] / norm,
            quaternion[2] / norm,
            quaternion[3] / norm,
        ),
        topic=str(entry.get('topic', '')),
        sensitivity=_sensitivity(entry, axes, field_of),
        delay_s=_numbers([entry.get('delay_s', 0.0)], 1, f'{field_of}.delay_s')[0],
        unit=_unit(entry.get('unit', ACCELERATION), f'{field_of}.unit'),
    )


def _unit(text: object, where: str) -> str:
    if not isinstance(text, str):
        raise LayoutError('not a unit', where=where, found=text, expected='a text such as g')
    response_unit(text, where, LayoutError)
    return text


def _sensitivity(
    entry: Mapping[str, object], axes: tuple[str, ...], where: str
) -> tuple[Vector, ...]:
    table = entry.get('sensitivity')
    if table is None:
        return ()
    place = f'{where}.sensitivity'
    if not isinstance(table, Mapping) or set(table) != set(axes):
        raise LayoutError(
            'not one vector per axis', where=place, found=table, expected=', '.join(axes)
        )
    if 'rotation_quaternion' in entry:
        raise LayoutError('sensitivity and rotation_quaternion exclude each other', where=place)
    found = []
    for axis in axes:
        x, y, z = _numbers(table[axis], 3, f'{place}.{axis}')
        if x == y == z == 0.0:
            raise LayoutError('a channel that reads nothing', where=f'{place}.{axis}')
        found.append((x, y, z))
    return tuple(found)


def _numbers(value: object, count: int, where: str) -> tuple[float, ...]:
    try:
        numbers = tuple(float(item) for item in value)  # type: ignore[attr-defined]
    except (TypeError, ValueError):
        numbers = ()
    if len(numbers) != count or not all(math.isfinite(number) for number in numbers):
        raise LayoutError('bad vector', where=where, found=value, expected=f'{count} numbers')
    return numbers
