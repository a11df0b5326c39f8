"""Open whatever holds samples: rosbag2, MCAP, ROS 1 bags, plain arrays, other programs' files."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
import stat

from modal_core.errors import RecordingError
from modal_recordings.array_recording import ArrayRecording
from modal_recordings.containers import BagFile, McapFile, open_folder
from modal_recordings.formats import is_lvm, read_arrays, READERS, table_of
from modal_recordings.mark import marked_table
from modal_recordings.message_recording import MessageRecording
from modal_recordings.spindle_speed import speed_column
from modal_recordings.tables import array_options, ArrayOptions, ArrayTable, LEAVE_OUT, read_npy
from modal_recordings.text import read_text_table

Recording = MessageRecording | ArrayRecording
TEXTS = ('.csv', '.txt', '.tsv')
ARRAY_READERS = {'.npy': read_npy, **dict.fromkeys(TEXTS, read_text_table)}
BAG_SUFFIXES = ('.mcap', '.db3', '.bag')
KINDS = ', '.join(('a rosbag2 folder', *BAG_SUFFIXES, *ARRAY_READERS, *READERS))


def open_recording(
    path: str | Path,
    sample_rate_hz: float | None = None,
    unit: str | None = None,
    channels: Sequence[str] | None = None,
    topics: Sequence[str] | None = None,
    to_look: bool = False,
    mark: str | None = None,
    spindle: str | None = None,
) -> Recording:
    """Open a recording of any known kind.

    Parameters
    ----------
    path : path
        A rosbag2 folder, or an .mcap, .db3, .bag, .npy or .csv file, or one of another program:
        .npz, .uff, .mat, .h5, .nc, .wav, .lvm, .tdms, .mf4.
    sample_rate_hz : float [Hz] or None
        Rate of a plain array; overrides its sidecar ``<file>.yaml``.
    unit : str or None
        Unit of a plain array (m/s^2, g, mg, 50 m/s^2, ...); overrides the sidecar.
    channels : sequence of str or None
        Names of the columns of a plain array; overrides the sidecar.
    topics : sequence of str or None
        Use only these topics of a recording of messages, or these arrays of a file of arrays.
    to_look : bool
        Open a recording of messages also when none of its topics is of use, to see what it is.
    mark : str or None
        Channel or column that is high while the robot moves: the recording is cut to that, and
        the channel is none any more.
    spindle : str or None
        Topic, channel or column with the speed of a spindle; None: the topic
        ``/spindle_speed_rpm`` where there is one.

    Returns
    -------
    Recording
        With ``info()``, ``measurements()`` and ``damage()``.

    Raises
    ------
    RecordingError
        In one line: file, topic or field, what was found and what was expected.
    """
    place = Path(path)
    check_place(place)
    suffix = kind_of(place)
    if suffix in ARRAY_READERS and place.is_file():
        if topics:
            raise RecordingError('a plain array has no topics', where=place, found=topics[0])
        options = array_options(place, sample_rate_hz, unit, channels)
        return _of_table(place, ARRAY_READERS[suffix](place), options, mark, spindle)
    if suffix in READERS and place.is_file():
        options = array_options(place, sample_rate_hz, unit, channels)
        table = table_of(place, read_arrays(place, suffix), topics or ())
        return _of_table(place, table, options, mark, spindle)
    if sample_rate_hz is not None or unit is not None or channels is not None:
        raise RecordingError(
            'rate, unit and channels are stated by the recording itself',
            where=place,
            expected='these options with a file of arrays (.npy, .csv, .mat, ...) only',
        )
    if place.is_dir():
        return MessageRecording(place, open_folder(place), topics, to_look, mark, spindle)
    file = McapFile(place) if suffix == '.mcap' else BagFile(place)
    return MessageRecording(place, file, topics, to_look, mark, spindle)


def kind_of(place: Path) -> str:
    """Return the ending of a file's name; of LabVIEW's texts, however they are called, .lvm."""
    suffix = place.suffix.lower()
    return '.lvm' if suffix in TEXTS and place.is_file() and is_lvm(place) else suffix


def _of_table(
    place: Path,
    table: ArrayTable,
    options: ArrayOptions,
    mark: str | None,
    spindle: str | None,
) -> ArrayRecording:
    notes, speed_hz = [], None
    if mark is not None:
        table, note = marked_table(table, mark, place)
        notes.append(note)
    if spindle is not None:
        given = options.channels or ()
        table, column, factor = speed_column(table, spindle, place, given)
        speed_hz = factor * table.column(column)
        notes.append(f'{spindle} tells the speed of the spindle: its orders are followed by it')
        if len(given) == table.values.shape[1]:
            others = (*given[:column], LEAVE_OUT, *given[column + 1 :])
            options = replace(options, channels=others)
    return ArrayRecording(place, table, options, tuple(notes), speed_hz)


def check_place(place: Path) -> None:
    """Refuse what cannot be a recording by its kind.

    Raises
    ------
    RecordingError
        Not there, empty, or of a kind that nobody reads.
    """
    try:
        status = place.stat()
    except (OSError, ValueError) as error:
        reason = getattr(error, 'strerror', None) or str(error)
        raise RecordingError(f'cannot be opened: {reason}', where=place, expected=KINDS) from error
    if place.is_dir():
        return
    if not stat.S_ISREG(status.st_mode):
        raise RecordingError('not a regular file', where=place, expected=KINDS)
    if status.st_size == 0:
        raise RecordingError('empty file', where=place, found='0 bytes', expected=KINDS)
    if place.suffix.lower() not in (*ARRAY_READERS, *READERS, *BAG_SUFFIXES):
        raise RecordingError(
            'unknown kind of file', where=place, found=place.suffix or 'no suffix', expected=KINDS
        )
