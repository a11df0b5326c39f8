"""What an emulated arm has and a model of it may lack: effects by name, with their figures."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
import math
from pathlib import Path
from types import MappingProxyType

from modal_core.errors import SettingsError
from modal_core.files.small_file import read_text
from modal_core.files.yaml_file import parse_yaml
from modal_core.settings.near_names import near, refuse_unknown

Vector = tuple[float, ...]
Value = float | str | Vector
NEEDED = math.nan
LARGEST_BYTES = 100_000
AXES = ('x', 'y', 'z')
PAIRS = ('xy', 'xz', 'yz')


@dataclass(frozen=True, slots=True)
class EffectKind:
    """One kind of effect.

    Parameters
    ----------
    text : str
        What it does, with units.
    place : str
        ``joint``, ``link``, ``sensor``, or empty.
    values : mapping of str to value
        Names and defaults; NaN must be given.
    """

    text: str
    place: str = ''
    values: Mapping[str, Value] = field(default_factory=dict)


def _kind(text: str, place: str = '', **values: Value) -> EffectKind:
    return EffectKind(text, place, MappingProxyType(values))


KINDS: Mapping[str, EffectKind] = MappingProxyType(
    {
        'payload': _kind(
            'mass [kg] fixed to a link, centre and radii of gyration [m]', 'link',
            mass=NEEDED, com=(0.0, 0.0, 0.0), gyration=(0.05, 0.05, 0.05),
        ),
        'joint_stiffness': _kind('factor on the drive spring', 'joint', factor=NEEDED),
        'joint_damping': _kind('factor on the drive damper', 'joint', factor=NEEDED),
        'base_compliance': _kind(
            'rocking compliance [rad/(N m)] under the base, loss time [s]',
            compliance=NEEDED, loss_time=4e-4,
        ),
        'link_flexibility': _kind(
            'hinge inside a link: place [m], axis, compliance [rad/(N m)], loss time [s]', 'link',
            compliance=NEEDED, position=(0.0, 0.0, 0.0), axis=(0.0, 1.0, 0.0), loss_time=4e-4,
        ),
        'rod_spring': _kind(
            'spring [N m/rad] over joints 2 and sign times 3, loss time [s]',
            stiffness=NEEDED, sign=1.0, loss_time=3e-4,
        ),
        'tuned_mass': _kind(
            'mass [kg] swinging at a frequency [Hz] along an axis of a link', 'link',
            mass=NEEDED, frequency=NEEDED, damping_ratio=0.04, position=(0.0, 0.0, 0.0),
            axis=(0.0, 0.0, 1.0),
        ),
        'servo_compliance': _kind(
            'every motor gives way behind its encoder, frequency [Hz]',
            frequency=NEEDED, damping_ratio=0.7,
        ),
        'coulomb_friction': _kind(
            'friction [N m] against the rate of the twist', 'joint', torque=NEEDED
        ),
        'backlash': _kind('half of the play [rad] of a gear', 'joint', half_gap=NEEDED),
        'cubic_stiffness': _kind('k y (1 + alpha y²), [1/rad²]', 'joint', alpha=NEEDED),
        'speed_dependent_stiffness': _kind(
            'k (1 + beta |speed of the axis|), [s/rad]', 'joint', beta=NEEDED
        ),
        'transmission_error': _kind(
            'sine and cosine [rad] of order [1/rad] of the axis angle in the gear', 'joint',
            sine=NEEDED, cosine=0.0, order=NEEDED,
        ),
        'tonal_disturbance': _kind(
            'torque [N m] at a frequency [Hz], phase [rad]', 'joint',
            frequency=NEEDED, torque=NEEDED, phase=0.0,
        ),
        'hysteresis': _kind(
            'a further share of the spring that slips (Dahl) at a twist [rad]', 'joint',
            share=NEEDED, limit=NEEDED,
        ),
        'presliding': _kind(
            'friction of the joint that sticks: a further share of the spring over angle of axis'
            ' and twist together, slips (Dahl) at a travel [rad]', 'joint',
            share=NEEDED, limit=NEEDED,
        ),
        'thermal_drift': _kind(
            'k (1 + change (1 - exp(-t / time_constant [s])))', 'joint',
            change=NEEDED, time_constant=NEEDED,
        ),
        'command_delay': _kind('the arm moves later than its joint states, [s]', delay=NEEDED),
        'sensor_gain': _kind('factor on all axes or one', 'sensor', gain=NEEDED, axis=''),
        'sensor_polarity': _kind('an axis reversed', 'sensor', axis='x'),
        'sensor_axis_swap': _kind('two axes exchanged', 'sensor', axes='xy'),
        'sensor_rotation': _kind(
            'readings turned by a rotation vector [rad]', 'sensor', rotation=(NEEDED,) * 3
        ),
        'sensor_delay': _kind('late by [s]; negative: early', 'sensor', delay=NEEDED),
        'sensor_mount_resonance': _kind(
            'a soft mount, frequency [Hz]', 'sensor',
            frequency=NEEDED, damping_ratio=0.05, axis='',
        ),
        'sensor_mass': _kind('mass [kg] of the sensor itself', 'sensor', mass=NEEDED),
    }
)  # fmt: skip
POSITIVE = frozenset(
    {
        'mass', 'factor', 'compliance', 'stiffness', 'frequency', 'damping_ratio', 'half_gap',
        'time_constant', 'limit', 'gain', 'order',
    }
)  # fmt: skip


@dataclass(frozen=True, slots=True)
class ArmEffect:
    """One effect of the emulated arm.

    Parameters
    ----------
    type : str
        A key of ``KINDS``.
    place : str
        Joint, link or sensor; empty when the kind has none.
    values : mapping of str to value
        Every value of the kind.
    """

    type: str
    place: str
    values: Mapping[str, Value]

    def number(self, name: str) -> float:
        """Return a number."""
        value = self.values[name]
        return value if isinstance(value, float) else math.nan

    def vector(self, name: str) -> tuple[float, float, float]:
        """Return a vector."""
        value = self.values[name]
        x, y, z = value if isinstance(value, tuple) else (math.nan,) * 3
        return x, y, z

    def text(self, name: str) -> str:
        """Return a text."""
        return str(self.values[name])

    def to_mapping(self) -> dict[str, object]:
        """Return what ``from_mapping`` reads: the label of a recording."""
        place = KINDS[self.type].place
        values = {
            name: list(value) if isinstance(value, tuple) else value
            for name, value in self.values.items()
        }
        return {'type': self.type, **({place: self.place} if place else {}), **values}

    @classmethod
    def from_mapping(cls, data: object) -> 'ArmEffect':
        """Read ``{type: ..., joint|link|sensor: ..., <value>: ...}``.

        Raises
        ------
        SettingsError
            Unknown type, a value missing, unknown or out of range.
        """
        if not isinstance(data, Mapping):
            raise SettingsError('not a mapping', where='effect', found=data)
        name = str(data.get('type', ''))
        kind = KINDS.get(name)
        if kind is None:
            raise SettingsError(
                'unknown effect', where='effect', found=name, expected=near(name, tuple(KINDS))
            )
        known = ('type', *((kind.place,) if kind.place else ()), *kind.values)
        refuse_unknown(data, known, 'unknown value', name)
        place = str(data.get(kind.place, '')) if kind.place else ''
        if kind.place and not place:
            raise SettingsError(f'{kind.place} missing', where=name)
        values = {
            key: _value(name, key, data.get(key, default), default)
            for key, default in kind.values.items()
        }
        return cls(name, place, MappingProxyType(values))


def _value(where: str, key: str, found: object, default: Value) -> Value:
    field_of = f'{where}.{key}'
    if isinstance(default, str):
        allowed = PAIRS if key == 'axes' else AXES if default else ('', *AXES)
        if found not in allowed:
            raise SettingsError('no such axis', where=field_of, found=found, expected=allowed)
        return str(found)
    if isinstance(default, tuple):
        items = list(found) if isinstance(found, (list, tuple)) else []
        numbers = tuple(_number(field_of, item) for item in items)
        if len(numbers) != len(default):
            raise SettingsError('bad vector', where=field_of, found=found, expected='3 numbers')
        return numbers
    number = _number(field_of, found)
    if key in POSITIVE and number <= 0.0:
        raise SettingsError('not positive', where=field_of, found=number)
    return number


def _number(where: str, found: object) -> float:
    try:
        # YAML 1.1 reads 3e-5 as a text.
        number = float(found) if isinstance(found, (int, float, str)) else math.nan
    except ValueError:
        number = math.nan
    if isinstance(found, bool) or not math.isfinite(number):
        raise SettingsError('missing, or not a number', where=where, found=found)
    return number


def read_effects(data: object) -> tuple[ArmEffect, ...]:
    """Read a list of effects, or YAML text of one, or the path of a file with one.

    Raises
    ------
    SettingsError
        Not a list, or one of them is wrong.
    """
    if isinstance(data, (str, Path)):
        data = _parsed(data)
    if data is None:
        return ()
    if not isinstance(data, Sequence) or isinstance(data, str):
        raise SettingsError('not a list of effects', where='effects', found=data)
    return tuple(
        item if isinstance(item, ArmEffect) else ArmEffect.from_mapping(item) for item in data
    )


def _parsed(text: str | Path) -> object:
    if not isinstance(text, Path) and (not text.strip() or text.lstrip()[0] in '[{-#'):
        data = parse_yaml(text, 'effects')
    else:
        path = Path(text)
        data = parse_yaml(read_text(path, LARGEST_BYTES), path)
    return data.get('effects') if isinstance(data, Mapping) else data
