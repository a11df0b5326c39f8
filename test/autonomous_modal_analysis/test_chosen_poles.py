"""Poles picked by click in a report, saved, and repeated by `ama identify --poles`."""

import json

import numpy as np
import pytest
from scipy.signal import lfilter

import autonomous_modal_analysis
from modal_core.errors import SettingsError
from test.support import browser

RATE_HZ, SEED = 100.0, 61
TRUE_HZ = (7.0, 13.0, 21.0)


@pytest.fixture(scope='module')
def record(tmp_path_factory):
    """Three modes at four sensors, 300 s."""
    rng, path = np.random.default_rng(SEED), tmp_path_factory.mktemp('record') / 'record.npy'
    data = 0.05 * rng.normal(size=(30_000, 4))
    for hz in TRUE_HZ:
        pole = np.exp(2 * np.pi * hz * (-0.01 + 1j) / RATE_HZ)
        motion = lfilter([1], [1, -2 * pole.real, abs(pole) ** 2], rng.normal(size=30_000))
        data += np.outer(motion, rng.normal(size=4))
    np.save(path, data)
    return path


@pytest.fixture(scope='module')
def identified(record):
    found = autonomous_modal_analysis.open(record, sample_rate_hz=RATE_HZ).identify()
    np.testing.assert_allclose(found.frequencies_hz, TRUE_HZ, rtol=0.01)
    return found


def saved(path, poles):
    path.write_text(json.dumps({'format': 'poles-1', 'poles': poles}))
    return path


def entry(poles, row):
    return {
        'model_order': int(poles.model_order[row]),
        'frequency_hz': float(f'{poles.frequency_hz[row]:.6g}'),
        'damping_ratio': float(f'{poles.damping_ratio[row]:.6g}'),
    }


def rows_of(identified, number):
    """Return a pole of a mode of the result; of none for 0."""
    poles = identified.found.whole.poles
    ok = (poles.mode_id == number) & (poles.damping_ratio > 0.0) & (poles.frequency_hz > 1.0)
    return np.flatnonzero(ok)


def test_the_automatic_choice_is_repeated_bit_for_bit(identified, tmp_path):
    poles = identified.found.whole.poles
    chosen = [entry(poles, rows_of(identified, mode.id)[0]) for mode in identified.modes]
    again = identified.choose(saved(tmp_path / 'p.json', chosen))
    assert again.modes == identified.modes
    assert '3 of the 3 automatic ones, 0 single' in again.remarks[-1]


def test_a_mode_let_go_and_a_pole_taken(identified, tmp_path):
    """What no automatic mode stands for has its own numbers, and no σ."""
    poles = identified.found.whole.poles
    single = int(rows_of(identified, 0)[3])
    kept = identified.modes.modes[1]
    chosen = [entry(poles, single), entry(poles, rows_of(identified, kept.id)[-1])]
    found = identified.choose(saved(tmp_path / 'p.json', chosen))
    assert len(found) == 2 and kept in found.modes.modes
    (other,) = (mode for mode in found.modes if mode is not kept)
    assert other.frequency_hz == poles.frequency_hz[single]
    assert np.isnan(other.frequency_std_hz) and other.shape_std is None
    assert other.id not in {mode.id for mode in identified.modes}
    assert np.max(np.abs(other.shape)) == pytest.approx(1.0)
    assert found.windows == identified.windows


@pytest.mark.parametrize(
    ('text', 'said'),
    [
        ('{"format": "poles-1", "poles": [{"model_order": 8}]}', 'no file of picked poles'),
        ('{"format": "poles-9", "poles": []}', 'poles-9'),
        ('[1, 2]', 'no file of picked poles'),
        ('not json', 'not JSON'),
        (
            '{"format": "poles-1", "poles":'
            ' [{"model_order": 8, "frequency_hz": 3.21, "damping_ratio": 0.5}]}',
            'no such pole in this recording',
        ),
    ],
)
def test_another_file_is_refused_in_one_line(identified, tmp_path, text, said):
    path = tmp_path / 'p.json'
    path.write_text(text)
    with pytest.raises(SettingsError, match=said) as error:
        identified.choose(path)
    assert 'p.json' in str(error.value) and '\n' not in str(error.value)


@pytest.mark.skipif(browser.find_browser() is None, reason='no Chromium')
def test_what_is_clicked_in_the_report_is_what_identify_repeats(ama, record, identified, tmp_path):
    """A mode is let go, a pole of none is taken, the choice is saved and repeated."""
    identified.save(tmp_path)
    poles = identified.found.whole.poles
    gone = identified.modes.modes[0]
    keep_text = (
        'window.saved = null; const make = URL.createObjectURL;'
        'URL.createObjectURL = (blob) => { blob.text().then((t) => { window.saved = t; });'
        ' return make.call(URL, blob); };'
    )
    with browser.browser_page() as page:
        page.open(tmp_path / 'report.html')
        page.evaluate(keep_text)
        page.evaluate("document.querySelector('#stabilisation').scrollIntoView()")
        clicked = [rows_of(identified, gone.id)[-1], lonely(poles)]
        for row in clicked:
            click(page, float(poles.frequency_hz[row]), int(poles.model_order[row]))
        told = page.evaluate("document.querySelector('.picker .note').textContent")
        assert told == '2 of the modes and 1 single poles are picked'
        page.evaluate("[...document.querySelectorAll('.picker button')].at(-1).click()")
        page.until('window.saved !== null')
        (tmp_path / 'poles.json').write_text(page.evaluate('window.saved'))
        assert page.problems == []
    run = ama(
        'identify',
        record,
        '--sample-rate-hz',
        RATE_HZ,
        '--poles',
        tmp_path / 'poles.json',
        '--json',
    )
    assert run.returncode == 0, run.stderr
    found = [mode['frequency_hz'] for mode in json.loads(run.stdout)['modes']]
    expected = [*identified.frequencies_hz[1:], poles.frequency_hz[clicked[1]]]
    np.testing.assert_allclose(sorted(found), sorted(expected), rtol=1e-9)


def lonely(poles):
    """Return a shown pole of no mode that no other lies near to."""
    groups = (poles.status > 3) & (poles.status != 10) & (poles.mode_id == 0)
    scale = np.array([0.3, 1.0])
    at = np.column_stack([poles.frequency_hz, poles.model_order]) / scale
    away = [np.sort(np.linalg.norm(at - at[row], axis=1))[1] for row in np.flatnonzero(groups)]
    return int(np.flatnonzero(groups)[np.argmax(away)])


def click(page, frequency_hz, order):
    box = page.evaluate(
        '(({x, y, width, height}) => ({x, y, width, height}))'
        "(document.querySelector('#stabilisation .u-over').getBoundingClientRect())"
    )
    data = "JSON.parse(document.getElementById('report-data').textContent).stabilisation"
    highest_hz = page.evaluate(f'{data}.spectrum.frequency_hz.at(-1)')
    top = page.evaluate(f'Math.max(...{data}.poles.model_order)') * 1.03
    x = box['x'] + box['width'] * frequency_hz / highest_hz
    y = box['y'] + box['height'] * (1 - order / top)
    for kind in ('mouseMoved', 'mousePressed', 'mouseReleased'):
        page.mouse(kind, x, y, button='none' if kind == 'mouseMoved' else 'left', clickCount=1)
