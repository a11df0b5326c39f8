"""What a setting is, written once beside its default: words, range and what None means.

Node parameters, command-line options, checks of YAML and the documents' tables are made from it.
"""

from collections.abc import Mapping
from dataclasses import dataclass, Field, field, fields
import math
from numbers import Integral, Real
from pathlib import Path
from types import NoneType
from typing import Any, get_args, get_origin, get_type_hints

from modal_core.errors import SettingsError
from modal_core.settings.near_names import refuse_unknown

SWITCH = {'auto': None, 'always': True, 'never': False}
"""What a node calls a switch that may be left to the program: its parameters know no None."""
KINDS: dict[type, Any] = {float: Real, int: Integral, bool: bool, str: (str, Path)}
BEYOND_FLOAT = 2**1024
"""The least whole number that float64 does not hold (IEEE 754)."""


@dataclass(frozen=True, slots=True)
class SettingField:
    """One field of a dataclass of settings.

    Parameters
    ----------
    name, text : str
        What it is called and what it means, with its unit.
    kind : type
        float, int, str or bool; of a list that of its entries.
    default : value
        None where the program chooses.
    low, high : float or None
        Range of a number.
    automatic : str
        What None means; empty: None is not allowed.
    many : bool
        A list, as long as its default unless that is empty.
    """

    name: str
    text: str
    kind: type
    default: Any
    low: float | None
    high: float | None
    automatic: str
    many: bool

    def check(self, value: Any, group: str = '') -> None:
        """Refuse a value of another kind, or a number out of range.

        Raises
        ------
        SettingsError
            Naming the setting, the value and the range.
        """
        where = f'{group}{self.name}'
        if value is None and self.automatic:
            return
        if self.many != isinstance(value, tuple):
            raise self._wrong_kind(value, where)
        entries = value if self.many else (value,)
        for entry in entries:
            if not is_of_kind(entry, self.kind):
                raise self._wrong_kind(value, where)
            if self.kind is float and not math.isfinite(entry) and self.low is None:
                raise self._wrong_kind(value, where)
            if self.low is not None and self.high is not None:
                within(where, entry, self.low, self.high)
        if self.many and self.default and len(entries) != len(self.default):
            raise SettingsError(
                'wrong length', where=where, found=len(entries), expected=len(self.default)
            )

    def read(self, value: Any, group: str = '') -> Any:
        """Return a value as YAML has it as the settings want it.

        Raises
        ------
        SettingsError
            It is of another kind or out of range.
        """
        found = tuple(value) if self.many and isinstance(value, list) else value
        self.check(found, group)
        if self.many or found is None:
            return tuple(self.kind(entry) for entry in found) if self.many else None
        return self.kind(found)

    def to_parameter(self, value: Any) -> Any:
        """Return a value as a node's parameter, which cannot be None."""
        if self.kind is bool and self.automatic:
            return next(word for word, meant in SWITCH.items() if meant is value)
        return self.kind() if value is None else value

    def from_parameter(self, value: Any) -> Any:
        """Return a node's parameter as a value.

        Raises
        ------
        SettingsError
            A switch is set to an unknown word.
        """
        if self.kind is bool and self.automatic:
            if value not in SWITCH:
                raise SettingsError(
                    'unknown word', where=self.name, found=value, expected=', '.join(SWITCH)
                )
            return SWITCH[value]
        if self.many:
            return tuple(value)
        return (value or None) if self.automatic else value

    def _wrong_kind(self, value: object, where: str) -> SettingsError:
        return SettingsError(
            'wrong kind of value', where=where, found=repr(value), expected=self.text
        )


def setting(
    default: Any,
    text: str,
    low: float | None = None,
    high: float | None = None,
    automatic: str = '',
) -> Any:
    """Return a dataclass field that is a setting; see :class:`SettingField`."""
    words = {'text': text, 'low': low, 'high': high, 'automatic': automatic}
    return field(default=default, metadata=words)


def settings_of(owner: type) -> tuple[SettingField, ...]:
    """Return the settings of a dataclass, in order."""
    kinds = get_type_hints(owner)
    return tuple(_setting(item, kinds[item.name]) for item in fields(owner) if item.metadata)


def check_settings(settings: Any, group: str = '') -> None:
    """Refuse settings with a value of another kind or out of range.

    Raises
    ------
    SettingsError
        Naming the setting, the value and the range.
    """
    for item in settings_of(type(settings)):
        item.check(getattr(settings, item.name), group)


def read_values(owner: type, data: object, where: object = '', group: str = '') -> dict[str, Any]:
    """Return keywords of a dataclass of settings from a mapping as YAML holds it.

    Parameters
    ----------
    owner : type
        Dataclass of settings.
    data : mapping
        Name to value; what is not named is left out.
    where : object
        File or option, for errors about names.
    group : str
        Written before a setting's name in errors about values.

    Raises
    ------
    SettingsError
        Not a mapping, a name that is no setting, or a value that does not fit.
    """
    if not isinstance(data, Mapping):
        raise SettingsError('not a mapping', where=where, found=data)
    known = {item.name: item for item in settings_of(owner)}
    refuse_unknown(data, known, where=where)
    return {name: known[name].read(value, group) for name, value in data.items()}


def parameter_values(settings: Any) -> dict[str, Any]:
    """Return settings as a node's parameters."""
    return {
        item.name: item.to_parameter(getattr(settings, item.name))
        for item in settings_of(type(settings))
    }


def from_parameters(owner: type, values: Mapping[str, Any], prefix: str = '') -> dict[str, Any]:
    """Return keywords of a dataclass of settings from a node's parameters.

    Parameters
    ----------
    owner : type
        Dataclass of settings.
    values : mapping
        Name of a parameter to its value.
    prefix : str
        What stands before the settings' names there.

    Raises
    ------
    SettingsError
        A switch is set to an unknown word.
    """
    return {
        item.name: item.from_parameter(values[prefix + item.name]) for item in settings_of(owner)
    }


def is_of_kind(value: object, kind: type) -> bool:
    """Tell whether a value is a float (which may be whole), int, bool or text (or path).

    A whole number beyond floating-point numbers is none.
    """
    if not isinstance(value, KINDS[kind]) or (kind is not bool and isinstance(value, bool)):
        return False
    return not isinstance(value, int) or abs(value) < BEYOND_FLOAT


def within(name: str, value: float, low: float, high: float) -> None:
    """Refuse a number out of range.

    Raises
    ------
    SettingsError
        Naming the field, the value and the range.
    """
    if not math.isfinite(value) or not low <= value <= high:
        raise SettingsError(
            'out of range', where=name, found=value, expected=f'{low:g} to {high:g}'
        )


def _setting(item: Field[Any], hint: Any) -> SettingField:
    kind = next((part for part in get_args(hint) if part not in (NoneType, ...)), hint)
    many = get_origin(hint) is tuple
    return SettingField(item.name, kind=kind, default=item.default, many=many, **item.metadata)
