"""One HTML file that shows what encoders and torques tell of a robot."""

import itertools
from pathlib import Path

from markupsafe import Markup
import numpy as np

from modal_core.files.atomic_file import write_text
from modal_reports import (
    Axis,
    Bar,
    bar_chart,
    capital,
    Cell,
    Curves,
    curves_data,
    number,
    Page,
    percent,
    render,
    Row,
    Table,
    text,
    Trace,
    with_sigma,
)
from model_gap.trajectory.encoder_gap import EncoderGap, Law, Quantity
from model_gap.trajectory.motion import EDGE_S, RATE_HZ
from model_gap.trajectory.predict import predicted
from model_gap.trajectory.term import Array, TORQUE, Track, TWIST
from model_gap.trajectory.words import (
    confirmed_lines,
    gap_line,
    headline,
    not_told,
    place_words,
    sentence,
    unexplained_lines,
)

TEMPLATE = Path(__file__).parent / 'templates' / 'encoders.html.j2'
MICRO, KILO = 1e6, 1e-3
ACROSS = {'angle': 'rad', 'speed': 'rad/s', 'load': 'N m'}
NAMES = {'measured': 'measured', 'before': 'model before', 'after': 'model after'}


def write_page(gap: EncoderGap, path: Path) -> None:
    """Write the report, whole or not at all."""
    write_text(path, render_page(gap))


def render_page(gap: EncoderGap) -> str:
    """Return the report as one HTML document without links."""
    heldout = [item.name for item in gap.campaign.heldout]
    groups = _loops(gap), _courses(gap), _rests(gap)
    first = list(itertools.accumulate(map(len, groups), initial=0))
    loops, courses, rests = itertools.starmap(range, itertools.pairwise(first))
    charts = {'curves': [curves_data(each) for group in groups for each in group]}
    values = {
        'verdict': gap.verdict.value,
        'headline': headline(gap),
        'sentences': [sentence(law) for law in gap.laws],
        'confirmed': [capital(line) for line in confirmed_lines(gap)],
        'shares': [capital(gap_line(item, heldout)) for item in gap.quantities],
        'bars': _bars(gap, heldout),
        'table': _table(gap),
        'loops': loops,
        'courses': courses,
        'rests': rests,
        'unexplained': [capital(line) for line in unexplained_lines(gap)],
        'not_told': [capital(line) for line in not_told(gap)],
        'rivals': _rivals(gap),
        'remarks': gap.campaign.remarks,
        'heldout': ', '.join(heldout),
        'fitted': ', '.join(item.name for item in gap.campaign.fitting),
    }
    title = f'Encoders and torques: {gap.model.robot_name}'
    return render(Page('Model gap report', title, TEMPLATE, values, charts))


def _bars(gap: EncoderGap, heldout: list[str]) -> Markup:
    """Draw the held-out error of every axis, after as a share of before."""
    bars = []
    for quantity in gap.quantities:
        after, before = (
            np.sqrt(np.mean([part[name] ** 2 for name in heldout], axis=0))
            for part in (quantity.after, quantity.before)
        )
        bars += [
            Bar(f'{quantity.name}, {place_words(row)}', float(value), 'after')
            for row, value in zip(quantity.rows, after / before, strict=True)
        ]
    return bar_chart('held-out error after, of that before', bars, percent, ('before', 1.0))


def _table(gap: EncoderGap) -> Table:
    headings = ('law', 'place', 'numbers', 'log evidence', 'gap without', 'with', 'or')
    return Table(
        'laws that were found',
        [text(item) for item in headings],
        [_row(law) for law in gap.laws],
        'Gap: rms error of the held-out recordings, of that before.',
    )


def _row(law: Law) -> Row:
    numbers = '; '.join(
        f'{item.name.replace("_", " ")} {with_sigma(item.value, item.sigma, item.unit)}'
        if item.sigma > 0.0
        else f'{item.name.replace("_", " ")} {item.value:.2g} {item.unit}'
        for item in law.effect.parameters
    )
    return Row(
        (
            text(law.effect.type.replace('_', ' ')),
            text(place_words(law.effect.location)),
            Cell(numbers, 'free'),
            number(f'{law.gain:.0f}'),
            number(percent(law.without)),
            number(percent(law.all_in)),
            Cell(', '.join(law.rivals), 'free'),
        )
    )


def _after(track: Track, quantity: Quantity) -> Array:
    return predicted(track, quantity.found.problem.layout, quantity.found.fit)


def _courses(gap: EncoderGap) -> list[Curves]:
    """Draw what was measured and predicted in the last held-out recording, over time."""
    track, pictures = gap.tracks[-1], []
    time = np.arange(track.motion.count) / RATE_HZ + EDGE_S
    for quantity in gap.quantities:
        torque = quantity.name == TORQUE
        measured = track.motion.torque_nm if torque else track.motion.twist_rad
        factor, unit = (KILO, 'kN m') if torque else (MICRO, 'µrad')
        known = track.known[quantity.name]
        # Twists count from where their encoders do.
        begin = np.zeros(measured.shape[1]) if torque else measured.mean(axis=0)
        curves = (
            ('measured', measured - begin),
            ('before', known - (0.0 if torque else known.mean(axis=0))),
            ('after', track.expected(quantity.name) + _after(track, quantity) - begin),
        )
        for place, row in enumerate(quantity.rows):
            traces = [
                Trace(kind, time, factor * values[:, place], NAMES[kind])
                for kind, values in curves
            ]
            title = f'{quantity.name} of {place_words(row)}, {track.motion.name}'
            axes = Axis('time', 's'), Axis(quantity.name, unit)
            pictures.append(Curves(title, *axes, traces))
    return pictures


def _loops(gap: EncoderGap) -> list[Curves]:
    """Draw the twist of every gear against its load, and the law through it."""
    pictures = []
    for quantity in (item for item in gap.quantities if item.name == TWIST):
        for place, row in enumerate(quantity.rows):
            traces = []
            for track in gap.tracks:
                joint = track.motion.encoders[place]
                load = KILO * track.load_nm[:, joint]
                law = track.expected(TWIST) + _after(track, quantity)
                traces += [
                    Trace('measured', load, MICRO * track.motion.twist_rad[:, place]),
                    Trace('after', load, MICRO * law[:, place], 'law'),
                ]
            title = f'twist of {place_words(row)} against its load'
            pictures.append(Curves(title, Axis('load', 'kN m'), Axis('twist', 'µrad'), traces))
    return pictures


def _rests(gap: EncoderGap) -> list[Curves]:
    """Draw what is left over where data alone explain it, against what it goes with."""
    pictures = []
    for name, row, rival in gap.unexplained:
        factor, unit = (1.0, 'N m') if name == TORQUE else (MICRO, 'µrad')
        kind, joint = rival.input
        across = f'{kind} of {place_words(gap.model.axis_names[joint])}'
        trace = Trace('after', rival.shape[0], factor * rival.shape[1], 'data alone')
        title = f'left over of the {name} of {place_words(row)}'
        axes = Axis(across, ACROSS.get(kind, '')), Axis('left over', unit)
        pictures.append(Curves(title, *axes, [trace]))
    return pictures


def _rivals(gap: EncoderGap) -> Table:
    rows = []
    for quantity in gap.quantities:
        factor, unit = (1.0, 'N m') if quantity.name == TORQUE else (MICRO, 'µrad')
        for row, rival in zip(quantity.rows, quantity.rivals, strict=True):
            values = rival.before, rival.laws, rival.alone, rival.beside
            cells = [number(f'{factor * value:.0f} {unit}') for value in values]
            name = text(f'{quantity.name}, {place_words(row)}')
            rows.append(Row((name, *cells), 'best' if rival.beats else ''))
    headings = ('', 'model', 'laws', 'data alone', 'laws and data')
    return Table(
        'laws beside data alone',
        [text(headings[0]), *(number(item) for item in headings[1:])],
        rows,
        'Rms error of the held-out recordings.',
    )
