"""What a plain array does not say itself: rate, unit, channels; from sidecar or options."""

from collections.abc import Sequence
from dataclasses import dataclass, field
import math
from pathlib import Path

from modal_core.errors import RecordingError, SettingsError
from modal_core.files.yaml_file import load_yaml
from modal_core.measurements import NANOSECONDS_PER_SECOND
from modal_core.settings.near_names import refuse_unknown

LOWEST_RATE_HZ, HIGHEST_RATE_HZ = 1e-3, 1e7
FIELDS = ('sample_rate_hz', 'unit', 'channels', 'start_time_s')


@dataclass(frozen=True, slots=True)
class Advice:
    """How a person states what an array does not say itself; errors name it.

    Parameters
    ----------
    rate, columns, unit : str
        The sample rate, what the columns are, their unit.
    """

    rate: str = 'a time column, a sidecar or the option --sample-rate-hz'
    columns: str = (
        'name it with --channels or in the sidecar: "time [ms],index,a [g],-"; - leaves it out'
    )
    unit: str = '--unit'


@dataclass(frozen=True, slots=True)
class ArrayOptions:
    """How to read a plain array.

    Parameters
    ----------
    sample_rate_hz : float [Hz] or None
        Rate of the rows; None: from a time column.
    unit : str or None
        Unit of the values that have none in the file; None: not stated.
    channels : tuple of str or None
        Name of each column, or of each channel (times and counters left out), with or without
        its unit; ``-`` leaves a column out; None: from the file.
    start_ns : int [ns]
        Time of the first row.
    gyroscopes : bool
        Angular velocities beside accelerations take part.
    advice : Advice
        How a person states these.
    """

    sample_rate_hz: float | None = None
    unit: str | None = None
    channels: tuple[str, ...] | None = None
    start_ns: int = 0
    gyroscopes: bool = False
    advice: Advice = field(default_factory=Advice)


def sidecar_of(path: Path) -> Path:
    """Return where the sidecar of an array file would be."""
    return path.with_name(f'{path.name}.yaml')


def array_options(
    path: Path,
    sample_rate_hz: float | None = None,
    unit: str | None = None,
    channels: Sequence[str] | None = None,
) -> ArrayOptions:
    """Return the sidecar's statements, overridden by the options given.

    Raises
    ------
    RecordingError
        The sidecar is malformed, or a value is out of range; names the file and field.
    """
    sidecar = sidecar_of(path)
    data: dict[str, object] = {}
    if sidecar.exists():
        try:
            data = load_yaml(sidecar)
        except SettingsError as error:
            raise RecordingError(error.what, where=error.where, found=error.found) from error
    refuse_unknown(data, FIELDS, where=sidecar, error=RecordingError)
    rate = sample_rate_hz if sample_rate_hz is not None else data.get('sample_rate_hz')
    names = channels if channels is not None else data.get('channels')
    stated = unit if unit is not None else data.get('unit')
    if stated is not None and not isinstance(stated, str):
        raise RecordingError('not a text', where=f'{sidecar}: unit', found=stated)
    return ArrayOptions(
        sample_rate_hz=None if rate is None else checked_rate(rate, path),
        unit=stated,
        channels=None if names is None else checked_names(names, path),
        start_ns=_start(data.get('start_time_s', 0.0), sidecar),
        advice=Advice(f'a time column, {sidecar.name} or the option --sample-rate-hz'),
    )


def checked_rate(value: object, path: Path) -> float:
    """Return a sample rate [Hz].

    Raises
    ------
    RecordingError
        Not a number, or out of range.
    """
    try:
        rate = math.nan if isinstance(value, bool) else float(value)  # type: ignore[arg-type]
    except (TypeError, ValueError):
        rate = math.nan
    if not math.isfinite(rate) or not LOWEST_RATE_HZ <= rate <= HIGHEST_RATE_HZ:
        raise RecordingError(
            'bad rate', where=f'{path}: sample_rate_hz', found=value, expected='0.001 to 1e7 Hz'
        )
    return rate


def checked_names(value: object, path: Path) -> tuple[str, ...]:
    """Return names of columns.

    Raises
    ------
    RecordingError
        Not a list, or names empty or repeated.
    """
    where = f'{path}: channels'
    if isinstance(value, str) or not isinstance(value, Sequence):
        raise RecordingError('not a list', where=where, found=value, expected='a list of names')
    names = tuple(str(name).strip() for name in value)
    kept = [name for name in names if name != '-']
    if '' in names or len(set(kept)) != len(kept):
        raise RecordingError(
            'names empty or repeated', where=where, found=', '.join(names), expected='unique names'
        )
    return names


def _start(value: object, sidecar: Path) -> int:
    try:
        seconds = float(value)  # type: ignore[arg-type]
    except (TypeError, ValueError):
        seconds = math.nan
    if not math.isfinite(seconds) or not 0.0 <= seconds < 4e9:
        raise RecordingError(
            'bad time', where=f'{sidecar}: start_time_s', found=value, expected='0 to 4e9 s'
        )
    return round(seconds * NANOSECONDS_PER_SECOND)
