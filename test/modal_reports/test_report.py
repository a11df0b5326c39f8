"""The report: words and tables against known content, the geometry against known motions."""

from dataclasses import replace
import math
import re

import numpy as np
import pytest

from autonomous_modal_analysis.identified.results import Identification
from autonomous_modal_analysis.report import match_truth, render_report, ReportContent
from autonomous_modal_analysis.report.mode_rows import mode_rows
from autonomous_modal_analysis.report.words import facts, headline
from modal_core.mode import Mode, ModeSet
from modal_reports import (
    embedded_json,
    Geometry,
    interpolate_displacements,
    pooled,
    sensor_displacements,
    Spectrum,
    stabilisation_data,
    UNKNOWN,
)


def modes(*frequencies, std=0.01):
    shapes = np.eye(max(2, len(frequencies)), dtype=complex)
    return ModeSet(
        tuple(
            Mode(frequency, 0.01, shapes[:, index], std, 0.001, id=index + 1)
            for index, frequency in enumerate(frequencies)
        ),
        tuple(f'c{index}' for index in range(len(shapes))),
    )


def test_truth_is_matched_by_shape_where_frequencies_cross():
    shapes = np.array([[0, 1], [1, 0]], dtype=complex)
    truth = match_truth(modes(10.0, 10.2), [10.05, 10.15], [0.01, 0.01], shapes)
    assert [true.mode.id for true in truth] == [2, 1]
    assert truth[0].mac == pytest.approx(1.0)
    assert truth[0].frequency_error_sigma == pytest.approx((10.2 - 10.05) / 0.01)


def test_missed_and_foreign_modes_are_told():
    found = modes(10.0, 30.0)
    truth = match_truth(found, [10.0, 20.0], [0.01, 0.01])
    assert truth[1].mode is None
    assert math.isnan(truth[1].frequency_error)
    content = ReportContent('t', 'r', Identification(found), truth=truth)
    assert 'Missed: 20 Hz' in headline(content)
    page = render_report(content)
    assert '>extra<' in page
    assert '>missed<' in page
    assert '1 further mode without a true one' in headline(content)


def test_a_mode_of_one_window_alone_is_counted_apart_and_has_its_row():
    found, late = modes(10.0), modes(20.1)
    truth = match_truth(found, [10.0, 20.0], [0.01, 0.01])
    seen = match_truth(late, [10.0, 20.0], [0.01, 0.01])[1]
    content = ReportContent(
        't', 'r', Identification(found), truth=(truth[0], replace(seen, from_window=True))
    )
    assert headline(content).startswith('All 2 true modes found, 1 in a single window only;')
    assert 'further' not in headline(content)
    rows = mode_rows(content)
    assert [row.note for row in rows] == ['', 'one window']
    assert rows[1].frequency.value.startswith('20.1')


def test_no_modes_to_match():
    assert match_truth(modes(), [5.0], [0.01])[0].mode is None


def test_displacements_follow_the_sensors_and_vanish_at_the_base():
    points = np.array([[0, 0, 0], [0, 0, 1], [0, 0, 2], [0, 0, 3]], dtype=float)
    geometry = Geometry(points, lines=((0, 1, 2, 3),))
    tilted = np.array([[1, 0, 0], [0.6, 0.8, 0]], dtype=float)
    motion = np.array([0.3, -0.2, 0.0])
    moved = sensor_displacements(geometry, (tilted @ motion).astype(complex), tilted, (2, 2))
    assert np.allclose(moved, np.outer([0.0, 0.5, 1.0, 1.0], motion))
    unknown = np.full((4, 3), np.nan, dtype=complex)
    assert np.all(interpolate_displacements(geometry, unknown) == 0.0)


def test_pooling_keeps_the_highest_peak():
    rng = np.random.default_rng(1)
    frequency = np.linspace(0.0, 100.0, 9001)
    values = rng.random((9001, 2))
    values[4321] = 50.0
    shown = pooled(Spectrum(frequency, values), most=500)
    assert len(shown.frequency_hz) == 500
    assert shown.singular_value.max() == 50.0
    assert shown.frequency_hz[np.argmax(shown.singular_value[:, 0])] == frequency[4321]


def test_embedded_json_cannot_leave_its_element():
    text = embedded_json({'name': '</script><!--<script>&\u2028'})
    assert not re.search(r'[<>&\u2028]', text)


def test_names_of_channels_cannot_be_shown_reversed_or_hidden():
    name = 'elbow\u202eenoyreve\u200b'
    found = Identification(modes(3.0))
    page = render_report(ReportContent(name, name, found))
    assert '\u202e' not in page and '\u200b' not in page
    assert r'elbow\u202eenoyreve\u200b' in page
    assert embedded_json({name: [name, 'two\nlines']}).count('u202e') == 2
    assert r'two\nlines' in embedded_json(['two\nlines'])


def test_page_refers_to_no_network():
    page = render_report(ReportContent('t', 'r', Identification(modes(3.0))))
    assert not re.search(r'(src|href)\s*=\s*["\']?(https?:)?//', page)
    assert "default-src 'none'" in page
    assert 'Permission is hereby granted' in page


def test_lines_of_machines_are_shown_as_lines_and_counted_apart():
    line = Mode(24.0, 0.0, np.ones(2, dtype=complex), harmonic=True)
    found = Identification(modes(3.0), harmonics=ModeSet((line,), ('a', 'b')))
    content = ReportContent('t', 'r', found)
    assert headline(content).startswith('One mode')
    assert '1 harmonic set apart' in facts(content)
    rows = mode_rows(content)
    assert [row.note for row in rows] == ['', 'harmonic']
    assert rows[1].frequency.value.startswith('24')
    assert rows[1].damping.value == UNKNOWN
    drawn = stabilisation_data(None, None, (*found.modes, *found.harmonics))['lines']
    assert [(each['frequency_hz'], each['harmonic']) for each in drawn] == [
        (3.0, False),
        (24.0, True),
    ]


def test_a_mode_whose_phases_scatter_is_marked_and_the_mark_explained():
    calm = modes(3.0, 5.0)
    wide = replace(calm.modes[1], mpd=math.radians(11.0), mpc=0.89)
    found = replace(calm, modes=(replace(calm.modes[0], mpd=math.radians(9.0)), wide))
    page = render_report(ReportContent('t', 'r', Identification(found)))
    assert page.count('>phases scatter<') == 1
    assert 'MPD above 10°' in page
    assert '>phases scatter<' not in render_report(ReportContent('t', 'r', Identification(calm)))
