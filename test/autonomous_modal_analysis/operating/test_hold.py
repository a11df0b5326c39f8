"""What counts as holding a key or a button down, and how soon a release is noticed."""

from types import SimpleNamespace

import numpy as np
import pytest

from autonomous_modal_analysis.operating.beats import BeatReport
from autonomous_modal_analysis.operating.held_run import HeldRun
from autonomous_modal_analysis.operating.hold import BUTTON_SIGNS, GAP_S, Hold, KEY_SIGNS
from autonomous_modal_analysis.operating.holding import ButtonHolding
from robot_bridge.operator import FlowState


def looked_at(hold, signs_s, until_s, every_s=0.01):
    """Give a hold its signs as time passes; return the times it counted as held."""
    held, waiting = [], sorted(signs_s)
    for now_s in np.arange(0.0, until_s, every_s):
        while waiting and waiting[0] <= now_s:
            hold.sign(waiting.pop(0))
        hold.look(now_s)
        if now_s <= hold.until_s:
            held.append(now_s)
    return np.array(held)


def key(delay_s, repeat_s, until_s):
    return [0.0, *np.arange(delay_s, until_s, repeat_s)]


@pytest.mark.parametrize('delay_s', [0.2, 0.5, 1.0])
@pytest.mark.parametrize('repeat_s', [0.02, 0.033, 0.1])
def test_a_key_that_is_held_counts_until_shortly_after_its_last_repeat(delay_s, repeat_s):
    signs = key(delay_s, repeat_s, 5.0)
    held = looked_at(Hold(), signs, 8.0)
    assert held[0] <= delay_s + 3 * repeat_s + 0.26
    assert np.diff(held).max() < 0.02
    assert held[-1] <= signs[-1] + GAP_S + 1e-9


@pytest.mark.parametrize(
    'signs',
    [
        [0.0],
        [0.0, 0.5],
        [0.0, 1.5, 3.0, 4.5, 6.0],
        [0.0, 0.0, 0.0, 0.0, 0.0],
        [0.0, 0.01, 0.02, 0.03, 0.04, 0.05],
    ],
    ids=['one stroke', 'two', 'slow strokes', 'pasted', 'pasted in parts'],
)
def test_strokes_and_pasted_text_are_no_hold(signs):
    assert not len(looked_at(Hold(), signs, 8.0))


def test_what_is_over_stays_over():
    signs = [*key(0.5, 0.03, 2.0), *(3.0 + np.array(key(0.5, 0.03, 2.0)))]
    held = looked_at(Hold(), signs, 6.0)
    assert held[-1] < 2.0 + GAP_S


def test_random_keyboards_never_count_as_held_longer_than_stated():
    seed = 20
    rng = np.random.default_rng(seed)
    for _ in range(200):
        gaps = rng.choice([0.02, 0.03, 0.09, 0.2, 0.35, 0.8], 60)
        signs = np.cumsum(gaps)
        held = looked_at(Hold(), signs, signs[-1] + 1.0)
        since = [now - signs[signs <= now + 1e-9][-1] for now in held]
        assert max(since, default=0.0) <= GAP_S + 1e-9, f'seed {seed}'


def test_a_button_must_have_been_up_before_and_lets_go_at_once():
    waiting = []

    def look():
        found, waiting[:] = list(waiting), []
        return found

    holding = ButtonHolding(look, 4)
    hold = holding.begin(0.0)
    assert 'no word of button 4' in holding.words
    for number in range(20):  # held since before the release
        waiting.append((True, 0.05 * number))
        holding.look(hold, 0.05 * number)
    assert not hold.begun and 'let it go first' in holding.words
    for number in range(20, 40):
        waiting.append((number > 21, 0.05 * number))
        holding.look(hold, 0.05 * number)
    assert hold.begun and not hold.over and 'hold button 4 down' in holding.words
    waiting.append((False, 2.0))
    holding.look(hold, 2.0)
    assert hold.over and hold.until_s < 0.0


def test_a_button_that_is_silent_is_let_go():
    hold = Hold(BUTTON_SIGNS, GAP_S)
    held = looked_at(hold, np.arange(0.0, 2.0, 0.05), 4.0)
    assert 1.95 < held[-1] <= 1.95 + GAP_S
    assert KEY_SIGNS > BUTTON_SIGNS and hold.over


def test_a_hold_that_was_over_before_the_start_may_begin_again_under_the_same_release():
    now_s = 100.0
    asked, held = [], []
    cell = SimpleNamespace(
        situation=lambda: SimpleNamespace(
            state=FlowState.ARMED, heard_s=now_s, progress=0.0, reason=''
        ),
        hold=lambda token, until_s: held.append(until_s),
        let_go=held.append,
        start_later=lambda token: asked.append(token) or (lambda: None),
        report=BeatReport,
    )
    signs = []

    def look():
        found, signs[:] = list(signs), []
        return found

    run = HeldRun(cell, ButtonHolding(look, 2), 'token')

    def press(pressed, seconds):
        nonlocal now_s
        for _ in range(round(seconds / 0.05)):
            now_s += 0.05
            signs.append((pressed, now_s))
            yield run.look(now_s)

    # Held just too short to be started, then let go: the release still stands.
    assert not any([*press(False, 0.2), *press(True, 0.35), *press(False, 0.2)])
    assert not asked and held[-1] == 'token' and 'before the start' in run.words
    # Held again: started; let go now, it is over for good.
    assert not any(press(True, 1.0)) and asked == ['token']
    outcome = next(press(False, 0.05))
    assert not outcome.done and 'let go' in outcome.words
    assert 'let go' in next(press(True, 0.5)).words
