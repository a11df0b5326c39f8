"""Every state of a bridge names the next step."""

from dataclasses import replace

import pytest

from autonomous_modal_analysis.operating.situation import Act, next_step, Situation
from robot_bridge.operator import AWAY, FlowState

READY = Situation(
    state=FlowState.IDLE,
    reason='the controller is heard',
    backend='abb_egm',
    controller='cell 7',
    dry_run=False,
    connected=True,
    motors_on=True,
    controller_state='running',
    plan_hash='5' * 64,
    progress=0.0,
    heard_s=100.0,
)


@pytest.mark.parametrize(
    ('change', 'act', 'words'),
    [
        ({}, Act.RELEASE, ''),
        ({'state': FlowState.HOLDING}, Act.RELEASE, ''),
        ({'heard_s': 90.0}, Act.WAIT, 'ama up'),
        ({'state': FlowState.ABORTED, 'reason': 'link lost'}, Act.RESET, 'link lost'),
        ({'state': FlowState.RUNNING}, Act.WAIT, 'wait for its end'),
        ({'plan_hash': ''}, Act.WAIT, 'PLAN_REFUSED'),
        ({'motors_on': False}, Act.MOTORS, 'motors'),
        ({'controller_state': 'stopped'}, Act.PROGRAM, 'guidance program at the controller'),
        (
            {'backend': 'emulator', 'connected': False, 'reason': 'no feedback'},
            Act.PROGRAM,
            'emulated',
        ),
        # A program is heard only when it runs.
        ({'backend': 'abb_rapid', 'connected': False, 'reason': 'no stream'}, Act.RELEASE, ''),
        ({'reason': f'reset; {AWAY}: axis 4 by 0.8 deg'}, Act.WAY_BACK, 'axis 4'),
        ({'dry_run': True, 'motors_on': False}, Act.RELEASE, ''),
    ],
)
def test_the_next_step_is_named(change, act, words):
    step = next_step(replace(READY, **change), 100.5)
    assert step.act is act
    assert words in step.words
    assert act is Act.RELEASE or 'next: ' in step.words


def test_without_a_bridge_it_says_how_to_start_one():
    assert next_step(None, 0.0).act is Act.WAIT
