"""Modes of a recording, of whatever it was kept as: the recording itself, or its modes.json."""

from collections.abc import Mapping
import math
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from autonomous_modal_analysis.api.recording import open_recording
from autonomous_modal_analysis.option_groups import Identifier
from autonomous_modal_analysis.output import show_damage
from autonomous_modal_analysis.terminal import progress_bar
from modal_core.errors import RecordingError, SettingsError
from modal_core.json_file import load_json
from modal_core.mode import Mode, ModeSet

RESULTS = 'modes.json'
LARGEST_BYTES = 500_000_000
LOWEST_HZ, HIGHEST_HZ = 1e-6, 1e7
ROUNDING = 1e-9


def results_file(path: Path) -> Path | None:
    """Return the modes.json a path means; None where it means a recording."""
    if path.is_dir() and (path / RESULTS).is_file():
        return path / RESULTS
    return path if path.suffix == '.json' else None


def modes_of(path: Path, identifier: Identifier) -> ModeSet:
    """Return the modes of a recording, or of results that were kept.

    Raises
    ------
    ModalAnalysisError
        It cannot be read or identified.
    """
    kept = results_file(path)
    if kept is not None:
        return read_modes(kept)
    with progress_bar(f'identifying {path.name}') as progress:
        found = identifier.identify(open_recording(path), progress)
    show_damage(found.damage)
    return found.modes


def read_modes(path: Path) -> ModeSet:
    """Read the modes of the whole recording from what `ama identify` wrote.

    Raises
    ------
    RecordingError
        It cannot be read, or is no such file.
    """
    try:
        found: Any = load_json(path, LARGEST_BYTES)
        names = tuple(str(name) for name in found['shape_channels'])
        modes = tuple(_mode(item, len(names)) for item in found['modes'])
        method = str(found['settings'].get('method', 'ssi_cov'))
    except SettingsError as error:
        raise _no_results(error.where, error.what) from error
    except (ValueError, KeyError, TypeError, AttributeError, OverflowError) as error:
        raise _no_results(path, f'{type(error).__name__}: {error}') from error
    if len(set(names)) != len(names):
        raise RecordingError('channel named twice', where=path)
    return ModeSet(tuple(sorted(modes, key=lambda mode: mode.frequency_hz)), names, method)


def _no_results(where: object, found: str) -> RecordingError:
    return RecordingError(
        'not the results of an identification',
        where=where,
        found=found,
        expected='modes.json as `ama identify --out` or `--json` writes it, or a recording',
    )


def _mode(item: Mapping[str, Any], n_channels: int) -> Mode:
    """Return a mode as it was written; nothing but what an identification can find is one."""

    def number(name: str, low: float, high: float = math.inf, known: bool = False) -> float:
        if item[name] is None and not known:
            return math.nan
        value = math.nan if isinstance(item[name], bool | str) else float(item[name])
        if not (math.isfinite(value) and low <= value <= high):
            raise ValueError(f'{name} {item[name]}, expected {low:g} to {high:g}')
        return value

    real, imaginary = (np.asarray(item[f'shape_{part}'], dtype=float) for part in ('real', 'imag'))
    if real.shape != (n_channels,) or imaginary.shape != (n_channels,):
        raise ValueError(f'no shape of {n_channels} channels')
    shape = _entries(real, imaginary)
    if np.isinf(shape).any() or not np.nan_to_num(shape).any():
        raise ValueError('shape not finite, or zero')
    return Mode(
        frequency_hz=number('frequency_hz', LOWEST_HZ, HIGHEST_HZ, known=True),
        damping_ratio=number('damping_ratio', 0.0, 1.0, known=True),
        shape=shape,
        frequency_std_hz=number('frequency_std_hz', 0.0),
        damping_ratio_std=number('damping_ratio_std', 0.0),
        mpc=number('mpc', 0.0, 1.0 + ROUNDING),
        mpd=number('mpd', 0.0, math.pi),
        id=int(number('id', 0.0, 2.0**31, known=True)),
        shape_std=_deviations(item, n_channels),
        mac_loss=number('mac_loss', 0.0) if 'mac_loss' in item else math.nan,
        mac_loss_std=number('mac_loss_std', 0.0) if 'mac_loss_std' in item else math.nan,
    )


def _deviations(item: Mapping[str, Any], n_channels: int) -> NDArray[np.complex128] | None:
    """Return the deviations of a shape; None where they are not known."""
    parts = [item.get(f'shape_std_{part}') for part in ('real', 'imag')]
    if parts == [None, None]:
        return None
    real, imaginary = (np.asarray(part, dtype=float) for part in parts)
    if real.shape != (n_channels,) or imaginary.shape != (n_channels,):
        raise ValueError(f'no deviations of a shape of {n_channels} channels')
    std = _entries(real, imaginary)
    if np.isinf(std).any() or (real < 0.0).any() or (imaginary < 0.0).any():
        raise ValueError('deviations of a shape not finite, or negative')
    return std


def _entries(real: NDArray[np.float64], imaginary: NDArray[np.float64]) -> NDArray[np.complex128]:
    """Return complex numbers, NaN where both parts are: points that were not seen."""
    if not np.array_equal(np.isnan(real), np.isnan(imaginary)):
        raise ValueError('shape not finite')
    return np.asarray(real + 1j * imaginary)
