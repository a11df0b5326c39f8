"""Curves with units: what the chart is given, and what a browser makes of it."""

import numpy as np
import pytest

from modal_core.files.atomic_file import write_text
from modal_reports import Axis, Curves, curves_data, Page, render, Trace
from test.support import browser


def chart(**options):
    x = np.linspace(0.0, 10.0, 101)
    traces = [Trace('measured', x, 2.0 + np.sin(x)), Trace('after', x, 2.0 + np.cos(x), 'model')]
    return Curves('twist', Axis('load', 'kN m'), Axis('twist', 'µrad'), traces, **options)


def test_units_stand_at_the_axes_and_long_curves_are_thinned():
    x = np.arange(10_000.0)
    data = curves_data(Curves('t', Axis('time', 's'), Axis('share'), [Trace('after', x, x)]))
    assert data['across'] == {'words': 'time [s]', 'unit': 's'}
    assert data['up'] == {'words': 'share', 'unit': ''}
    (trace,) = data['traces']
    assert 1000 < len(trace['x']) <= 1500
    assert trace['x'] == trace['y']
    assert trace['name'] == 'after'


def test_decades_have_no_place_for_nought():
    curves = Curves(
        't', Axis('f'), Axis('a'), [Trace('after', np.arange(3.0), np.arange(3.0))],
        logarithmic=True,
    )  # fmt: skip
    assert curves_data(curves)['traces'][0]['y'] == [None, 1.0, 2.0]


@pytest.mark.skipif(browser.find_browser() is None, reason='no Chromium')
@pytest.mark.parametrize(('width', 'dark'), [(1400, False), (390, True)])
def test_pointing_says_values_with_units_and_dragging_zooms(tmp_path, width, dark):
    template = tmp_path / 'p.html.j2'
    template.write_text(
        "{% extends 'page.html.j2' %}{% block main %}"
        '<figure class="chart" data-chart="curves" data-of="0"></figure>'
        '<details><summary>more</summary>'
        '<figure class="chart lesser" data-chart="curves" data-of="1"></figure></details>'
        '{% endblock %}'
    )
    loop = Curves(
        'loop', Axis('load', 'kN m'), Axis('twist', 'µrad'),
        [Trace('measured', np.cos(np.arange(50.0)), np.sin(np.arange(50.0)))],
    )  # fmt: skip
    charts = {'curves': [curves_data(chart(logarithmic=True, level=0.5)), curves_data(loop)]}
    path = tmp_path / 'p.html'
    write_text(path, render(Page('kind', 'title', template, {}, charts)))
    with browser.browser_page() as page:
        page.open(path, width=width, dark=dark)
        assert page.problems == []
        assert page.evaluate('document.documentElement.scrollWidth') <= width
        label = page.evaluate("document.querySelector('.uplot').getAttribute('aria-label')")
        assert label == 'twist: twist [µrad] over load [kN m]'
        over = "document.querySelector('.u-over').getBoundingClientRect()"
        box = page.evaluate(f'(({{x, y, width, height}}) => ({{x, y, width, height}}))({over})')
        low, high = 3.0 * 1.4 * 10**-1.5, 3.0 * 1.4
        share = np.log(3.0 / low) / np.log(high / low)
        # The model's greatest value, 3 at no load.
        x, y = box['x'] + 3, box['y'] + box['height'] * (1.0 - share)
        page.mouse('mouseMoved', x + 4, y)
        page.mouse('mouseMoved', x, y)
        page.evaluate('new Promise((done) => setTimeout(done, 100))')
        said = page.evaluate("document.getElementById('tooltip').textContent").split('\n')
        assert said[0].endswith('kN m')
        assert said[1].startswith('measured: 2') and said[1].endswith(' µrad')
        assert said[2].startswith(('model: 3', 'model: 2.9')) and said[2].endswith(' µrad')
        hidden = "document.querySelector('.curves-head button').hidden"
        assert page.evaluate(hidden) is True
        page.mouse('mousePressed', x + 30, y, button='left', clickCount=1)
        page.mouse('mouseMoved', x + 120, y + 60, button='left')
        page.mouse('mouseReleased', x + 120, y + 60, button='left', clickCount=1)
        assert page.evaluate(hidden) is False
        page.evaluate("document.querySelector('.curves-head button').click()")
        assert page.evaluate(hidden) is True
        page.evaluate("document.querySelector('details').open = true")
        page.evaluate('new Promise((done) => setTimeout(done, 100))')
        wide = "[...document.querySelectorAll('.uplot')].map((plot) => plot.clientWidth)"
        first, second = page.evaluate(wide)
        assert first == second > 300


@pytest.mark.skipif(browser.find_browser() is None, reason='no Chromium')
def test_a_logarithmic_axis_may_begin_anywhere(tmp_path):
    """Places made by adding up never reached the end of an axis that begins at 0.0955."""
    template = tmp_path / 'p.html.j2'
    template.write_text("{% extends 'page.html.j2' %}{% block main %}<p></p>{% endblock %}")
    path = tmp_path / 'p.html'
    write_text(path, render(Page('kind', 'title', template, {}, {'none': 0})))
    with browser.browser_page() as page:
        page.open(path)
        for low, high in ((0.0955, 2004.0), (0.0955, 0.5), (3.1e-9, 4e-9), (1.0, 10.0)):
            places = page.evaluate(f'modal.logAxis({{}}).splits(null, 0, {low}, {high})')
            assert 1 <= len(places) < 60
            assert all(low <= place <= high for place in places)
            named = page.evaluate(f'modal.logAxis({{}}).values(null, {places})')
            assert any(named)
