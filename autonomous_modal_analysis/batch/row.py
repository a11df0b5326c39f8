"""What a manifest says of one recording."""

from dataclasses import asdict, dataclass, fields
from typing import Any

TEXTS = ('recording', 'folder', 'asked', 'software', 'sha256', 'error')
COUNTS = ('n_modes', 'n_windows')
TIMES = ('duration_s', 'seconds')


@dataclass(frozen=True, slots=True)
class Row:
    """One recording of a batch.

    Parameters
    ----------
    recording : str
        Its path.
    folder : str
        Where its results are, in the folder of the batch.
    asked : str
        SHA-256 of what was asked of it, and by which version.
    software : str
        Which identified it.
    sha256 : str
        Of the file; of a folder that of its files.
    error : str
        Why there is no result; empty where there is.
    n_modes, n_windows : int
        What was found.
    duration_s : float [s]
        Of the recording.
    seconds : float [s]
        What it took.
    remarks : tuple of str
        Damage, and what should be known of the result.
    """

    recording: str
    folder: str
    asked: str
    software: str
    sha256: str = ''
    error: str = ''
    n_modes: int = 0
    n_windows: int = 0
    duration_s: float = 0.0
    seconds: float = 0.0
    remarks: tuple[str, ...] = ()

    def holds(self, other: 'Row') -> bool:
        """Tell whether this is a result of the same file, asked the same."""
        same = (self.sha256, self.asked) == (other.sha256, other.asked)
        return same and bool(self.sha256) and not self.error

    def values(self) -> dict[str, Any]:
        """Return the fields as plain values."""
        return {**asdict(self), 'remarks': list(self.remarks)}

    @classmethod
    def from_values(cls, values: Any) -> 'Row':
        """Return the row that :meth:`values` gave.

        Raises
        ------
        ValueError, TypeError
            It did not.
        """
        if not isinstance(values, dict):
            raise TypeError('no fields')
        if set(values) != {item.name for item in fields(cls)}:
            raise ValueError('other fields')
        if not all(isinstance(values[name], str) for name in TEXTS):
            raise TypeError('no text')
        known: dict[str, Any] = {name: values[name] for name in TEXTS}
        known |= {name: int(values[name]) for name in COUNTS}
        known |= {name: float(values[name]) for name in TIMES}
        return cls(remarks=tuple(str(remark) for remark in values['remarks']), **known)
