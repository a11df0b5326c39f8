"""How large a recording may be that is read at once."""

from pathlib import Path

from modal_core.errors import RecordingError


def check_size(path: Path, most_bytes: int, size: int | None = None, advice: str = '') -> None:
    """Refuse a file that is larger than what is read of its format.

    Parameters
    ----------
    path : Path
        The file.
    most_bytes : int
        It may have.
    size : int or None
        Bytes that reading it takes; None: those of the file.
    advice : str
        What to do instead.

    Raises
    ------
    RecordingError
        It is larger.
    """
    size = path.stat().st_size if size is None else size
    if size > most_bytes:
        raise RecordingError(
            'file too large',
            where=path,
            found=f'{size} bytes',
            expected=f'at most {most_bytes} bytes',
            advice=advice,
        )
