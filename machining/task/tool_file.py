"""The tool as files tell it: modes by hand or of a map, modes of a tap test, or a response.

Whatever comes in is refused unless it is what it says: no number is guessed.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
import math
from pathlib import Path
import re
from typing import Any

import numpy as np
from numpy.typing import NDArray

from modal_core.errors import SettingsError
from modal_core.files.json_file import load_json
from modal_core.files.yaml_file import load_yaml
from modal_core.settings.near_names import refuse_unknown
from modal_core.tool_modes import PER_MODE, ToolModes

Real = NDArray[np.float64]
LARGEST_BYTES = 50_000_000
MOST_MODES = 200
EXPONENT = r'\d+(\.\d*)?[eE]\d+'
"""A number of YAML 1.2 that readers of YAML 1.1 take for a word."""
OWN = (
    'frequency_hz',
    'frequency_std_hz',
    'damping_ratio',
    'damping_ratio_std',
    'shape',
    'shape_std',
    'direction',
    'modal_mass_kg',
    'modal_mass_std_kg',
    'stiffness_n_m',
)


def read_tool_modes(path: str | Path, channels: Sequence[str] = ()) -> ToolModes:
    """Read the modes of a tool from YAML or JSON.

    Parameters
    ----------
    path : path
        ``modes``: a list of frequency_hz, damping_ratio and either ``shape`` at unit modal mass,
        or ``modal_mass_kg`` or ``stiffness_n_m`` with a ``direction``; σ beside each or one
        ``covariance`` of all.  Or modes.json of a tap test.
    channels : sequence of str
        Of a tap test: the channels along x, y and z of the tool; - where there is none.

    Raises
    ------
    SettingsError
        The file is no such one, or a mode has no mass.
    """
    path = Path(path)
    data: Any = load_json(path, LARGEST_BYTES) if path.suffix == '.json' else load_yaml(path)
    if not isinstance(data, Mapping) or not isinstance(data.get('modes'), list):
        raise SettingsError('no list of modes', where=path, expected='modes: [...]')
    if not 0 < len(data['modes']) <= MOST_MODES:
        raise SettingsError(
            'no number of modes', where=path, found=len(data['modes']), expected='1 to 200'
        )
    if 'shape_channels' in data:
        return _of_test(data, path, channels)
    if channels:
        raise SettingsError('only modes of a test have channels', where=path)
    refuse_unknown(data, ('modes', 'covariance', 'frame', 'pose_deg', 'file'), where=path)
    modes = [_own_mode(item, f'{path}, mode {at}') for at, item in enumerate(data['modes'], 1)]
    return _joined(modes, data.get('covariance'), path)


@dataclass(frozen=True, slots=True)
class _OneMode:
    """Log frequency, log damping ratio, shape; and their deviations, NaN where unknown."""

    parameters: Real
    covariance: Real | None


def _own_mode(item: object, where: str) -> _OneMode:
    if not isinstance(item, Mapping):
        raise SettingsError('not a mapping', where=where, found=item)
    refuse_unknown(item, OWN, where=where)
    frequency_hz = _number(item, 'frequency_hz', where, 0.0, 1e6)
    ratio = _number(item, 'damping_ratio', where, 0.0, 1.0)
    shape, mass_share = _shape(item, frequency_hz, where)
    own = np.concatenate([[math.log(frequency_hz), math.log(ratio)], shape])
    stated = [name for name in item if name.endswith(('_std', '_std_hz', '_std_kg'))]
    if not stated:
        return _OneMode(own, None)
    covariance = np.zeros((PER_MODE, PER_MODE))
    covariance[0, 0] = (_std(item, 'frequency_std_hz', where) / frequency_hz) ** 2
    covariance[1, 1] = (_std(item, 'damping_ratio_std', where) / ratio) ** 2
    covariance[2:, 2:] = np.diag(
        _vector(item.get('shape_std', (0, 0, 0)), 'shape_std', where) ** 2
    )
    covariance[2:, 2:] += (0.5 * mass_share) ** 2 * np.outer(shape, shape)
    return _OneMode(own, covariance)


def _shape(item: Mapping[str, Any], frequency_hz: float, where: str) -> tuple[Real, float]:
    """Return the shape at unit modal mass, and σ of the modal mass relative to it."""
    ways = [name for name in ('shape', 'modal_mass_kg', 'stiffness_n_m') if name in item]
    if len(ways) != 1:
        raise SettingsError(
            'no scale, or more than one',
            where=where,
            found=ways or None,
            expected='shape, or modal_mass_kg or stiffness_n_m with direction',
        )
    (way,) = ways
    if way == 'shape':
        return _vector(item['shape'], 'shape', where, needed=True), 0.0
    size = _number(item, way, where, 0.0, 1e12)
    direction = _vector(item.get('direction', ()), 'direction', where, needed=True)
    # Before the norm, whose squares may leave what numbers hold.
    direction = direction / np.max(np.abs(direction))
    mass = size if way == 'modal_mass_kg' else size / (2.0 * math.pi * frequency_hz) ** 2
    share = _std(item, 'modal_mass_std_kg', where) / mass
    return direction / np.linalg.norm(direction) / math.sqrt(mass), share


def _of_test(data: Mapping[str, Any], path: Path, channels: Sequence[str]) -> ToolModes:
    """Return the modes of a tap test at the channels of the tool."""
    names = data['shape_channels']
    if not isinstance(names, list):
        raise SettingsError('no list of channels', where=path, found=names)
    if len(channels) != 3:
        raise SettingsError(
            'where the tool is was not said',
            where=path,
            found=', '.join(channels) or None,
            expected=f'three of {", ".join(map(str, names[:12]))}, or - along an axis of none',
            advice='give --tool-channels x,y,z',
        )
    unknown = [name for name in channels if name != '-' and name not in names]
    if unknown or all(name == '-' for name in channels):
        raise SettingsError(
            'no such channel', where=path, found=unknown, expected=', '.join(map(str, names[:12]))
        )
    places = [None if name == '-' else names.index(name) for name in channels]
    modes = [
        _tested_mode(item, places, f'{path}, mode {at}')
        for at, item in enumerate(data['modes'], 1)
    ]
    return _joined(modes, None, path)


def _tested_mode(item: object, places: Sequence[int | None], where: str) -> _OneMode:
    if not isinstance(item, Mapping):
        raise SettingsError('not a mapping', where=where, found=item)
    if item.get('modal_mass_kg') is None:
        raise SettingsError(
            'a mode without modal mass',
            where=where,
            advice='only a tap test or a map has masses; an identification from motion alone '
            'tells no response',
        )
    frequency_hz = _number(item, 'frequency_hz', where, 0.0, 1e6)
    ratio = _number(item, 'damping_ratio', where, 0.0, 1.0)
    mass = _number(item, 'modal_mass_kg', where, 0.0, 1e12)
    entries = item.get('shape_real')
    longest = max(place for place in places if place is not None)
    if not isinstance(entries, list) or len(entries) <= longest:
        raise SettingsError('no shape', where=where)
    along = [0.0 if place is None else entries[place] for place in places]
    shape = _vector(along, 'shape_real', where, needed=True) / math.sqrt(mass)
    covariance = np.zeros((PER_MODE, PER_MODE))
    covariance[0, 0] = (_std(item, 'frequency_std_hz', where) / frequency_hz) ** 2
    covariance[1, 1] = (_std(item, 'damping_ratio_std', where) / ratio) ** 2
    share = _std(item, 'modal_mass_std_kg', where) / mass
    covariance[2:, 2:] = (0.5 * share) ** 2 * np.outer(shape, shape)
    own = np.concatenate([[math.log(frequency_hz), math.log(ratio)], shape])
    return _OneMode(own, covariance if covariance.any() else None)


def _joined(modes: Sequence[_OneMode], covariance: object, where: Path) -> ToolModes:
    """Return modes as one; what is known of some is not taken for all."""
    size = PER_MODE * len(modes)
    known: Real | None = None
    if covariance is not None:
        known = _matrix(covariance, size, where)
    elif all(mode.covariance is not None for mode in modes):
        known = np.zeros((size, size))
        for at, mode in enumerate(modes):
            part = slice(PER_MODE * at, PER_MODE * (at + 1))
            known[part, part] = mode.covariance
    elif any(mode.covariance is not None for mode in modes):
        raise SettingsError('σ of some modes only', where=where, expected='of all modes or none')
    own = np.array([mode.parameters for mode in modes])
    return ToolModes(np.exp(own[:, 0]), np.exp(own[:, 1]), own[:, 2:], known)


def _matrix(found: object, size: int, where: Path) -> Real:
    try:
        matrix = np.array(found, float)
    except (ValueError, TypeError) as error:
        raise SettingsError('covariance is no matrix', where=where) from error
    if matrix.shape != (size, size) or not np.isfinite(matrix).all():
        raise SettingsError(
            'covariance does not fit the modes',
            where=where,
            found=matrix.shape,
            expected=f'({size}, {size}): ln f, ln ζ, shape x, y, z of mode after mode',
        )
    if not np.allclose(matrix, matrix.T, rtol=1e-6, atol=1e-9 * np.abs(matrix).max()):
        raise SettingsError('covariance is not symmetric', where=where)
    return np.asarray(0.5 * (matrix + matrix.T))


def _number(item: Mapping[str, Any], name: str, where: str, above: float, up_to: float) -> float:
    value = item.get(name)
    if isinstance(value, str) and re.fullmatch(EXPONENT, value):
        value = float(value)
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise SettingsError('no number', where=f'{where}: {name}', found=value)
    if not above < value <= up_to:
        raise SettingsError(
            'out of range', where=f'{where}: {name}', found=value, expected=f'> 0, <= {up_to:g}'
        )
    return float(value)


def _std(item: Mapping[str, Any], name: str, where: str) -> float:
    """Return a standard deviation, 0 where it is not given."""
    return 0.0 if item.get(name) in (None, 0, 0.0) else _number(item, name, where, 0.0, 1e12)


def _vector(found: object, name: str, where: str, needed: bool = False) -> Real:
    try:
        vector = np.array(found, float)
    except (ValueError, TypeError) as error:
        raise SettingsError('no vector', where=f'{where}: {name}', found=found) from error
    if vector.shape != (3,) or not np.isfinite(vector).all() or (needed and not vector.any()):
        raise SettingsError('no vector', where=f'{where}: {name}', found=found, expected='x, y, z')
    return vector
