"""Settings with one value an axis, for an arm that has other than six."""

from dataclasses import fields, replace
from typing import Any, TypeVar

import numpy as np

from modal_core.errors import SettingsError

Settings = TypeVar('Settings')


def of_axes(settings: Settings, n_axes: int) -> Settings:
    """Return settings with as many values in each list as an arm has axes.

    Defaults begin anew behind the sixth axis; what was set is never guessed for others.

    Parameters
    ----------
    settings : dataclass
        Its tuples have a value for each axis.
    n_axes : int
        Of the arm.

    Raises
    ------
    SettingsError
        A list was set for another number of axes.
    """
    change: dict[str, Any] = {}
    for field in fields(settings):  # type: ignore[arg-type]
        value = getattr(settings, field.name)
        if not isinstance(value, tuple) or len(value) == n_axes:
            continue
        if value != field.default:
            raise SettingsError(
                'wrong length',
                where=field.name,
                found=len(value),
                expected=f'{n_axes} axes',
                advice='leave it out; effects of gears are given by joint',
            )
        change[field.name] = tuple(np.resize(value, n_axes).tolist())
    return replace(settings, **change)  # type: ignore[type-var]
