"""Two results over each other: shapes fitted to each other, spectra kept, both drawn."""

import json

import numpy as np
import pytest

from autonomous_modal_analysis.identified.results import Identification, write_json
from autonomous_modal_analysis.read_results import read_result
from autonomous_modal_analysis.report import ComparedState, StateDrawn, write_comparison
from autonomous_modal_analysis.report.overlay import shapes_of_both
from modal_core.errors import RecordingError
from modal_core.mode import Mode, ModeSet
from modal_dashboard.arm_drawing import ArmDrawing
from modal_reports import Geometry, Spectrum
from oma_identifier.compare import compare_modes
from test.support import browser


def modes(shapes, frequencies_hz=(4.0, 9.0), names=('a', 'b', 'c')):
    found = [
        Mode(hz, 0.01, np.asarray(shape, dtype=complex), 0.01, 0.001, id=number)
        for number, (hz, shape) in enumerate(zip(frequencies_hz, shapes, strict=True), 1)
    ]
    return ModeSet(tuple(found), names)


FIRST = modes([[1.0, 0.5, 0.2], [0.3, -1.0, 0.6]])


def test_a_turned_and_scaled_shape_lies_on_the_first_and_a_changed_one_does_not():
    turned = [-2.5j * mode.shape for mode in FIRST]
    second = modes([turned[0], turned[1] + np.array([0.0, 0.0, 0.5])])
    found = compare_modes(FIRST, second)
    shown = shapes_of_both(found, FIRST, second, StateDrawn(), StateDrawn())['modes']
    np.testing.assert_allclose(shown[0]['other']['shape_real'], [1.0, 0.5, 0.2], atol=1e-6)
    np.testing.assert_allclose(shown[0]['other']['shape_imag'], 0.0, atol=1e-6)
    other = np.array(shown[1]['other']['shape_real']) + 1j * np.array(
        shown[1]['other']['shape_imag']
    )
    off = other - [0.3, -1.0, 0.6]
    # What the best factor leaves is at right angles to the shape itself.
    assert abs(np.vdot(off, other)) < 1e-5 < abs(off).max()


def test_channels_of_one_result_alone_are_left_out_and_modes_paired_by_name():
    second = modes([[0.2, 1.0], [0.6, 0.3]], names=('c', 'a'))
    shown = shapes_of_both(compare_modes(FIRST, second), FIRST, second, StateDrawn(), StateDrawn())
    first = shown['modes'][0]['other']
    assert first['shape_real'][1] is None
    assert first['shape_real'][0] == pytest.approx(1.0)
    assert shown['geometry'] is None


def test_results_keep_their_spectrum_and_a_broken_one_is_refused(tmp_path):
    hz = np.linspace(0.1, 40.0, 5000)
    value = 1.0 / ((hz - 4.0) ** 2 + 0.01)
    path = tmp_path / 'modes.json'
    write_json(path, Identification(FIRST), 'rest', Spectrum(hz, value[:, None]))
    kept = read_result(path, None, None)
    assert len(kept.spectrum.frequency_hz) == 1000
    assert kept.spectrum.singular_value.max() == pytest.approx(value.max(), rel=1e-3)
    assert kept.result is None
    write_json(path, Identification(FIRST), 'rest')
    assert read_result(path, None, None).spectrum is None
    found = json.loads(path.read_text())
    for broken in (
        {'frequency_hz': [1.0, 2.0], 'singular_value': [1.0]},
        {'frequency_hz': [2.0, 1.0], 'singular_value': [1.0, 1.0]},
        {'frequency_hz': [1.0], 'singular_value': ['x']},
        {'frequency_hz': [1.0]},
    ):
        path.write_text(json.dumps({**found, 'spectrum': broken}))
        with pytest.raises(RecordingError, match='spectrum'):
            read_result(path, None, None)


@pytest.mark.skipif(browser.find_browser() is None, reason='no Chromium')
@pytest.mark.parametrize(('width', 'dark'), [(1400, False), (390, True)])
def test_both_are_drawn_and_named_when_pointed_at(tmp_path, width, dark):
    hz = np.linspace(0.5, 20.0, 400)
    second = modes([[1.0, 0.5, 0.2], [0.3, -1.0, 0.6]], (4.0, 8.6))
    points = np.array([[0, 0, 0], [0, 0, 1.0], [1.0, 0, 1.0]])
    geometry = Geometry(points, lines=((0, 1, 2),), sensors=(2,))
    arm = ArmDrawing(geometry, (np.ones((3, 3), complex), 1j * np.ones((3, 3), complex)))
    states = [
        ComparedState('later', second, compare_modes(FIRST, second),
                      StateDrawn(Spectrum(hz + 0.01, np.ones((400, 1))), arm)),
        ComparedState('bare', second, compare_modes(FIRST, second)),
    ]  # fmt: skip
    drawn = StateDrawn(Spectrum(hz, 2.0 * np.ones((400, 1))), arm)
    path = tmp_path / 'comparison.html'
    write_comparison(path, 'rest', FIRST, states, drawn)
    with browser.browser_page() as page:
        page.open(path, width=width, dark=dark)
        assert page.problems == []
        assert page.evaluate('document.documentElement.scrollWidth') <= width
        assert page.evaluate("document.querySelectorAll('.uplot canvas').length") == 2
        assert page.evaluate("document.querySelectorAll('.card canvas').length") == 4
        assert page.evaluate("document.querySelectorAll('.card.flat canvas').length") == 2
        assert page.evaluate("document.querySelectorAll('#play').length") == 1
        page.evaluate("document.querySelector('.u-over').scrollIntoView({block: 'center'})")
        box = page.evaluate(
            '(({x, y, width, height}) => ({x, y, width, height}))'
            "(document.querySelector('.u-over').getBoundingClientRect())"
        )
        x = box['x'] + box['width'] * (9.0 - 0.5) / (20.01 - 0.5)
        page.mouse('mouseMoved', x - 5, box['y'] + 20)
        page.mouse('mouseMoved', x, box['y'] + 20)
        page.evaluate('new Promise((done) => setTimeout(done, 100))')
        said = page.evaluate("document.getElementById('tooltip').textContent")
        assert 'rest: 2 ' in said and 'later: 1 ' in said
        assert 'mode 2 of rest: 9.0' in said
