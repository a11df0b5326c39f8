"""Modes of a recording, of whatever it was kept as: the recording itself, or its modes.json."""

from collections.abc import Mapping
import json
import math
from pathlib import Path
from typing import Any

import numpy as np

from autonomous_modal_analysis.identification import identify_recording
from autonomous_modal_analysis.option_groups import Identifier
from autonomous_modal_analysis.output import show_damage
from autonomous_modal_analysis.terminal import progress_bar
from modal_core.errors import RecordingError
from modal_core.mode import Mode, ModeSet
from recordings.open_recording import open_recording

RESULTS = 'modes.json'
LARGEST_BYTES = 500_000_000


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
        found = identify_recording(
            open_recording(path),
            identifier.settings(),
            identifier.sensors(),
            progress,
            identifier.model(),
        )
    show_damage(found.identification.damage)
    return found.identification.modes


def read_modes(path: Path) -> ModeSet:
    """Read the modes of the whole recording from what `ama identify` wrote.

    Raises
    ------
    RecordingError
        It cannot be read, or is no such file.
    """
    try:
        if path.stat().st_size > LARGEST_BYTES:
            raise RecordingError('file too large', where=path)
        found: Any = json.loads(path.read_text(encoding='utf-8'))
        names = tuple(str(name) for name in found['shape_channels'])
        modes = tuple(_mode(item) for item in found['modes'])
        method = str(found['settings'].get('method', 'ssi_cov'))
    except OSError as error:
        raise RecordingError(f'cannot be read: {error.strerror}', where=path) from error
    except (ValueError, KeyError, TypeError, AttributeError) as error:
        raise RecordingError(
            'not the results of an identification',
            where=path,
            found=f'{type(error).__name__}: {error}',
            expected='modes.json as `ama identify --out` or `--json` writes it, or a recording',
        ) from error
    if any(len(mode.shape) != len(names) for mode in modes):
        raise RecordingError('shapes do not fit the channels', where=path)
    return ModeSet(modes, names, method)


def _mode(item: Mapping[str, Any]) -> Mode:
    def number(name: str) -> float:
        return math.nan if item[name] is None else float(item[name])

    return Mode(
        frequency_hz=number('frequency_hz'),
        damping_ratio=number('damping_ratio'),
        shape=np.asarray(item['shape_real'], dtype=float) + 1j * np.asarray(item['shape_imag']),
        frequency_std_hz=number('frequency_std_hz'),
        damping_ratio_std=number('damping_ratio_std'),
        mpc=number('mpc'),
        mpd=number('mpd'),
        id=int(item['id']),
    )
