"""Pages without scripts, in a real browser: tables, folds, themes, paper, hostile names."""

import pytest

from modal_reports import (
    Cell,
    FREQUENCY,
    heading,
    measured,
    number,
    Page,
    palette,
    render,
    Row,
    Table,
    tags,
    text,
)
from test.support import browser

HOSTILE = '</style></script><script>window.hacked=1</script><img src=x onerror="window.hacked=1">'
BODY = """{% extends 'page.html.j2' %}{% import 'parts.html.j2' as kit %}
{% block main %}<section>{{ kit.table(table) }}
{% call kit.folded(name) %}<p id="inside">{{ name }}</p>{% endcall %}
{{ kit.entries([(name, name)]) }}</section>{% endblock %}"""


pytestmark = pytest.mark.skipif(
    browser.find_browser() is None,
    reason='no Chromium: apt-get install chromium to test the report in a browser',
)


@pytest.fixture(scope='module')
def page():
    with browser.browser_page() as opened:
        yield opened


def written(folder, name, n_columns=3):
    template = folder / 'body.html.j2'
    template.write_text(BODY)
    cells = [text(name), *measured(FREQUENCY, 3.42, 0.018), *[number('1.0')] * n_columns]
    table = Table(
        name,
        [text(name), heading(FREQUENCY), *[number('MAC')] * n_columns],
        [Row([*cells, tags((name, 'bad'))], 'best')],
        name,
    )
    assert isinstance(cells[0], Cell)
    path = folder / 'report.html'
    path.write_text(render(Page(name, name, template, {'table': table, 'name': name})))
    return path


def opened(page, path, **options):
    page.problems.clear()
    page.requests.clear()
    page.open(path, **options)
    assert page.problems == []
    assert page.requests == [path.resolve().as_uri()]


def test_hostile_names_are_shown_and_not_run(page, tmp_path):
    path = written(tmp_path, HOSTILE)
    opened(page, path)
    assert page.evaluate('window.hacked') is None
    assert page.evaluate("document.querySelectorAll('script, img').length") == 0
    for element in ('h1', 'caption', 'td', '#inside', 'dt', '.tag'):
        assert page.evaluate(f"document.querySelector('{element}').textContent") == HOSTILE


@pytest.mark.parametrize(
    'evil', ['<script>window.hacked=1</script>', '<style>*{color:red}</style>']
)
def test_policy_refuses_what_is_not_ours(page, tmp_path, evil):
    path = written(tmp_path, 'a name')
    path.write_text(path.read_text().replace('</body>', f'{evil}</body>'))
    page.problems.clear()
    page.open(path)
    assert page.evaluate('window.hacked') is None
    assert any('Content Security Policy' in problem for problem in page.problems)


@pytest.mark.parametrize('dark', [False, True])
def test_the_readers_system_chooses_the_theme(page, tmp_path, dark):
    opened(page, written(tmp_path, 'a name'), dark=dark)
    paper = palette.ROLES['paper'][dark]
    wanted = ', '.join(str(int(paper[at : at + 2], 16)) for at in (1, 3, 5))
    assert page.evaluate('getComputedStyle(document.body).backgroundColor') == f'rgb({wanted})'


def test_a_wide_table_scrolls_in_its_frame_alone(page, tmp_path):
    opened(page, written(tmp_path, 'a name', n_columns=60), width=420)
    assert page.evaluate('document.documentElement.scrollWidth') <= 420
    assert page.evaluate("document.querySelector('.scroll').scrollWidth") > 1000


def test_paper_is_white_and_unfolded_whatever_the_screen_was(page, tmp_path):
    opened(page, written(tmp_path, 'a name'), dark=True)
    dark = [{'name': 'prefers-color-scheme', 'value': 'dark'}]
    page.call('Emulation.setEmulatedMedia', media='print', features=dark)
    try:
        background = page.evaluate('getComputedStyle(document.body).backgroundColor')
        height = page.evaluate("document.querySelector('#inside').getBoundingClientRect().height")
    finally:
        page.call('Emulation.setEmulatedMedia', media='', features=[])
    assert background == 'rgb(255, 255, 255)'
    assert height > 5.0, 'what is folded on the screen is read on paper'
