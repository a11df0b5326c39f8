"""The report in a real browser: no errors, everything drawn, hostile names only ever text."""

from dataclasses import replace
import math

import numpy as np
import pytest

from autonomous_modal_analysis.identified.results import IdentifiedWindow
from autonomous_modal_analysis.report import write_report
from modal_core.mode import Mode, ModeSet
from modal_core.poles import PoleTable
from modal_core.quality import ChannelQuality, DataQuality
from test.support import browser
from test.support import report_cases as cases

pytestmark = pytest.mark.skipif(
    browser.find_browser() is None,
    reason='no Chromium: apt-get install chromium to test the report in a browser',
)

HOSTILE = '</script><script>window.hacked=1</script><img src=x onerror="window.hacked=1">'


@pytest.fixture(scope='module')
def page():
    with browser.browser_page() as opened:
        yield opened


@pytest.fixture(scope='module')
def arm():
    chain, content = cases.identified()
    found = content.identification.modes.frequency_hz
    # The picture is only worth testing when it shows true modes.
    assert len(found) == len(chain.frequency_hz), f'seed {cases.SEED}: {found}'
    return content


def show(page, tmp_path, content, **options):
    page.problems.clear()
    page.requests.clear()
    path = tmp_path / 'report.html'
    write_report(path, content)
    page.open(path, **options)
    assert page.problems == []
    assert page.requests == [path.resolve().as_uri() + options.get('fragment', '')]
    return page


def inked(page, selector):
    """Return for each canvas of the selector how many of its pixels are painted."""
    return page.evaluate(
        f"""[...document.querySelectorAll('{selector}')].map((canvas) => {{
        const data = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height).data;
        let count = 0; for (let i = 3; i < data.length; i += 4) if (data[i]) count++; return count;
        }})"""
    )


def variant(arm, name):
    base = arm.identification
    whole = base.modes
    if name == 'no modes':
        return replace(
            arm,
            identification=replace(base, modes=ModeSet((), whole.channel_names), windows=()),
            poles=None, spectrum=None, truth=None, displacements=(),
        )  # fmt: skip
    if name == 'empty tables':
        empty = np.empty(0)
        poles = PoleTable(
            empty.astype(int), empty.astype(complex), np.empty((6, 0), complex),
            empty.astype(np.uint8), empty.astype(int),
        )  # fmt: skip
        none = ModeSet((), whole.channel_names)
        windows = tuple(replace(window, modes=none) for window in base.windows)
        spectrum = replace(arm.spectrum, frequency_hz=empty, singular_value=np.empty((0, 3)))
        identification = replace(
            base, modes=none, windows=windows,
            quality=DataQuality(identifiable=False, reason='too short'),
        )  # fmt: skip
        return replace(
            arm, identification=identification, poles=poles, spectrum=spectrum,
            truth=None, displacements=(),
        )  # fmt: skip
    if name == 'poles only':
        return replace(arm, spectrum=None, truth=None)
    if name == 'merged':
        return replace(
            arm, poles=None, spectrum=None, truth=None,
            identification=replace(base, windows=(), quality=DataQuality()),
        )  # fmt: skip
    if name == 'spectrum only':
        return replace(arm, poles=None)
    if name == 'no deviation':
        bare = tuple(
            replace(m, frequency_std_hz=math.nan, damping_ratio_std=math.nan, mpc=math.nan)
            for m in whole
        )
        return replace(
            arm, truth=None, identification=replace(base, modes=ModeSet(bare, whole.channel_names))
        )
    if name == 'one channel':
        one = tuple(replace(mode, shape=np.ones(1, complex)) for mode in whole)
        return replace(
            arm, geometry=None, displacements=(), truth=None,
            identification=replace(base, modes=ModeSet(one, ('imu.z',)), channels=()),
        )  # fmt: skip
    if name == 'forty modes, hundred windows':
        rng = np.random.default_rng(4)
        many = tuple(
            Mode(
                3.0 + 1.2 * number, 0.02,
                rng.normal(size=42) * np.exp(1j * rng.normal(0, 0.2, 42)),
                0.02, 0.002, 0.99, 0.05, number % 13 == 0, number,
            )
            for number in range(1, 41)
        )  # fmt: skip
        names = tuple(f'cell_{i // 3}/a_rather_long_sensor_name.{"xyz"[i % 3]}' for i in range(42))
        modes = ModeSet(many, names)
        windows = tuple(
            IdentifiedWindow(
                i, i * 10**10, (i + 1) * 10**10,
                ModeSet(tuple(replace(m, frequency_hz=m.frequency_hz + rng.normal(0, 0.05),
                                      frequency_std_hz=0.05) for m in many), names),
                DataQuality(flags=('degraded', 'odd_new_flag') if i % 30 == 0 else ()),
            )
            for i in range(100)
        )  # fmt: skip
        quality = DataQuality(
            flags=('degraded',),
            channels=tuple(
                ChannelQuality(n, n_lost=i % 7, measured_rate_hz=512.0, rms=0.3, excluded=i == 5,
                               flags=('flatline',) if i == 5 else ())
                for i, n in enumerate(names)
            ),
        )  # fmt: skip
        return replace(
            arm, truth=None, geometry=None, displacements=(), spectrogram=None,
            title='Many modes ' * 12,
            recording='/a/very/long/' + 'path' * 60,
            identification=replace(
                base, modes=modes, windows=windows, channels=(), quality=quality
            ),
        )  # fmt: skip
    assert name == 'arm'
    return arm


VARIANTS = (
    'arm', 'no modes', 'empty tables', 'poles only', 'spectrum only', 'no deviation',
    'one channel', 'forty modes, hundred windows', 'merged',
)  # fmt: skip


@pytest.mark.parametrize('name', VARIANTS)
@pytest.mark.parametrize('width', [1280, 420])
def test_every_case_draws_without_errors(page, tmp_path, arm, name, width):
    content = variant(arm, name)
    show(page, tmp_path, content, width=width, dark=width == 420)
    wide = page.evaluate('document.documentElement.scrollWidth')
    assert wide <= width, f'{name}: {wide} px wide'
    n_modes = len(content.identification.modes)
    shapes = inked(page, '.card canvas')
    assert len(shapes) == n_modes
    assert all(count > 50 for count in shapes)
    charts = inked(page, '[data-chart=stabilisation] .uplot canvas')
    if name not in ('no modes', 'empty tables', 'merged'):
        assert len(charts) == 1
        assert charts[0] > 2000
        assert (
            len(page.evaluate("[...document.querySelectorAll('#modes tbody tr')].map(r => 1)"))
            == n_modes
        )
    assert all(count > 50 for count in inked(page, '.strip canvas'))
    assert all(count > 2000 for count in inked(page, '#spectrogram .uplot canvas'))


def test_hostile_names_are_shown_and_not_run(page, tmp_path, arm):
    names = tuple(f'{HOSTILE}{index}' for index in range(6))
    base = arm.identification
    content = replace(
        arm,
        title=HOSTILE,
        recording=HOSTILE,
        geometry=None,
        displacements=(),
        identification=replace(
            base,
            modes=ModeSet(base.modes.modes, names),
            quality=DataQuality(
                False, HOSTILE, (HOSTILE,), tuple(ChannelQuality(n, flags=(n,)) for n in names)
            ),
            settings={HOSTILE: HOSTILE},
        ),
        provenance={HOSTILE: HOSTILE},
    )
    show(page, tmp_path, content)
    assert page.evaluate('window.hacked') is None
    assert page.evaluate("document.querySelectorAll('img').length") == 0
    assert page.evaluate("document.querySelector('h1').textContent") == HOSTILE


def test_policy_refuses_a_script_that_is_not_ours(page, tmp_path, arm):
    path = tmp_path / 'report.html'
    write_report(path, arm)
    path.write_text(path.read_text().replace('</body>', '<script>window.hacked=1</script></body>'))
    page.problems.clear()
    page.open(path)
    assert page.evaluate('window.hacked') is None
    assert any('Content Security Policy' in problem for problem in page.problems)


def test_hover_names_the_pole_and_drag_zooms(page, tmp_path, arm):
    show(page, tmp_path, arm)
    mode = arm.identification.modes.modes[1]
    page.evaluate("document.querySelector('#stabilisation').scrollIntoView()")
    box = page.evaluate(
        '(({x, y, width, height}) => ({x, y, width, height}))'
        "(document.querySelector('#stabilisation .u-over').getBoundingClientRect())"
    )
    data = "JSON.parse(document.getElementById('report-data').textContent).stabilisation"
    f_max = page.evaluate(f'{data}.spectrum.frequency_hz.at(-1)')
    top = page.evaluate(f'Math.max(...{data}.poles.model_order)') * 1.03
    kept = [i for i, m in enumerate(arm.poles.mode_id) if m and arm.poles.status[i] == 0]
    i = min(kept, key=lambda k: abs(arm.poles.frequency_hz[k] - mode.frequency_hz))
    x = box['x'] + box['width'] * arm.poles.frequency_hz[i] / f_max
    y = box['y'] + box['height'] * (1 - arm.poles.model_order[i] / top)
    page.mouse('mouseMoved', x - 3, y)
    page.mouse('mouseMoved', x, y)
    page.evaluate('new Promise((done) => setTimeout(done, 100))')
    text = page.evaluate("document.getElementById('tooltip').textContent")
    assert f'order {arm.poles.model_order[i]}' in text
    assert 'belongs to a mode' in text
    reset_hidden = "[...document.querySelectorAll('#stabilisation .tools button')].at(-1).hidden"
    assert page.evaluate(reset_hidden) is True
    page.mouse('mousePressed', x - 40, y, button='left', clickCount=1)
    page.mouse('mouseMoved', x + 40, y, button='left', buttons=1)
    page.mouse('mouseReleased', x + 40, y, button='left', clickCount=1)
    page.evaluate('new Promise((done) => setTimeout(done, 100))')
    assert page.evaluate(reset_hidden) is False
    assert page.problems == []


def test_spectra_of_channels_follow_the_choice_and_zoom_together(page, tmp_path, arm):
    show(page, tmp_path, arm)
    drawn = inked(page, '[data-chart=channel_spectra] .uplot canvas')
    assert len(drawn) == 2 and min(drawn) > 1000
    page.evaluate("document.querySelector('#channel_spectra').scrollIntoView()")
    before = page.evaluate(PIXELS)
    page.evaluate(
        "(() => { const choice = document.querySelector('#channel_spectra select');"
        " choice.value = '3'; choice.dispatchEvent(new Event('change')); })()"
    )
    assert page.evaluate(PIXELS) != before
    box = page.evaluate(
        '(({x, y, width, height}) => ({x, y, width, height}))'
        "(document.querySelector('#channel_spectra .u-over').getBoundingClientRect())"
    )
    x, y = box['x'] + box['width'] / 2, box['y'] + box['height'] / 2
    page.mouse('mouseMoved', x - 41, y)
    page.mouse('mouseMoved', x - 40, y)
    page.evaluate('new Promise((done) => setTimeout(done, 100))')
    said = page.evaluate("document.getElementById('tooltip').textContent")
    assert 'Hz' in said and 'measured' in said and 'synthesised' in said
    page.mouse('mousePressed', x - 40, y, button='left', clickCount=1)
    page.mouse('mouseMoved', x + 40, y, button='left', buttons=1)
    page.mouse('mouseReleased', x + 40, y, button='left', clickCount=1)
    page.evaluate('new Promise((done) => setTimeout(done, 100))')
    assert (
        page.evaluate("document.querySelector('#channel_spectra .tools button').hidden") is False
    )
    assert page.problems == []


def test_one_shape_is_enlarged_and_saved_as_a_film(page, tmp_path, arm):
    """The file is read by another program: thirty frames that move, and come back."""
    image = pytest.importorskip('PIL.Image')
    show(page, tmp_path, arm)
    page.evaluate(
        'window.saved = null; const make = URL.createObjectURL; URL.createObjectURL = (blob) => {'
        ' blob.arrayBuffer().then((all) => { window.saved = Array.from(new Uint8Array(all)); });'
        ' return make.call(URL, blob); };'
    )
    buttons = "[...document.querySelectorAll('.card')][1].querySelectorAll('button')"
    before = page.evaluate("document.querySelectorAll('.card canvas')[1].clientWidth")
    page.evaluate(f'{buttons}[1].click()')
    width = page.evaluate("document.querySelectorAll('.card canvas')[1].clientWidth")
    height = page.evaluate("document.querySelectorAll('.card canvas')[1].clientHeight")
    assert width > 2 * before and height > 400
    page.evaluate(f'{buttons}[0].click()')
    page.until('window.saved !== null')
    path = tmp_path / 'mode.gif'
    path.write_bytes(bytes(page.evaluate('window.saved')))
    with image.open(path) as film:
        assert film.size == (width, height) and film.n_frames == 30
        assert film.info['duration'] == 60 and film.info['loop'] == 0
        stills = []
        for number in (0, 15, 29):
            film.seek(number)
            stills.append(np.asarray(film.convert('RGB'), dtype=int))
    swing, step = (int(np.any(stills[0] != other, axis=2).sum()) for other in stills[1:])
    assert 0 < step < swing, 'half a period is further than a frame'
    assert path.stat().st_size < 1_500_000
    # What was drawn is what is in the file: the corner is paper.
    assert np.ptp(stills[0][:20, :20].reshape(-1, 3), axis=0).max() == 0
    page.evaluate(f'{buttons}[1].click()')
    assert page.evaluate("document.querySelectorAll('.card canvas')[1].clientWidth") == before
    assert page.problems == []


@pytest.mark.parametrize('width', [1400, 1280, 688])
def test_remarks_of_modes_are_not_cut_off(page, tmp_path, arm, width):
    """With the true modes known the table is widest; 688 px is what an A4 page leaves."""
    base = arm.identification
    odd = {id(mode): replace(mode, mpd=0.5, mpc=0.6) for mode in base.modes}
    modes = replace(base.modes, modes=tuple(odd.values()))
    truth = tuple(replace(true, mode=odd.get(id(true.mode))) for true in arm.truth)
    content = replace(arm, identification=replace(base, modes=modes), truth=truth)
    show(page, tmp_path, content, width=width)
    if width == 688:
        page.call('Emulation.setEmulatedMedia', media='print')
        page.evaluate('new Promise((done) => setTimeout(done, 200))')
    try:
        cut = page.evaluate(
            "[...document.querySelectorAll('#modes .scroll')]"
            '.map((each) => each.scrollWidth - each.clientWidth)'
        )
        assert 'phases scatter' in page.evaluate("document.querySelector('#modes').innerText")
        assert cut == [0]
    finally:
        page.call('Emulation.setEmulatedMedia', media='')


PIXELS = (
    "[...document.querySelectorAll('#channel_spectra .uplot canvas')]"
    ".map((canvas) => canvas.toDataURL()).join('|')"
)


@pytest.mark.parametrize('reduced', [True, False])
def test_motion_is_the_readers_choice(page, tmp_path, arm, reduced):
    show(page, tmp_path, arm, reduced=reduced)
    label = "document.getElementById('play').textContent"
    assert page.evaluate(label) == ('Play' if reduced else 'Pause')
    page.evaluate("document.getElementById('play').click()")
    assert page.evaluate(label) == ('Pause' if reduced else 'Play')


def test_prints_on_paper(page, tmp_path, arm):
    show(page, tmp_path, arm, dark=True)
    pdf = page.pdf()
    assert pdf.startswith(b'%PDF')
    assert page.problems == []
    assert page.evaluate('document.documentElement.dataset.theme') is None


def test_spectrogram_over_speed_and_time_says_what_is_pointed_at(page, tmp_path, arm):
    show(page, tmp_path, arm)
    assert len(inked(page, '#spectrogram .uplot canvas')) == 1
    choices = page.evaluate(
        "[...document.querySelectorAll('#spectrogram select option')].map((o) => o.textContent)"
    )
    assert choices == ['Speed of joint_1', 'Time from the start']
    page.evaluate("document.querySelector('#spectrogram').scrollIntoView()")
    over = "document.querySelector('#spectrogram .u-over').getBoundingClientRect()"
    box = page.evaluate(f'(({{x, y, width, height}}) => ({{x, y, width, height}}))({over})')
    data = "JSON.parse(document.getElementById('report-data').textContent).spectrogram"
    low, step, rows = page.evaluate(f'[{data}.low_hz, {data}.row_hz, {data}.n_rows]')
    mark = page.evaluate(f'{data}.marks[0]')
    seconds = page.evaluate(f'{data}.time.step * {data}.time.n_columns')
    page.evaluate(
        "(() => { const s = document.querySelector('#spectrogram select'); s.value = 1;"
        " s.dispatchEvent(new Event('change')); })()"
    )
    middle = page.evaluate(f'{data}.windows[{mark["window"]}]')
    x = box['x'] + box['width'] * sum(middle) / 2.0 / seconds
    y = box['y'] + box['height'] * (1.0 - (mark['frequency_hz'] - low) / (step * rows))
    page.mouse('mouseMoved', x - 3, y)
    page.mouse('mouseMoved', x, y)
    page.evaluate('new Promise((done) => setTimeout(done, 100))')
    assert page.evaluate("document.getElementById('tooltip').textContent").startswith(
        mark['words']
    )
    page.mouse('mouseMoved', x + 60, box['y'] + 5)
    page.evaluate('new Promise((done) => setTimeout(done, 100))')
    text = page.evaluate("document.getElementById('tooltip').textContent")
    assert 'Hz' in text
    assert '(SI unit)²/Hz' in text
    page.mouse('mousePressed', x, y, button='left', clickCount=1)
    page.mouse('mouseMoved', x + 80, y + 60, button='left')
    page.mouse('mouseReleased', x + 80, y + 60, button='left', clickCount=1)
    hidden = "document.querySelector('#spectrogram .tools button').hidden"
    assert page.evaluate(hidden) is False
    page.evaluate("document.querySelector('#spectrogram .tools button').click()")
    assert page.evaluate(hidden) is True
