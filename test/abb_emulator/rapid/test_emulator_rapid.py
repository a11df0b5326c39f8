"""Exported modules run from their own text; everything else is refused by its line."""

import itertools

import numpy as np
import pytest

from abb_emulator.drives.jerk_profile import jerk_profile
from abb_emulator.drives.joint_move import JointMove, MoveLimits
from abb_emulator.rapid.rapid_parser import parse_module
from excitation_planner.planner import plan_excitation
from excitation_planner.rapid.moves import moves_of
from excitation_planner.rapid.rapid import rapid_module
from excitation_planner.rapid_options import RapidOptions
from excitation_planner.request import PlanRequest
from modal_core.errors import BridgeError
from structural_model.robot_files import load_layout
from test.support.rapid_bench import Bench, CYCLE_S, FRAME, SEED


@pytest.fixture(scope='module')
def pulses(model):
    layout = load_layout('irb6660_205_190', 'sensors')
    request = PlanRequest(
        seed=SEED, duration_s=8.0, signal='random_pulses',
        start_position=tuple(model.pose('P1').tolist()),
    )  # fmt: skip
    return plan_excitation(model, layout, request)


@pytest.fixture
def bench(model, start_deg):
    return Bench(model, start_deg)


def stretches(planned):
    """Return beginning and end of every motion, in cycles."""
    moving = np.any(np.diff(planned, axis=0) != 0.0, axis=1)
    edges = np.flatnonzero(np.diff(np.concatenate([[0], moving, [0]]).astype(int)))
    return edges.reshape(-1, 2)


@pytest.mark.parametrize('stream', [True, False])
def test_an_exported_program_reaches_every_target_in_about_the_planned_time(
    pulses, model, bench, stream
):
    bench.task.load(rapid_module(pulses, model, RapidOptions(stream=stream)))
    assert bench.task.start()
    bench.to_the_end()
    planned = np.array(bench.planned)
    moves = moves_of(pulses, model)
    found = stretches(planned)
    assert len(found) == len(moves)
    for move, (begin, end) in zip(moves, found, strict=True):
        np.testing.assert_allclose(planned[end], np.degrees(move.target), atol=1e-5)
        took_s = (end - begin) * CYCLE_S
        assert abs(took_s - move.duration_s) < 3 * CYCLE_S
        way = planned[begin : end + 1]
        size = np.degrees(np.abs(move.displacement))
        for order, most in (
            (1, move.shape.peak_velocity),
            (2, move.shape.peak_acceleration),
            (3, move.shape.peak_jerk),
        ):
            peak = np.max(np.abs(np.diff(way, order, axis=0)), axis=0) / CYCLE_S**order
            assert np.all(peak <= most * size * 1.01 + 1e-9 / CYCLE_S**order), order
    for move, (_, end), (begin, _) in zip(moves, found, found[1:], strict=False):
        rest_s = (begin - end) * CYCLE_S
        # 20 to 60 ms of latency, after the motors stand: 20 ms dead time and the servo at most.
        assert move.pause_s + 0.02 - CYCLE_S < rest_s < move.pause_s + 0.06 + 0.02 + 0.06
    assert bench.controller.events[-1] == 'program at its end'


def test_axes_keep_within_speed_acceleration_and_jerk(pulses, model, bench):
    bench.task.load(rapid_module(pulses, model))
    bench.task.start()
    bench.to_the_end()
    planned = np.array(bench.planned)
    limits = model.limits
    for order, limit in ((1, limits.velocity), (2, limits.acceleration), (3, limits.jerk)):
        found = np.max(np.abs(np.diff(planned, order, axis=0)), axis=0) / CYCLE_S**order
        assert np.all(found <= np.degrees(limit) * (1 + 1e-6)), (order, found)


@pytest.mark.parametrize('way', [1e-3, 0.1, 5.0])
@pytest.mark.parametrize('limits', [(1.0, 10.0, 100.0), (100.0, 1.0, 1e3), (0.1, 10.0, 1.0)])
def test_jerk_profile_ends_at_rest_and_is_the_quickest(way, limits):
    profile = jerk_profile(way, *limits)
    time = np.linspace(0.0, profile.duration_s, 20001)
    found = np.array([profile.at(t) for t in time])
    step = time[1]
    assert found[-1] == pytest.approx(way, rel=1e-9)
    reached = []
    for order, limit in enumerate(limits, 1):
        peak = np.max(np.abs(np.diff(found, order))) / step**order
        assert peak <= limit * (1 + 1e-2) + 1e-16 / step**order
        reached.append(peak / limit)
    assert abs(found[-1] - found[-2]) / step < 1e-2 * limits[0] + limits[1] * step
    # Jerk is used throughout; without any of the limits it would be quicker.
    slower = min(jerk_profile(way, *(2 * limit for limit in limits)).duration_s, 1e9)
    assert slower < profile.duration_s


@pytest.mark.parametrize('kind', ['tool', 'turning', 'ratio', 'duration'])
def test_moves_keep_the_programmed_speed(model, start_deg, kind):
    target = start_deg + np.array([20.0, 5.0, -5.0, 10.0, 10.0, 0.0])
    chosen = {
        'tool': MoveLimits(tool_speed_mm_s=100.0),
        'turning': MoveLimits(turning_deg_s=5.0),
        'ratio': MoveLimits(tool_speed_mm_s=200.0, speed_ratio=0.5),
        'duration': MoveLimits(duration_s=7.0),
    }[kind]
    move = JointMove(model, start_deg, target, chosen, CYCLE_S)
    angles = [start_deg]
    while not move.finished:
        angles.append(move.step())
    serial = model.to_serial(np.radians(np.array(angles)))
    motion = model.kinematics.motion(serial)
    speed = np.linalg.norm(np.diff(motion.position[:, -1], axis=0), axis=1) / CYCLE_S
    turns = np.einsum('nij,nik->njk', motion.rotation[:-1, -1], motion.rotation[1:, -1])
    cosine = np.clip((np.trace(turns, axis1=1, axis2=2) - 1) / 2, -1, 1)
    turning = np.degrees(np.arccos(cosine)) / CYCLE_S
    expected = {'tool': 0.1, 'ratio': 0.1}
    if kind in expected:
        assert speed.max() == pytest.approx(expected[kind], rel=0.01)
    elif kind == 'turning':
        assert turning.max() == pytest.approx(5.0, rel=0.01)
    else:
        # The way takes this long at full speed; speeding up and slowing down come on top.
        fastest = np.abs(np.diff(angles, axis=0)).max(axis=0) / CYCLE_S
        np.testing.assert_allclose(fastest, np.abs(target - start_deg) / 7.0, rtol=1e-6)
    np.testing.assert_array_equal(angles[-1], target)


def test_pp_reset_starts_from_main_and_only_when_stopped(bench):
    bench.task.load(FRAME.format('TPWrite "begin"; WaitTime 1;'))
    bench.task.start()
    bench.cycles(60)
    assert not bench.task.reset()
    bench.task.stop()
    assert bench.task.start()
    assert bench.controller.events.count('TPWrite: begin') == 1
    bench.task.stop()
    assert bench.task.reset()
    assert bench.task.start()
    bench.to_the_end()
    assert bench.controller.events.count('TPWrite: begin') == 2


def test_stop_and_start_goes_on_with_the_move(bench):
    bench.task.load(FRAME.format('MoveAbsJ jA\\NoEOffs,v,fine,tool0; WaitTime 0.1;'))
    bench.task.start()
    bench.cycles(60)
    bench.task.stop()
    bench.cycles(60)
    assert 0.0 < bench.planned[-1][0] < 1.0
    assert bench.task.start()
    bench.to_the_end()
    assert bench.planned[-1][0] == 1.0


def test_speed_ratio_and_manual_mode_slow_a_move_down(model, start_deg):
    text = FRAME.format('MoveAbsJ jA\\NoEOffs,v5000,fine,tool0;').replace('[1,45', '[60,45')
    took = {}
    for name in ('full', 'half', 'manual'):
        bench = Bench(model, start_deg)
        bench.task.load(text.replace('v5000', 'v1000'))
        if name == 'half':
            assert bench.controller.set_speed_ratio(0.5)
        bench.controller.set_automatic(name != 'manual')
        bench.task.start()
        bench.to_the_end()
        took[name] = len(bench.planned) * CYCLE_S
        flange = model.kinematics.motion(
            model.to_serial(np.radians(np.array(bench.planned)))
        ).position[:, -1]
        speed = np.linalg.norm(np.diff(flange, axis=0), axis=1).max() / CYCLE_S
        limit = {'full': 1.0, 'half': 0.5, 'manual': 0.25}[name]
        assert speed == pytest.approx(limit, rel=0.01)
    assert took['full'] < took['half'] < took['manual']


REFUSED = (
    ('MoveL jA,v,fine,tool0;', 'instruction not executed'),
    ('MoveAbsJ jA,v,z10,tool0;', 'fine'),
    ('MoveAbsJ \\Conc,jA,v,fine,tool0;', 'conc'),
    ('MoveAbsJ jB,v,fine,tool0;', 'not declared'),
    ('MoveAbsJ v,v,fine,tool0;', 'wrong type'),
    ('WaitTime "1";', 'wrong type'),
    ('WaitTime 1', 'unexpected'),
    ('jA.robax:=[1,2,3,4,5,6];', 'constant'),
    ('v.v_max:=3;', 'no such field'),
    ('EGMActJoint e\\Q1:=[1,2];', 'option'),
    ('EGMSetupUC ROB_1,e,"default","d"\\Pose;', 'option'),
    ('EGMRunPose e,EGM_STOP_HOLD;', 'instruction not executed'),
    ('FOR i FROM 1 TO 3 DO WaitTime 1;', 'ENDFOR'),
    ('RETRY;', 'ERROR handler'),
    ('WaitTime 1; ~', 'not RAPID'),
)


@pytest.mark.parametrize(('statement', 'reason'), REFUSED)
def test_anything_else_is_refused_by_line(statement, reason):
    with pytest.raises(BridgeError) as caught:
        parse_module(FRAME.format(f'WaitTime 0;\n    {statement}'))
    text = str(caught.value)
    lines = (7, 8) if reason in ('unexpected', 'ENDFOR') else (7,)
    assert any(f'RAPID line {line}:' in text for line in lines), text
    assert reason.lower() in text.lower(), text
    assert '\n' not in text


def test_case_comments_and_layout_do_not_matter(bench):
    text = FRAME.format('moveabsj JA \\noeoffs , V , FINE , TOOL0 ; ! there\n WAITTIME 0.01;')
    bench.task.load(text.replace('MODULE Small', '! first\r\nmodule small'))
    bench.task.start()
    bench.to_the_end()
    assert bench.planned[-1][0] == 1.0


def test_a_broken_module_leaves_the_loaded_one_in_place(bench):
    bench.task.load(FRAME.format('WaitTime 1;'))
    with pytest.raises(BridgeError, match='line'):
        bench.task.load(FRAME.format('MoveJ jA;').replace('Small', 'Other'))
    assert bench.task.module.name == 'Small'


def test_the_error_handler_runs_and_the_program_ends(bench):
    text = FRAME.format(
        'FOR i FROM 1 TO 3 DO\n WaitTime rows{i};\n ENDFOR\n'
        'ERROR\n TPWrite "seen "\\Num:=ERRNO;\n EXIT;'
    ).replace('VAR egmident', 'CONST num rows{2}:=[0.01,0.02];\n VAR egmident')
    bench.task.load(text)
    bench.task.start()
    bench.to_the_end()
    assert any(event.startswith('TPWrite: seen ') for event in bench.controller.events)


def test_every_cut_of_an_exported_module_is_refused_in_one_line(pulses, model):
    text = rapid_module(pulses, model)
    random = np.random.default_rng(SEED)
    for place in itertools.islice(random.integers(10, len(text) - 12, 300), 300):
        with pytest.raises(BridgeError) as caught:
            parse_module(text[:place])
        assert '\n' not in str(caught.value)


@pytest.mark.parametrize(('axis', 'angle_deg'), [(0, 181.0), (2, 130.0), (2, -60.0)])
def test_a_target_out_of_range_is_refused_before_anything_moves(
    pulses, model, bench, start_deg, axis, angle_deg
):
    target = start_deg.copy()
    target[axis] = angle_deg
    head, mark, rest = rapid_module(pulses, model).partition('aTarget{')
    first, begin, others = rest.partition('\n')
    _, end, last = others.partition('],')
    row = '    [' + ','.join(f'{angle:.5f}' for angle in target)
    bench.task.load(head + mark + first + begin + row + end + last)
    bench.task.start()
    bench.to_the_end()
    assert any('out of range' in event for event in bench.controller.events)
    assert np.ptp(np.array(bench.planned), axis=0).max() == 0.0
