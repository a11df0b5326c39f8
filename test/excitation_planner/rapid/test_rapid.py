"""The RAPID module: what it says is what the plan says, in the documented subset."""

from dataclasses import replace
import re

import numpy as np
import pytest

from excitation_planner.plan import sealed
from excitation_planner.planner import plan_excitation
from excitation_planner.rapid.moves import moves_of
from excitation_planner.rapid.rapid import rapid_module
from excitation_planner.rapid_options import RapidOptions
from excitation_planner.request import PlanRequest
from modal_core.errors import ModalAnalysisError, PlanError
from structural_model import load_robot

AWAY = (
    r'Abs\(jNow\.(robax\.rax_(\d)-rHere\.rax_\2\)>nNear'
    r'|extax\.eax_(\w)-jNext\.extax\.eax_\3\)>nNearExternal)'
)
STATEMENTS = (
    r'MODULE \w+', 'ENDMODULE', r'PROC main\(\)', r'LOCAL PROC CheckPlace\(\)', 'ENDPROC', 'ERROR',
    'ENDFOR', 'ENDIF', r'FOR i FROM 1 TO nMoves DO', f'(?:IF|OR) {AWAY}( THEN)?',
    r'jNext\.extax:=jNow\.extax;', r'SetDO \w+,[01];',
    r'LOCAL CONST (num|robjoint|jointtarget|egm_minmax|speeddata) .*;',
    r'LOCAL VAR (jointtarget|robjoint|egmident) .*;', r'MotionSup\\On;', r'AccSet [^,]+,[^,]+;',
    r'MoveAbsJ \w+\\NoEOffs,\w+\\T:=\w+\{i\},fine,tool0;', r'WaitTime [^;]+;', 'CheckPlace;',
    r'\w+\.robax:=\w+\{i\};', r'rHere:=(aTarget\{i\}|jStart\.robax);', r'jNow:=CJointT\(\);',
    r'EGM(Reset|GetId|StreamStop) \w+;', r'EGMSetupUC ROB_1,.*;', r'EGMStreamStart .*;',
    r'EGMActJoint .*;', r'EGMRunJoint \w+,EGM_STOP_HOLD.*;', r'TPWrite ".{0,76}"(\\Num:=ERRNO)?;',
    'StopMove;', 'EXIT;',
)  # fmt: skip


@pytest.fixture(scope='module')
def robot():
    return load_robot('irb6660_205_190')


@pytest.fixture(scope='module')
def pulses(robot):
    return plan_excitation(robot, None, PlanRequest(signal='random_pulses', duration_s=20.0))


def statements(text):
    """Join data over several lines, drop comments."""
    bare = '\n'.join(line for line in text.splitlines() if not line.strip().startswith('!'))
    for line in re.sub(r',\n\s*|\[\n\s*', lambda m: m.group(0).rstrip()[0], bare).splitlines():
        if line.strip():
            yield line.strip()


def numbers(text, name):
    inside = re.search(rf'{name}\{{(\d+)\}}:=\[(.*?)\];', text, re.DOTALL)
    values = [float(v) for v in re.findall(r'-?[\d.]+', inside.group(2))]
    return int(inside.group(1)), np.array(values)


def test_only_the_documented_subset_is_used(robot, pulses):
    noise = plan_excitation(robot, None, PlanRequest(duration_s=4.0))
    assert noise.signal == 'sliding_noise'
    for text in (rapid_module(pulses, robot), rapid_module(noise, robot)):
        for line in statements(text):
            assert any(re.fullmatch(pattern, line) for pattern in STATEMENTS), line
        assert 'Rand' not in text
        assert '\\Conc' not in text


def test_numbers_are_the_plans_in_controller_degrees(robot, pulses):
    text = rapid_module(pulses, robot)
    count, flat = numbers(text, 'aTarget')
    targets = flat.reshape(count, 6)
    assert targets[-1] == pytest.approx([0, 45, -10, 90, -90, 0], abs=1e-4), 'ends at P1'
    for move, target in zip(moves_of(pulses, robot), targets, strict=True):
        end = round((move.start_s + move.duration_s) / pulses.sample_period_s)
        expected = np.rad2deg(robot.to_controller(pulses.position[end]))
        assert target == pytest.approx(expected, abs=1e-4)
    for name, low, high in (('aAcc', 20, 100), ('aRamp', 10, 100), ('aTime', 0.01, 10)):
        n_values, values = numbers(text, name)
        assert n_values == count == len(values)
        assert np.all((values >= low) & (values <= high))
    pauses = numbers(text, 'aPause')[1]
    total = sum(m.duration_s for m in moves_of(pulses, robot)) + np.sum(pauses)
    assert total == pytest.approx(pulses.duration_s, abs=0.02)


def test_header_and_safety(robot, pulses):
    text = rapid_module(pulses, robot)
    assert f'plan_hash {pulses.plan_hash}' in text
    assert f'seed {pulses.seed}' in text
    assert text.startswith(f'MODULE AmaExcitation_{pulses.plan_hash[:8]}\n')
    words = (
        'jNext.extax:=jNow.extax', 'CheckPlace', 'MotionSup\\On', 'CheckPlace', 'AccSet aAcc',
        'MoveAbsJ', 'EXIT',
    )  # fmt: skip
    place = text.index('PROC main()')
    for word in words:
        place = text.index(word, place) + 1
    assert text.count('MoveAbsJ') == 1
    assert text.index('AccSet 100,100', text.index('ENDFOR')) < text.index('ERROR')
    handler = text[text.index('  ERROR') :]
    for word in ('StopMove', 'AccSet 100,100', 'EGMReset', 'EXIT'):
        assert word in handler
    assert '\\CommTimeout:=0.1' in text
    assert 'EGM' not in rapid_module(pulses, robot, RapidOptions(stream=False))


def test_same_plan_same_module(robot, pulses):
    assert rapid_module(pulses, robot) == rapid_module(pulses, robot)


def test_guidance_module_leaves_room_for_the_plan(robot):
    plan = plan_excitation(robot, None, PlanRequest(duration_s=4.0))
    text = rapid_module(plan, robot)
    speed = float(re.search(r'MaxSpeedDeviation:=([\d.]+)', text).group(1))
    deviation = float(re.search(r'MaxPosDeviation:=([\d.]+)', text).group(1))
    assert speed > np.rad2deg(np.max(np.abs(robot.to_controller(plan.velocity))))
    axis = np.rad2deg(robot.to_controller(plan.position))
    assert deviation > np.max(np.abs(axis - axis[0]))
    assert float(re.search(r'CondTime:=([\d.]+)', text).group(1)) > plan.duration_s


def test_a_module_says_what_the_controller_calls_things(robot, pulses):
    noise = plan_excitation(robot, None, PlanRequest(duration_s=4.0))
    options = RapidOptions(
        tool='tShaker',
        load='lShaker',
        work_object='wobjCell',
        mechanical_unit='ROB_2',
        udp_device='EgmPort',
        digital_output='doMark',
        collision_detection=False,
    )
    text = rapid_module(pulses, robot, options)
    assert 'fine,tShaker\\WObj:=wobjCell\\TLoad:=lShaker;' in text
    assert 'EGMSetupUC ROB_2,egmStream,"default","EgmPort"' in text
    assert 'tool0' not in text and 'MotionSup' not in text and 'ROB_1' not in text
    for module in (text, rapid_module(noise, robot, options)):
        steps = list(statements(module))
        assert steps.count('SetDO doMark,1;') == 1
        begin = steps.index('SetDO doMark,1;')
        assert 'SetDO doMark,0;' in steps[: begin - 1], 'down before it goes up'
        assert 'SetDO doMark,0;' in steps[begin : steps.index('ERROR')]
        assert 'SetDO doMark,0;' in steps[steps.index('ERROR') :]
    plain = rapid_module(pulses, robot, RapidOptions(stream=False, collision_detection=False))
    assert not re.search('egm|MotionSup|SetDO', plain, re.IGNORECASE)


@pytest.mark.parametrize(
    'what', ['tool', 'load', 'work_object', 'mechanical_unit', 'digital_output']
)
@pytest.mark.parametrize('name', ['tool 0', '1st', 'a"b', 'x' * 33, 'tool0;ENDPROC', 'a\nb', 'ü'])
def test_a_name_that_rapid_does_not_take_is_refused(robot, pulses, what, name):
    with pytest.raises(PlanError, match=what) as caught:
        rapid_module(pulses, robot, RapidOptions(**{what: name}))
    assert len(str(caught.value).splitlines()) == 1


def test_other_robot_and_bad_name_are_refused(robot, pulses):
    generic = load_robot('generic_arm_6')
    if generic.joint_names != robot.joint_names:
        with pytest.raises(PlanError, match='another robot'):
            rapid_module(pulses, generic)
    with pytest.raises(PlanError, match='module name'):
        rapid_module(pulses, robot, RapidOptions(module_name='a b'))


NAMES = (
    'evil\n  LOCAL CONST num nNear:=9E9;\n  !', 'a\r  EXIT;', 'b\x85c\u2028d\x0ce', 'Ümläut 腕',
    '\x1b[2J', 'x' * 5000, 'quote"s', '\\',
)  # fmt: skip


@pytest.mark.parametrize('name', NAMES, ids=range(len(NAMES)))
def test_the_name_of_a_robot_is_a_comment_and_nothing_else(robot, pulses, name):
    plain = rapid_module(pulses, robot)
    text = rapid_module(sealed(replace(pulses, robot_name=name)), robot)
    assert text.isascii()
    assert all(letter == '\n' or letter.isprintable() for letter in text)
    assert list(statements(text))[1:] == list(statements(plain))[1:], 'all but the hash'
    assert len(text.splitlines()) == len(plain.splitlines())
    assert max(map(len, text.splitlines())) <= 300


def test_numbers_that_are_none_and_names_of_other_letters_are_refused(robot, pulses):
    for options in ({'low_pass_hz': float('nan')}, {'low_pass_hz': 1e9}, {'module_name': '_a'},
                    {'module_name': 'Ämä'}):  # fmt: skip
        with pytest.raises(ModalAnalysisError) as caught:
            rapid_module(pulses, robot, RapidOptions(**options))
        assert len(str(caught.value).splitlines()) == 1


GENTLE = {'acceleration_low': 0.02, 'acceleration_high': 0.1}
APART = {'synchronised': False}
HARD = {'ramp_low_s': 0.0, 'ramp_high_s': 0.0}


@pytest.mark.parametrize('wish', [GENTLE, APART, HARD], ids=['gentle', 'apart', 'hard'])
def test_moves_the_controller_would_play_otherwise_are_refused(robot, wish):
    """AccSet's floor would make them harder; joints apart, or steps of acceleration, it cannot."""
    request = PlanRequest(
        signal='random_pulses', duration_s=10.0, half_range=0.02, enforce_tolerance=False, **wish
    )
    plan = plan_excitation(robot, None, request)
    with pytest.raises(PlanError, match=r'another move|no move of all joints') as caught:
        rapid_module(plan, robot)
    assert len(str(caught.value).splitlines()) == 1
