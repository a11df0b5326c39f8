"""Modes of a recording, of whatever it was kept as: the recording itself, or its modes.json."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from autonomous_modal_analysis.api.recording import open_recording
from autonomous_modal_analysis.api.uniform_samples import one_stretch
from autonomous_modal_analysis.option_groups import Identifier
from autonomous_modal_analysis.output import show_damage
from autonomous_modal_analysis.terminal import progress_bar
from modal_core.errors import IdentificationError, RecordingError, SettingsError
from modal_core.json_file import load_json
from modal_core.mode import Mode, ModeSet
from modal_core.samples import Samples
from oma_identifier.one_kind import of_one_kind

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
        found = identifier.identify(open_recording(path), progress)
    show_damage(found.damage)
    return found.modes


def samples_of(path: Path, names: Sequence[str]) -> Samples | None:
    """Return the samples that modes were identified from, channels as named.

    None for kept results, and for recordings with gaps or with other channels when read as one.
    """
    if results_file(path) is not None:
        return None
    recording = open_recording(path)
    try:
        samples = of_one_kind(one_stretch(recording.source, recording.info))
    except (RecordingError, IdentificationError):
        return None
    own = samples.channel_names
    if not set(names) <= set(own):
        return None
    columns = [own.index(name) for name in names]
    return replace(
        samples,
        acceleration=samples.acceleration[:, columns],
        channels=tuple(samples.channels[column] for column in columns),
    )


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
        modes = tuple(Mode.from_values(item, len(names)) for item in found['modes'])
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
