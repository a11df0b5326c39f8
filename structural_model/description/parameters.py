"""Every number of a model spec under a dotted name, to read and to change."""

from collections.abc import Mapping
import dataclasses
from typing import Any

from modal_core.errors import ModelError
from structural_model.description.spec import ModelSpec


def read_parameters(spec: ModelSpec) -> dict[str, float]:
    """Return all numbers of a spec by dotted name.

    Entries of a tuple go by their ``name`` when they have one, else by their index:
    ``joints.joint_2.tilts.0.stiffness``, ``masses.spindle.mass_kg``.
    """
    found: dict[str, float] = {}
    _collect(spec, '', found)
    return found


def write_parameters(spec: ModelSpec, values: Mapping[str, float]) -> ModelSpec:
    """Return a copy with some numbers changed.

    Raises
    ------
    ModelError
        A name is unknown, or a value is not a number.
    """
    for name, value in values.items():
        try:
            spec = _changed(spec, name.split('.'), float(value))
        except (KeyError, IndexError, AttributeError, TypeError, ValueError) as error:
            raise ModelError(
                'unknown model parameter',
                found=name,
                expected='a name of parameters(), like joints.<joint>.drive.spring.stiffness',
            ) from error
    return spec


def _collect(item: Any, name: str, found: dict[str, float]) -> None:
    if isinstance(item, bool | str) or item is None:
        return
    if isinstance(item, int | float):
        found[name] = float(item)
    elif isinstance(item, tuple):
        for index, entry in enumerate(item):
            _collect(entry, f'{name}.{getattr(entry, "name", index)}', found)
    elif dataclasses.is_dataclass(item):
        for field in dataclasses.fields(item):
            path = f'{name}.{field.name}' if name else field.name
            if field.name != 'name':
                _collect(getattr(item, field.name), path, found)


def _changed(item: Any, path: list[str], value: float) -> Any:
    if not path:
        if isinstance(item, bool) or not isinstance(item, int | float):
            raise TypeError(item)
        return int(value) if isinstance(item, int) else value
    head, rest = path[0], path[1:]
    if isinstance(item, tuple):
        names = [getattr(entry, 'name', str(index)) for index, entry in enumerate(item)]
        place = names.index(head)
        return (*item[:place], _changed(item[place], rest, value), *item[place + 1 :])
    return dataclasses.replace(item, **{head: _changed(getattr(item, head), rest, value)})
