"""What a setting is, written once beside its default: words, range and what None means.

Node parameters, command-line options, checks and the documents' tables are made from it.
"""

from collections.abc import Mapping
from dataclasses import dataclass, Field, field, fields
import math
from types import NoneType
from typing import Any, get_args, get_type_hints

from modal_core.errors import SettingsError

SWITCH = {'auto': None, 'always': True, 'never': False}
"""What a node calls a switch that may be left to the program: its parameters know no None."""


@dataclass(frozen=True, slots=True)
class Setting:
    """One field of a dataclass of settings.

    Parameters
    ----------
    name, text : str
        What it is called and what it means, with its unit.
    kind : type
        float, int, str or bool.
    default : value
        None where the program chooses.
    low, high : float or None
        Range of a number.
    automatic : str
        What None means; empty: None is not allowed.
    """

    name: str
    text: str
    kind: type
    default: Any
    low: float | None
    high: float | None
    automatic: str

    def check(self, value: Any) -> None:
        """Refuse a number out of range.

        Raises
        ------
        SettingsError
            Naming the setting, the value and the range.
        """
        if value is not None and self.low is not None and self.high is not None:
            within(self.name, value, self.low, self.high)

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
        return (value or None) if self.automatic else value


def setting(
    default: Any,
    text: str,
    low: float | None = None,
    high: float | None = None,
    automatic: str = '',
) -> Any:
    """Return a dataclass field that is a setting; see :class:`Setting`."""
    words = {'text': text, 'low': low, 'high': high, 'automatic': automatic}
    return field(default=default, metadata=words)


def settings_of(owner: type) -> tuple[Setting, ...]:
    """Return the settings of a dataclass, in order."""
    kinds = get_type_hints(owner)
    return tuple(_setting(item, kinds[item.name]) for item in fields(owner) if item.metadata)


def parameter_values(settings: Any) -> dict[str, Any]:
    """Return settings as a node's parameters."""
    return {
        item.name: item.to_parameter(getattr(settings, item.name))
        for item in settings_of(type(settings))
    }


def from_parameters(owner: type, values: Mapping[str, Any]) -> dict[str, Any]:
    """Return keywords of a dataclass of settings from a node's parameters.

    Raises
    ------
    SettingsError
        A switch is set to an unknown word.
    """
    return {item.name: item.from_parameter(values[item.name]) for item in settings_of(owner)}


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


def _setting(item: Field[Any], hint: Any) -> Setting:
    kind = next((part for part in get_args(hint) if part is not NoneType), hint)
    return Setting(name=item.name, kind=kind, default=item.default, **item.metadata)
