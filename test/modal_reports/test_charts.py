"""Still pictures: what is drawn lies where the numbers say, names are only ever text."""

import math
import xml.etree.ElementTree as ElementTree

import numpy as np
import pytest

from modal_reports import (
    Bar,
    bar_chart,
    complexity_plot,
    damping_plane,
    error_mark,
    heat_map,
    HeatScale,
    meter,
    percent,
    PlacedMode,
    spectrum_plot,
)
from modal_reports.charts.plain_numbers import number, numbers

HOSTILE = '</svg><script>1</script>"\'&'
SVG = '{http://www.w3.org/2000/svg}'


def parsed(picture):
    text = str(picture).replace('<svg', '<svg xmlns="http://www.w3.org/2000/svg"', 1)
    return ElementTree.fromstring(text)


def kinds(picture, tag):
    return list(parsed(picture).iter(f'{SVG}{tag}'))


def points(line):
    return np.array([pair.split(',') for pair in line.get('points').split()], dtype=float)


def words(picture):
    return [each.text for each in kinds(picture, 'text')]


def test_curves_are_logarithmic_and_end_at_the_frame():
    frequency = np.linspace(5.0, 45.0, 201)
    values = 10.0 ** np.linspace(-2, 1, 201)
    picture = spectrum_plot('elbow.x', frequency, [('before', values)], 1e-2)
    (curve,) = kinds(picture, 'polyline')
    place = points(curve)
    # An exponential is straight on a logarithmic axis; places have one decimal.
    assert np.abs(np.diff(place[:, 1], 2)).max() < 0.21
    assert place[0, 0] == pytest.approx(44.0) and place[-1, 0] == pytest.approx(450.0)
    assert {'1e-2', '1e0', 'Hz', '10', '40'} <= set(words(picture))


@pytest.mark.parametrize('top_hz', [0.7, 3.0, 60.0, 900.0, 12_000.0])
def test_an_axis_has_some_round_numbers_whatever_its_band(top_hz):
    picture = spectrum_plot('', np.linspace(0.0, top_hz, 50), [('after', np.ones(50))], 0.1)
    numbers = [word for word in words(picture) if word and word.replace('.', '').isdigit()]
    assert 4 <= len(numbers) <= 11, numbers


@pytest.mark.parametrize('values', [np.zeros(9), np.full(9, 1e-30), np.full(9, 1e30)])
def test_extreme_curves_stay_inside(values):
    picture = spectrum_plot('', np.arange(9.0), [('measured', values)], 0.0)
    (curve,) = kinds(picture, 'polyline')
    assert np.all((points(curve)[:, 1] >= 26.0) & (points(curve)[:, 1] <= 180.0))


def test_bars_and_their_error_bars_are_to_scale():
    bars = [Bar('one', 0.4, 'before', 0.05), Bar('two', 0.1, 'after'), Bar('?', math.nan, 'after')]
    picture = bar_chart('gaps', bars, percent, ('noise', 0.02))
    long, short = (float(each.get('width')) for each in kinds(picture, 'rect'))
    assert long / short == pytest.approx(4.0, rel=0.01)
    middle, *_ = [each for each in kinds(picture, 'line') if each.get('class') == 'error']
    reach = float(middle.get('x2')) - float(middle.get('x1'))
    assert reach == pytest.approx(4 * 0.05 / 0.4 * long, abs=0.2), '±2 σ'
    assert {'40.0 %', '10.0 %', 'noise'} <= set(words(picture))


def test_a_map_has_its_numbers_and_leaves_the_unknown_empty():
    values = np.array([[1.0, 0.2], [0.2, math.nan]])
    picture = heat_map(
        'MAC', ['a', 'b'], ['a', 'b'], [('', values)], HeatScale(0, 1), '{:.2f}'.format
    )
    steps = [each.get('class') for each in kinds(picture, 'rect')]
    assert steps == ['heat-7', 'heat-1', 'heat-1']
    assert words(picture).count('0.20') == 2
    assert 'on-heat-7' in str(picture)


def test_an_error_lies_at_its_place_and_a_far_one_is_marked():
    (dot,) = kinds(error_mark(2.0), 'circle')
    assert (float(dot.get('cx')), dot.get('class')) == (62.0, 'dot')
    (dot,) = kinds(error_mark(-30.0), 'circle')
    assert (float(dot.get('cx')), dot.get('class')) == (2.0, 'far')
    assert error_mark(math.nan) == meter(math.nan) == ''
    assert float(kinds(meter(0.25), 'rect')[1].get('width')) == 20.0


def test_names_are_only_ever_text():
    noise = np.ones(4)
    pictures = (
        spectrum_plot(HOSTILE, np.arange(4.0), [(HOSTILE, noise)], 0.1),
        bar_chart(HOSTILE, [Bar(HOSTILE, 1.0, HOSTILE)], percent, (HOSTILE, 1.0)),
        heat_map(
            HOSTILE, [HOSTILE], [HOSTILE], [(HOSTILE, np.ones((1, 1)))], HeatScale(0, 1), str
        ),
    )
    for picture in pictures:
        assert not kinds(picture, 'script')
        assert any(word.startswith('</svg><script>') for word in words(picture))


def test_points_of_a_shape_have_its_amplitudes_and_phases():
    shape = np.array([2.0, -1.0, 1.0j, np.nan])
    picture = complexity_plot('shapes', [(HOSTILE, shape), ('none', np.zeros(2))])
    lines = [each for each in kinds(picture, 'line') if each.get('class') == 'point']
    ends = np.array(
        [[float(each.get(name)) for name in ('x1', 'y1', 'x2', 'y2')] for each in lines]
    )
    moved = (ends[:, 2] - ends[:, 0]) - 1j * (ends[:, 3] - ends[:, 1])
    np.testing.assert_allclose(moved / moved[0].real, [1.0, -0.5, 0.5j], atol=0.01)
    assert words(picture) == [HOSTILE, 'none']


def test_modes_lie_in_the_plane_where_their_numbers_say():
    modes = [
        PlacedMode(HOSTILE, 10.0, 1.0, 0.5, 0.2),
        PlacedMode('second', 20.0, 3.0, 1.0, 0.1),
        PlacedMode('no deviation', 30.0, 2.0),
    ]
    picture = damping_plane('damping', modes)
    dots = [each for each in kinds(picture, 'circle') if each.get('class') == 'dot']
    places = np.array([[float(each.get('cx')), float(each.get('cy'))] for each in dots])
    per_hz, per_percent = np.diff(places[:2], axis=0)[0] / (10.0, 2.0)
    assert per_hz > 0.0 > per_percent
    np.testing.assert_allclose(places[2] - places[0], [20.0 * per_hz, per_percent], atol=0.2)
    ellipses = kinds(picture, 'ellipse')
    axes = [[float(each.get('rx')), float(each.get('ry'))] for each in ellipses]
    expected = [[1.0 * per_hz, -0.4 * per_percent], [2.0 * per_hz, -0.2 * per_percent]]
    np.testing.assert_allclose(axes, expected, atol=0.2)


@pytest.mark.parametrize('frequency_hz', [1e-6, 1e7])
def test_a_single_mode_without_damping_has_a_place(frequency_hz):
    (dot,) = kinds(damping_plane('damping', [PlacedMode('one', frequency_hz, 0.0)]), 'circle')
    assert math.isfinite(float(dot.get('cx'))) and math.isfinite(float(dot.get('cy')))


def test_many_numbers_at_once_are_those_one_by_one():
    seed = 12
    rng = np.random.default_rng(seed)
    values = rng.normal(size=3000) * 10.0 ** rng.uniform(-14, 5, 3000)
    values[:6] = 0.0, np.nan, np.inf, -np.inf, 1.0, 123456.75
    together, single = numbers(values), [number(value) for value in values.tolist()]
    assert together[:6] == single[:6] == [0.0, None, None, None, 1.0, 123456.8]
    # Half of the last digit may fall either way; what is written has no more digits.
    for one, other in zip(together[4:], single[4:], strict=True):
        assert one == pytest.approx(other, rel=2e-6)
        assert float(f'{one:.7g}') == one, seed
    assert numbers(np.array([[1e300, 2e-300]])) == [[1e300, 2e-300]]
    assert numbers(np.empty((0,))) == []
