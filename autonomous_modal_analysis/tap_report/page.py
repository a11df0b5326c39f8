"""One HTML file that shows a whole tap test."""

from pathlib import Path

from markupsafe import Markup
import numpy as np

from impact_testing import ImpactResult, TestedPoint
from modal_core.files.version import software
from modal_reports import (
    Cell,
    DAMPING,
    fixed,
    FREQUENCY,
    heading,
    LARGE,
    measured,
    mode_shapes_data,
    MPC,
    number,
    Page,
    Quantity,
    render,
    Row,
    SMALL,
    spectrum_plot,
    Table,
    text,
)

TEMPLATE = Path(__file__).parent / 'templates' / 'taps.html.j2'
MASS = Quantity('modal mass', 'kg')
MOST_POINTS = 12
"""Drawn; more would not be looked at, and all are in the files."""
LOW = LARGE[0], SMALL[1]
"""Of the picture below a large one, as wide as it."""
MOST_LINES = 1200


def render_tap_test(found: ImpactResult, name: str) -> str:
    """Return the report as one HTML document; names in it are only ever shown as text."""
    good = sum(point.n_good for point in found.points)
    total = sum(len(point.taps) for point in found.points)
    values = {
        'name': name,
        'modes': _modes(found),
        'taps': _taps(found),
        'checks': _checks(found),
        'remarks': found.remarks,
        'drawings': [
            (point, _drawing(point), _coherence(point)) for point in found.points[:MOST_POINTS]
        ],
        'n_more': max(0, len(found.points) - MOST_POINTS),
        'facts': [
            f'{good} of {total} taps used',
            f'{found.length_s:.3g} s of each',
            f'{found.band_hz[0]:.4g} to {found.band_hz[1]:.4g} Hz',
            f'misfit {found.misfit:.2f} (1: noise alone)',
        ],
        'provenance': {'software': software()},
    }
    charts = {'mode_shapes': mode_shapes_data(found.modes, None, ())}
    return render(Page('Tap test report', 'Experimental modal analysis', TEMPLATE, values, charts))


def _modes(found: ImpactResult) -> Table:
    rows = [
        Row(
            [
                *measured(FREQUENCY, each.mode.frequency_hz, each.mode.frequency_std_hz),
                *measured(DAMPING, each.mode.damping_ratio, each.mode.damping_ratio_std),
                *measured(MASS, each.modal_mass_kg, each.modal_mass_std_kg),
                number(fixed(each.mode.mpc, 3)),
            ]
        )
        for each in found.scaled_modes
    ]
    headings = [heading(FREQUENCY), heading(DAMPING), heading(MASS), number(MPC.heading)]
    return Table('Modes table', headings, rows)


def _taps(found: ImpactResult) -> Table:
    rows = []
    for point in found.points:
        for recording, index, time_s, each in point.told_taps():
            cells = [
                Cell(recording, 'free'),
                number(str(index)),
                number(f'{time_s:.2f}'),
                number(f'{each.tap.peak_n:.3g}'),
                number(f'{1e3 * each.tap.width_s:.2g}'),
                Cell(each.words, '' if each.good else 'bad'),
            ]
            rows.append(Row(cells, '' if each.good else 'aside'))
    names = ('Tap', 'Time [s]', 'Peak [N]', 'Width [ms]')
    return Table('Taps table', [text('Recording'), *map(number, names), text('Judgement')], rows)


def _checks(found: ImpactResult) -> list[tuple[str, str]]:
    said = [
        (
            f'driving point {name}',
            f'out of phase by {max(map(abs, phases), default=0.0):.1f}° at most',
        )
        for name, phases in found.driving_phase_deg.items()
    ]
    said += [
        (f'reciprocity {name}', f'FRAC {value:.4f}') for name, value in found.reciprocity.items()
    ]
    worst = [(point.name, float(np.median(point.agreement))) for point in found.points]
    return [
        *said,
        *((f'synthesised, {name}', f'median FRAC {value:.4f}') for name, value in worst),
    ]


def _shown(point: TestedPoint) -> int:
    """Return the channel that is drawn: the driving point, else the one that moves most."""
    names, wanted = point.data.frf.spectra.names, point.hit.removeprefix('-')
    power = np.sum(np.abs(point.measured) ** 2, axis=0)
    return names.index(wanted) if wanted in names else int(np.argmax(power))


def _drawing(point: TestedPoint) -> Markup:
    column = _shown(point)
    step = max(1, len(point.measured) // MOST_LINES)
    lines = point.data.frequency_hz[::step]
    curves = [
        ('measured', np.abs(point.measured[::step, column])),
        ('after', np.abs(point.synthesised[::step, column])),
    ]
    noise = float(np.sqrt(np.median(2.0 * point.data.course) * point.data.level[column]))
    channel = point.data.frf.spectra.names[column]
    title = f'{channel} over the force at {point.hit or point.name} [m/s²/N]'
    return spectrum_plot(title, lines, curves, noise, LARGE)


def _coherence(point: TestedPoint) -> Markup:
    step = max(1, len(point.measured) // MOST_LINES)
    lost = 1.0 - point.data.frf.coherence[point.data.lines][::step, _shown(point)]
    lines = point.data.frequency_hz[::step]
    curves = [('measured', np.maximum(lost, 1e-9))]
    return spectrum_plot('1 - coherence', lines, curves, float(np.median(lost)), LOW)
