"""The tables of the report: modes and channels."""

from collections.abc import Sequence

from autonomous_modal_analysis.report.mode_rows import Measure, MISSED, ModeRow
from modal_core.quality import ChannelQuality
from modal_reports import (
    Cell,
    channel_words,
    DAMPING,
    error_mark,
    fixed,
    FREQUENCY,
    heading,
    KNOWN,
    MAC,
    meter,
    MPC,
    MPD,
    number,
    Row,
    SCATTERED,
    significant,
    Table,
    tags,
    text,
    UNKNOWN,
    value_and_sigma,
)


def modes_table(rows: Sequence[ModeRow], *, known: bool) -> Table:
    """Return the table of modes, beside the truth where it is known."""
    aside = (
        [number('True'), number('Error %'), Cell('Error in σ', span=2)]
        if known
        else [text('Relative σ')]
    )
    return Table(
        'Modes table',
        [
            text('Id'),
            heading(FREQUENCY),
            *aside,
            heading(DAMPING),
            *(cell for cell in aside if cell.content != 'Error %'),
            number(MPC.heading),
            number(MPD.heading),
            *([number(MAC.heading)] if known else []),
            text(''),
        ],
        [_mode_cells(row, known=known) for row in rows],
    )


def channels_table(channels: tuple[ChannelQuality, ...]) -> Table:
    """Return what arrived and what was found on each channel."""
    names = (
        'RMS',
        'Noise ≤',
        'Kurtosis',
        'Rate [Hz]',
        'Jitter [µs]',
        'Filled in',
        'Lost',
        'Repeated',
        'Reordered',
    )
    return Table(
        'Channels table',
        [text('Channel'), text('State'), text('Unit'), *map(number, names)],
        [_channel_cells(channel) for channel in channels],
    )


def _channel_cells(channel: ChannelQuality) -> Row:
    numbers = (
        significant(channel.rms),
        significant(channel.noise_rms),
        significant(channel.kurtosis),
        significant(channel.measured_rate_hz, 5),
        significant(1e6 * channel.jitter_std_s),
        str(channel.n_interpolated),
        str(channel.n_lost),
        str(channel.n_duplicates),
        str(channel.n_reordered),
    )
    poor = channel.excluded or channel.flags
    state = Cell(channel_words(channel), 'bad' if poor else '')
    return Row([Cell(channel.name, 'free'), state, text(channel.unit), *map(number, numbers)])


def _mode_cells(row: ModeRow, *, known: bool) -> Row:
    kind = 'bad' if row.note == MISSED else 'aside' if row.note else ''
    cells = [
        text(row.label),
        *_measure_cells(row.frequency, known=known, percent=True),
        *_measure_cells(row.damping, known=known, percent=False),
        number(row.mpc),
        number(row.mpd),
        *([number(row.mac)] if known else []),
        tags(
            (row.note, 'bad' if row.note == MISSED else ''),
            (SCATTERED if row.scattered else '', 'doubt'),
            (KNOWN if row.driven else '', ''),
        ),
    ]
    return Row(cells, kind)


def _measure_cells(measure: Measure, *, known: bool, percent: bool) -> list[Cell]:
    cells = list(value_and_sigma(measure.value, measure.std))
    if not known:
        return [*cells, Cell(meter(measure.bar), 'chart')]
    cells.append(number(measure.true))
    if percent:
        cells.append(number(measure.error))
    sigmas = fixed(measure.error_sigma, 1, sign=True)
    said = sigmas if sigmas == UNKNOWN else f'{sigmas} σ'
    return [*cells, Cell(error_mark(measure.error_sigma), 'chart'), number(said)]
