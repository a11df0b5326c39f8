"""The tables of the comparison: modes, sensors by bands, levels and lines."""

from collections.abc import Sequence
import itertools

from modal_reports import (
    Cell,
    DAMPING,
    fixed,
    FREQUENCY,
    heading,
    MAC,
    measured,
    number,
    PHASE,
    Quantity,
    Row,
    significant,
    Table,
    text,
)
from model_gap.comparison import SensorBand
from model_gap.report.tables import Found, with_before

RATIO, LEVEL_DB = Quantity('ratio'), Quantity('level', 'dB')


def modes_table(modes: Sequence[Found], label: str) -> Table:
    """Return measured modes beside the model's modes of the same shape, before and after."""
    headings = (
        text('Recording'),
        heading(FREQUENCY.of('measured')),
        heading(DAMPING),
        heading(FREQUENCY.of('before:')),
        *map(number, (DAMPING.heading, MAC.heading, 'Off')),
        number(FREQUENCY.of('after:').heading),
        *map(number, (DAMPING.heading, MAC.heading, 'Off')),
    )
    rows = []
    for row, before in with_before(modes, 'record'):
        name = '' if row['record'] == before else row['record'].removesuffix('.mcap')
        cells = (
            text(name),
            *measured(FREQUENCY, row['frequency_hz'], row['frequency_sigma_hz']),
            *measured(DAMPING, row['damping_ratio'], row['damping_ratio_sigma']),
            *_side(row['before'], tolerance=True),
            *_side(row['after'], tolerance=False),
        )
        rows.append(Row(cells))
    return Table(
        label,
        headings,
        rows,
        'Natural frequencies and damping ratios of the arm behind its motors, as the recordings '
        "tell them by themselves, each ± its standard deviation, and the model's mode of the same "
        'shape; “off” counts standard deviations of measurement and model tolerance together.',
        'no recording tells a mode by itself',
    )


def transmissibility_table(rows: Sequence[SensorBand]) -> Table:
    """Return measured over predicted response of sensors by bands."""
    headings = (
        text('Sensor'),
        text('Hz'),
        Cell('Measured [m/s²]', 'number', 2),
        number('Model before'),
        number('After'),
        *(
            cell
            for when in ('before', 'after')
            for cell in (heading(RATIO.of(f'{when}:')), heading(PHASE), number('Coherence'))
        ),
    )
    cells = [
        Row(
            (
                text(row.sensor),
                text(f'{row.low_hz:g}–{row.high_hz:g}'),
                number(significant(row.measured)),
                Cell(f'± {row.level_sigma_db:.1f} dB', 'sigma'),
                number(significant(row.predicted_before)),
                number(significant(row.predicted_after)),
                *itertools.chain.from_iterable(
                    (
                        *measured(RATIO, ratio.magnitude, ratio.magnitude_sigma),
                        *measured(PHASE, ratio.phase_rad, ratio.phase_sigma_rad),
                        number(fixed(ratio.coherence, 3)),
                    )
                    for ratio in (row.before, row.after)
                ),
            )
        )
        for row in rows
    ]
    return Table(
        'transmissibility',
        headings,
        cells,
        'From the known motion to each sensor: measured over predicted magnitude ± σ, phase ± σ, '
        'coherence. A right model has 1, 0° and 1. The rows that were farthest off; all are in '
        'gap.json.',
        'no band stands out of the noise',
    )


def amplitude_table(rows: Sequence[Found]) -> Table:
    """Return how the response per motion differs between two levels."""
    headings = (
        text('Hz'),
        heading(Quantity('factor')),
        heading(PHASE),
        number('Coherence quiet'),
        number('Loud'),
        number('Off by σ'),
    )
    cells = [
        Row(
            (
                text(f'{row["low_hz"]:g}–{row["high_hz"]:g}'),
                *measured(RATIO, row['factor'], row['factor_sigma']),
                *measured(PHASE, row['phase_rad'], row['phase_sigma_rad']),
                number(fixed(row['coherence_quiet'], 3)),
                number(fixed(row['coherence_loud'], 3)),
                number(fixed(row['deviations'], 1)),
            )
        )
        for row in rows
    ]
    levels = f' ({rows[0]["loud"]} and {rows[0]["quiet"]})' if rows else ''
    return Table(
        'amplitude dependence',
        headings,
        cells,
        f'Response per motion at the loud level over that at the quiet one{levels}, beside what '
        'the model now says; 1 for an arm in proportion.',
    )


def lines_table(lines: Sequence[Found]) -> Table:
    """Return the lines that stand out of the spectra."""
    headings = (
        heading(FREQUENCY),
        text('Channel'),
        heading(LEVEL_DB.of('measured')),
        number('Model before'),
        number('After'),
    )
    cells = [
        Row(
            (
                *measured(FREQUENCY, row['frequency_hz'], row['resolution_hz']),
                text(row['channel']),
                *measured(LEVEL_DB, row['over_surroundings_db'], row['sigma_db']),
                number(fixed(row['predicted_before_db'], 1)),
                number(fixed(row['predicted_after_db'], 1)),
            )
        )
        for row in lines
    ]
    caption = 'Power at the line over that around it [dB]; frequency ± resolution.'
    return Table('lines', headings, cells, caption)


def _side(model: Found | None, *, tolerance: bool) -> tuple[Cell, ...]:
    """Return the cells of the model's mode, with the deviation its tolerance gives."""
    if model is None:
        return (Cell('no such shape', 'number', 5 if tolerance else 4),)
    frequency = measured(FREQUENCY, model['frequency_hz'], model.get('frequency_sigma_hz'))
    return (
        *(frequency if tolerance else (number(fixed(model['frequency_hz'], 2)),)),
        number(fixed(100.0 * model['damping_ratio'], 2)),
        number(fixed(model['mac'], 3)),
        number(fixed(model['deviations'], 1, sign=True)),
    )
