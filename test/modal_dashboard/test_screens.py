"""What the screens say, without a browser and without ROS."""

from dataclasses import replace
import json
import math

import numpy as np
import pytest

from modal_core.mode import ModeSet
from modal_core.quality import DataQuality
from modal_dashboard.screens import (
    BridgeNews,
    Check,
    Checks,
    CheckStep,
    pole_table,
    RunLog,
    Update,
    window_updates,
)
from test.support.kept_results import window

RNG = np.random.default_rng(7)


def told(update):
    return json.loads(update.data)


def words(updates):
    return [told(update)['words'] for update in updates]


def bridge(**changes):
    values = dict.fromkeys(BridgeNews.__dataclass_fields__, 0)
    texts = ('state', 'backend', 'controller', 'reason', 'plan_hash', 'controller_state')
    return BridgeNews(**{**values, **dict.fromkeys(texts, ''), 'state': 'idle', **changes})


def test_what_is_not_known_is_said_not_to_be():
    given = window(0, RNG)
    bare = tuple(
        replace(mode, frequency_std_hz=math.nan, damping_ratio_std=math.nan, mpc=math.nan)
        for mode in given.modes
    )
    given = replace(given, modes=ModeSet(bare, given.modes.channel_names))
    shown, track = map(told, window_updates(given, None, 1.0))
    first = [text for text, *_ in shown['modes']['rows'][0]['cells']]
    assert first[2] == first[4] == first[5] == '–'
    assert track['modes'][0]['frequency_std_hz'] is None


def test_a_node_that_falls_silent_is_not_shown_as_healthy():
    checks = Checks('/')
    assert checks.take([Check('/a: samples', CheckStep.OK, 'OK')], 0.0) == []
    assert checks.take([Check('/b: samples', CheckStep.OK, 'OK')], 4.0) == []
    (silent,) = checks.take([Check('/b: samples', CheckStep.OK, 'OK')], 6.0)
    assert silent.name == '/a: samples' and silent.step == CheckStep.STALE
    assert checks.take([], 7.0) == []
    rows = {row['cells'][0][0]: row['cells'][1][0] for row in told(checks.updates()[0])['rows']}
    assert rows == {'/a: samples': 'stale', '/b: samples': 'ok'}
    (again,) = checks.take([Check('/a: samples', CheckStep.OK, 'OK')], 8.0)
    assert again.step == CheckStep.OK


@pytest.mark.parametrize(('namespace', 'own'), [('/', '/x: page'), ('/hall', '/hall/x: page')])
def test_checks_of_other_cells_are_left_out(namespace, own):
    checks = Checks(namespace)
    for name in ('/x: page', '/hall/x: page', '/hall/cell/x: page', '/other/x: page'):
        checks.take([Check(name, CheckStep.ERROR, 'BAD')], 0.0)
    assert [row['cells'][0][0] for row in told(checks.updates()[0])['rows']] == [own]


def test_any_number_of_names_is_bounded():
    checks = Checks('/')
    checks.take([Check(f'/{n}: x', CheckStep.OK, 'OK') for n in range(5000)], 0.0)
    assert len(told(checks.updates()[0])['rows']) == 200


def test_the_log_says_what_changes_and_nothing_twice():
    log = RunLog()
    still = DataQuality(identifiable=False, reason='too quiet')
    windows = [window(number, RNG) for number in range(6)]
    none = ModeSet((), windows[0].modes.channel_names)
    windows[1:3] = [replace(each, modes=none, quality=still) for each in windows[1:3]]
    fewer = tuple(mode for mode in windows[5].modes if mode.id != 2)
    windows[5] = replace(windows[5], modes=ModeSet(fewer, none.channel_names))
    lines = [line for each in windows for line in words(log.window(each, 0.0))]
    assert lines == [
        'window 0: 4 modes',
        'window 1: not identifiable, too quiet',
        'window 3: 4 modes',
        'window 5: 3 modes; gone: 2',
    ]
    assert words(log.bridge(bridge(reason='heard'), 0.0)) == ['bridge idle: heard']
    assert log.bridge(bridge(reason='heard', progress=0.5), 0.0) == []


def test_a_bridge_that_fell_silent_is_said_to_be():
    silent = bridge(state='running', connected=True, motors_on=True).silent()
    shown = told(silent.update())
    assert shown['bad'] and shown['entries'][0] == ['State', 'silent']
    # What it last said is not repeated as if it still held.
    assert len(shown['entries']) == 2 and 'before: running' in shown['entries'][1][1]


def test_poles_whose_columns_differ_are_refused():
    three, two = np.ones(3), np.ones(2)
    with pytest.raises(ValueError, match='different numbers'):
        pole_table(three, two, three.astype(int), three.astype(np.uint8), three.astype(int))
    with pytest.raises(ValueError, match='unknown reason'):
        pole_table(three, three, three.astype(int), np.full(3, 99, np.uint8), three.astype(int))


@pytest.mark.parametrize('none', [0.0, -5.0, math.nan, math.inf])
def test_poles_that_no_structure_has_are_refused_without_a_warning(none):
    three, order, kept = np.arange(3.0) + 1.0, np.arange(3), np.zeros(3, np.uint8)
    with pytest.raises(ValueError, match='no frequency'):
        pole_table(np.array([1.0, none, 3.0]), three, order, kept, order)
    if not math.isfinite(none):
        with pytest.raises(ValueError, match='no frequency'):
            pole_table(three, np.array([1.0, none, 3.0]), order, kept, order)


def test_names_from_elsewhere_are_legible_and_bounded_on_the_page():
    given = {'imu\u202elive': ['b' * 1_000_000, 'line\nline', 2.0, None, True]}
    update = Update.of('checks', given)
    assert len(update.data) < 1200
    ((name, (long, lines, *others)),) = told(update).items()
    assert name == r'imu\u202elive' and long.startswith('bbb')
    assert (lines, others) == ('line\nline', [2.0, None, True])
