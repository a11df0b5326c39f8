"""Modes of a recording, or as they were kept: modes.json, or a universal file of any program."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any, TYPE_CHECKING

import numpy as np

from autonomous_modal_analysis.compared.operating_state import (
    OperatingState,
    state_of,
    UNKNOWN_STATE,
)
from autonomous_modal_analysis.console.terminal import progress_bar
from autonomous_modal_analysis.identified.results import FORMAT_VERSION
from autonomous_modal_analysis.views.output import show_damage
from modal_core.errors import RecordingError, SettingsError
from modal_core.files.json_file import load_json
from modal_core.mode import Mode, ModeSet
from modal_core.window import Pose
from modal_reports import Spectrum

if TYPE_CHECKING:
    from autonomous_modal_analysis.api.modal_result import ModalResult
    from autonomous_modal_analysis.console.option_groups import Identifier, Reading

RESULTS = 'modes.json'
LARGEST_BYTES = 500_000_000
UNIVERSAL = ('.uff', '.unv')


def results_file(path: Path) -> Path | None:
    """Return the modes.json a path means; None where it means a recording."""
    if path.is_dir() and (path / RESULTS).is_file():
        return path / RESULTS
    return path if path.suffix == '.json' else None


def kept_name(path: Path) -> str:
    """Return what to call results: by their folder where the file has the usual name."""
    return path.parent.name if path.name == RESULTS else path.name


def result_of(path: Path, identifier: 'Identifier', reading: 'Reading') -> 'ModalResult | Path':
    """Return what a recording gives, or the file of results that were kept.

    Raises
    ------
    ModalAnalysisError
        It cannot be read or identified.
    """
    if results_file(path) is not None:
        return path
    with progress_bar(f'identifying {path.name}') as progress:
        found = identifier.identify(reading.open_file(path), progress)
    show_damage(found.damage)
    return found


@dataclass(frozen=True, slots=True)
class ReadResult:
    """What is known of a recording, by itself or by results that were kept.

    Parameters
    ----------
    modes : ModeSet
        Of the whole recording.
    spectrum : Spectrum or None
        Its largest singular value; None where none was kept.
    result : ModalResult or None
        Of a recording that was identified now.
    at : OperatingState
        Joint speed, pose and load while it was made.
    """

    modes: ModeSet
    spectrum: Spectrum | None = None
    result: 'ModalResult | None' = None
    at: OperatingState = UNKNOWN_STATE


def read_result(path: Path, identifier: 'Identifier', reading: 'Reading') -> ReadResult:
    """Return the modes of a recording, or of results that were kept, with their spectrum.

    Raises
    ------
    ModalAnalysisError
        It cannot be read or identified.
    """
    if path.suffix.lower() in UNIVERSAL and _has_shapes(path):
        from modal_recordings.universal import read_shapes

        return ReadResult(read_shapes(path))
    found = result_of(path, identifier, reading)
    if isinstance(found, Path):
        kept = results_file(found) or found
        modes = read_modes(kept)
        return ReadResult(modes, _kept_spectrum(kept), at=state_of(_kept_poses(kept)))
    whole = found.found.whole.spectrum
    at = state_of(window.pose for window in found.windows)
    return ReadResult(found.modes, Spectrum(whole.frequency_hz, whole.singular_value), found, at)


def _kept_poses(path: Path) -> list[Pose | None]:
    """Return the poses of the windows in a file of results."""
    try:
        windows = load_json(path, LARGEST_BYTES).get('windows', [])
        return [_kept_pose(window.get('pose')) for window in windows]
    except (ValueError, KeyError, TypeError, AttributeError) as error:
        raise _no_results(path, f'pose: {type(error).__name__}: {error}') from error


def _kept_pose(kept: Any) -> Pose | None:
    if kept is None:
        return None
    names = tuple(str(name) for name in kept['joint_names'])
    angles, spread, speed = (
        None if kept.get(field) is None else np.array(kept[field], dtype=float).reshape(len(names))
        for field in ('position', 'position_range', 'mean_speed')
    )
    return None if angles is None or spread is None else Pose(names, angles, spread, speed)


def _kept_spectrum(path: Path) -> Spectrum | None:
    """Return the spectrum in a file of results; None where it has none, or none that fits."""
    found: Any = load_json(path, LARGEST_BYTES).get('spectrum')
    if not isinstance(found, dict):
        return None
    try:
        hz = np.array(found['frequency_hz'], dtype=float)
        values = np.array(found['singular_value'], dtype=float)
    except (ValueError, KeyError, TypeError) as error:
        raise _no_results(path, f'spectrum: {type(error).__name__}: {error}') from error
    rising = hz.ndim == 1 and len(hz) > 0 and np.all(np.diff(hz) > 0.0)
    if hz.shape != values.shape or not rising or not np.isfinite([hz, values]).all():
        raise _no_results(path, 'spectrum: not one finite value per rising frequency')
    return Spectrum(hz, values[:, None])


def _has_shapes(path: Path) -> bool:
    """Return whether a universal file holds modes; where it holds records too, those count."""
    from modal_recordings.universal import blocks_of

    kinds = {block.kind for block in blocks_of(path)}
    return 55 in kinds and 58 not in kinds


def read_modes(path: str | Path) -> ModeSet:
    """Read the modes of the whole recording from what `ama identify` wrote.

    Raises
    ------
    RecordingError
        It cannot be read, or is no such file.
    """
    path = Path(path)
    try:
        found: Any = load_json(path, LARGEST_BYTES)
        version = found.get('file', {}).get('format_version', FORMAT_VERSION)
        if version != FORMAT_VERSION:
            raise _no_results(path, f'format version {version}')
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
