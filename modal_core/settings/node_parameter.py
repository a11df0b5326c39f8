"""One parameter of a node: its name, words, default and range, known without ROS."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

from modal_core.errors import SettingsError
from modal_core.settings.near_names import refuse_unknown
from modal_core.settings.schema import is_of_kind, SettingField, settings_of, SWITCH, within

OF_ROS = ('use_sim_time', 'start_type_description_service')
"""Parameters that every node has; and those of single topics begin as the next."""
QOS_OVERRIDES = 'qos_overrides.'


@dataclass(frozen=True, slots=True)
class NodeParameter:
    """One parameter of a node.

    Parameters
    ----------
    name, text : str
        What it is; 0 or an empty text means "chosen by the node" where the text says so.
    default : value
        Also gives the type; a tuple is a list.
    low, high : float or None
        Range of a number.
    read_only : bool
        Cannot be changed while the node runs.
    kind : type or None
        Of the entries of a list that is empty by default.
    """

    name: str
    text: str
    default: Any
    low: float | None = None
    high: float | None = None
    read_only: bool = False
    kind: type | None = None

    @property
    def span(self) -> tuple[float, float] | None:
        """Range of a number; None: any."""
        return None if self.low is None or self.high is None else (self.low, self.high)

    @property
    def many(self) -> bool:
        """Whether it is a list."""
        return isinstance(self.default, tuple)

    def read(self, value: Any) -> Any:
        """Return a value from a file or a command line in the node's type: a float may be whole.

        Raises
        ------
        SettingsError
            Another type, or out of range.
        """
        if isinstance(value, list | tuple) != self.many:
            raise self._wrong_type(value)
        found = [self._entry(entry) for entry in (value if self.many else (value,))]
        return found if self.many else found[0]

    @property
    def _kind(self) -> type:
        return self.kind or type(self.default[0] if self.many else self.default)

    def _entry(self, value: Any) -> Any:
        if not is_of_kind(value, self._kind):
            raise self._wrong_type(value)
        # As the node itself: a range is of a number, not of a list's entries.
        if self.span is not None and not self.many:
            within(self.name, value, *self.span)
        return self._kind(value)

    def _wrong_type(self, value: object) -> SettingsError:
        name = self._kind.__name__
        expected = f'a list of {name}' if self.many else name
        return SettingsError('wrong type', where=self.name, found=repr(value), expected=expected)


def parameters_of(owner: type, prefix: str = '') -> tuple[NodeParameter, ...]:
    """Return the parameters of a dataclass of settings."""
    return tuple(_parameter(item, prefix) for item in settings_of(owner))


def checked_parameters(
    parameters: Iterable[NodeParameter], values: Mapping[str, Any], where: object
) -> dict[str, Any]:
    """Return parameters as a person gave them in the types of the node.

    Raises
    ------
    SettingsError
        A name that the node has not, another type, or out of range.
    """
    known = {item.name: item for item in parameters}
    own = {name: value for name, value in values.items() if not is_of_ros(name)}
    refuse_unknown(own, known, what='unknown parameter', where=where)
    return {
        name: known[name].read(value) if name in own else value for name, value in values.items()
    }


def is_of_ros(name: str) -> bool:
    """Return whether every node may be given this parameter."""
    return name in OF_ROS or name.startswith(QOS_OVERRIDES)


def _parameter(item: SettingField, prefix: str) -> NodeParameter:
    default, low, text = item.to_parameter(item.default), item.low, item.text
    if item.automatic:
        low = None if low is None else 0.0
        text += f'; {default}: {item.automatic}'
    if isinstance(default, str) and item.kind is bool:
        text += f' (one of {", ".join(SWITCH)})'
    kind = item.kind if item.many else None
    return NodeParameter(f'{prefix}{item.name}', text, default, low, item.high, kind=kind)
