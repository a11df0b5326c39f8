"""Guidance through module, UDP, law, dead time and servo; supervision; loss of the link."""

import cmath
import math

import numpy as np
import pytest

from abb_emulator.cell import CellSettings
from abb_emulator.controller_settings import ControllerSettings
from excitation_planner.rapid.rapid import rapid_module
from test.support.lockstep_sensor import LockstepSensor

CYCLE_S = 0.004032
# 20 ms in whole plant steps.
DEAD_S, SERVO_HZ, SERVO_ZETA = 41 / 2048.0, 25.0, 0.7
GAIN, LOW_PASS_HZ = 5.0, 100.0
# From 20 deg/s to standstill in 0.1 s.
STOPPING_DEG = 20.0 * (0.05 + 2 * CYCLE_S)
MODULE = """MODULE Guide
  CONST egm_minmax window:=[-0.001,0.001];
  VAR egmident e;
  PROC main()
    EGMGetId e;
    EGMSetupUC ROB_1,e,"default","UCdevice"\\Joint\\CommTimeout:={timeout};
    EGMActJoint e\\J1:=window\\J2:=window\\J3:=window\\J4:=window\\J5:=window\\J6:=window"""
MODULE += """\\LpFilter:=100\\MaxPosDeviation:={position}\\MaxSpeedDeviation:={speed};
    EGMRunJoint e,EGM_STOP_HOLD\\J1\\J2\\J3\\J4\\J5\\J6\\CondTime:=60\\RampInTime:=0.005;
    TPWrite "converged";
  ERROR
    TPWrite "lost "\\Num:=ERRNO;
    StopMove;
    EGMReset e;
    EXIT;
  ENDPROC
ENDMODULE
"""


def module(timeout=0.1, position=1000, speed=1000):
    return MODULE.replace('{timeout}', str(timeout)).replace('{position}', str(position)).replace(
        '{speed}', str(speed)
    )  # fmt: skip


@pytest.fixture
def guide(model, start_deg, peers):
    """Return a function that starts a module in lockstep and waits until it guides."""
    made = []

    def start(text=None, settings=None):
        sensor = LockstepSensor(model, start_deg, peers, text or module(), settings)
        made.append(sensor)
        return sensor.until(sensor.guided, start_deg)

    yield start
    for sensor in made:
        sensor.close()


def law(hz, with_speed):
    """From reference to commanded position, both at the cycles; see test_guidance_law.py."""
    z = cmath.exp(2j * math.pi * hz * CYCLE_S)
    keep = math.exp(-2 * math.pi * LOW_PASS_HZ * CYCLE_S)
    low_pass, integral = (1 - keep) / (1 - keep / z), CYCLE_S * z / (z - 1)
    forward = (GAIN + ((z - 1) / CYCLE_S if with_speed else 0.0)) * low_pass * integral
    # The answer to a cycle's message acts in the next cycle.
    return forward / (1 + GAIN * low_pass * integral / z) / z


def drive(hz):
    """From commanded to motor position at the cycles: straight lines, dead time, servo, images."""
    total = 0.0
    for image in range(-4, 5):
        f = hz + image / CYCLE_S
        s, omega = 2j * math.pi * f, 2 * math.pi * SERVO_HZ
        line = np.sinc(f * CYCLE_S) ** 2
        servo = omega**2 / (s * s + 2 * SERVO_ZETA * omega * s + omega**2)
        total += line * servo * cmath.exp(-s * DEAD_S)
    return total


def test_tracking_gain_and_phase_are_those_of_the_closed_form(guide, start_deg, record_property):
    """One axis for each frequency, 0.1 deg; what the encoders say against the reference."""
    hz = np.array([1.0, 10.0, 20.0, 50.0, 1.0, 10.0])
    with_speed = np.array([True] * 4 + [False] * 2)
    sensor, n = guide(), 3000
    step = 2 * np.pi * hz * CYCLE_S
    reference = 0.1 * np.sin(step * np.arange(n + 1)[:, None])
    first = len(sensor.measured)
    for k in range(n):
        speed = np.where(with_speed, (reference[k + 1] - reference[k]) / CYCLE_S, 0.0)
        sensor.cycle(start_deg + reference[k], speed)
    found = np.array(sensor.measured[first:]) - start_deg
    tail = slice(n // 3, n)
    window = np.hanning(n - n // 3)
    for axis in range(6):
        basis = window * np.exp(-1j * step[axis] * np.arange(n)[tail])
        ratio = basis @ found[tail, axis] / (basis @ reference[:n][tail, axis])
        wanted = law(hz[axis], with_speed[axis]) * drive(hz[axis])
        kind = 'position and speed' if with_speed[axis] else 'position only'
        text = (
            f'{kind}, {hz[axis]:.0f} Hz: gain {abs(ratio):.4f} (theory {abs(wanted):.4f}), '
            f'phase {math.degrees(cmath.phase(ratio)):.2f} deg '
            f'({math.degrees(cmath.phase(wanted)):.2f})'
        )
        record_property(f'tracking_{axis}', text)
        print(text)
        # One encoder count is 2e-4 deg.
        assert abs(ratio - wanted) < 5e-3 * abs(wanted) + 2e-4, text
    assert sensor.client.n_queued <= 1


@pytest.fixture(scope='module')
def exported(plan, model):
    return rapid_module(plan, model)


def played(plan, model):
    """Return reference angles and speeds of a plan at the cycles [deg], [deg/s]."""
    times = np.arange(0.0, plan.duration_s, CYCLE_S)
    angles = np.degrees(model.to_controller(plan.trajectory.at(times).position))
    return angles, np.vstack([np.diff(angles, axis=0) / CYCLE_S, np.zeros((1, 6))])


def flange_mm(model, angles_deg):
    serial = model.to_serial(np.radians(angles_deg))
    return 1e3 * model.kinematics.motion(serial).position[:, -1]


@pytest.mark.parametrize('timeout_s', [0.1, 1.0])
def test_a_lost_link_ends_in_the_error_handler(
    timeout_s, guide, exported, plan, model, record_property
):
    """The exported guidance module; its CommTimeout, and the controller's own of 1 s."""
    sensor = guide(exported.replace('CommTimeout:=0.1', f'CommTimeout:={timeout_s}'))
    angles, speeds = played(plan, model)
    # Lost where axis 1 is fastest: the last speed keeps acting.
    lost = 250 + int(np.argmax(np.abs(speeds[250:700, 0])))
    for k in range(lost):
        assert sensor.cycle(angles[k], speeds[k]).mciState.state == 3
    at = len(sensor.planned)
    fastest = np.abs(speeds).max()
    for _ in range(round((timeout_s + 0.5) / CYCLE_S)):
        message = sensor.cycle()
    planned = np.array(sensor.planned[at - 1 :])
    moving = np.flatnonzero(np.any(np.diff(planned, axis=0) != 0.0, axis=1))
    standstill_s = (moving[-1] + 1) * CYCLE_S
    residual = np.abs(planned - planned[0]).max()
    away_mm = np.linalg.norm(flange_mm(model, planned) - flange_mm(model, planned[:1]), axis=1)
    record_property(f'residual_deg_{timeout_s}', residual)
    record_property(f'residual_flange_mm_{timeout_s}', away_mm.max())
    record_property(f'standstill_s_{timeout_s}', standstill_s)
    print(
        f'CommTimeout {timeout_s} s: {residual:.3f} deg, flange {away_mm.max():.2f} mm, '
        f'standstill after {standstill_s:.3f} s'
    )
    # Time-out, stop ramp of 0.1 s, one cycle each for the queue and the handler.
    assert timeout_s < standstill_s < timeout_s + 0.1 + 4 * CYCLE_S
    # k pulls back to the last position: v / k is as far as the last speed can carry it.
    assert residual < min(fastest * (timeout_s + 0.1), fastest / GAIN + 0.1)
    events = sensor.controller.events
    said = [event for event in events if event.startswith('TPWrite')]
    assert len(said) == 1 and 'error 1001' in said[0]
    assert not sensor.controller.running
    # EGMReset of the handler has ended the session; nothing comes back by itself.
    heard = len(sensor.heard)
    for _ in range(100):
        sensor.cycle(angles[0])
    assert len(sensor.heard) == heard
    assert sensor.controller.session is None
    assert np.ptp(np.array(sensor.planned[-100:]), axis=0).max() == 0.0
    assert message is None


def test_a_lost_stream_leaves_a_program_of_moves_alone_and_a_stop_ends_it(
    guide, pulses_plan, model, start_deg, record_property, peers
):
    """The RAPID way does not need the link: only a stop ends the motion, within its ramp."""
    sensor = LockstepSensor(model, start_deg, peers, rapid_module(pulses_plan, model))
    moves = sensor.controller
    sensor.until(lambda: len(sensor.heard) > 300)
    sensor.until(lambda: np.abs(moves.axes.planned_speed_deg_s).max() > 2.0)
    sensor.faults.sensor.drop = sensor.faults.robot.drop = 1.0
    heard = len(sensor.heard)
    for _ in range(40):  # 0.16 s, beyond CommTimeout: no session is guided, so none is lost
        sensor.cycle()
    assert len(sensor.heard) == heard
    assert moves.running
    sensor.until(lambda: np.abs(moves.axes.planned_speed_deg_s).max() > 2.0)
    at = len(sensor.planned)
    moves.stop('operator')
    for _ in range(60):
        sensor.cycle()
    planned = np.array(sensor.planned[at - 1 :])
    moving = np.flatnonzero(np.any(np.diff(planned, axis=0) != 0.0, axis=1))
    away_mm = np.linalg.norm(flange_mm(model, planned) - flange_mm(model, planned[:1]), axis=1)
    residual = np.abs(planned - planned[0]).max()
    record_property('stopped_moves_deg', residual)
    record_property('stopped_moves_flange_mm', away_mm.max())
    print(f'moves stopped: {residual:.3f} deg, flange {away_mm.max():.2f} mm')
    assert (moving[-1] + 1) * CYCLE_S < 0.1 + 3 * CYCLE_S
    assert not moves.running
    sensor.close()


@pytest.fixture(scope='module')
def pulses_plan(model):
    from excitation_planner.planner import plan_excitation
    from excitation_planner.request import PlanRequest
    from structural_model.robot_files import load_layout

    layout = load_layout('irb6660_205_190', 'sensors')
    start = tuple(model.pose('P1').tolist())
    return plan_excitation(
        model, layout, PlanRequest(seed=1, signal='random_pulses', duration_s=6.0,
                                   start_position=start)
    )  # fmt: skip


def test_undefined_execution_state_is_reported_and_guidance_goes_on(guide, start_deg):
    sensor = guide()
    sensor.controller.rapid_undefined = True
    for _ in range(50):
        message = sensor.cycle(start_deg + 0.05)
        assert message.rapidExecState.state == 0
        assert message.mciState.state == 3
    sensor.controller.rapid_undefined = False
    assert sensor.cycle(start_deg).rapidExecState.state == 2
    assert sensor.controller.axes.planned_deg[0] > start_deg[0]


def fault_of(sensor, position_deg, speed_deg_s, most=3000):
    """Ask for a motion until supervision stops it; return what it said."""
    for _ in range(most):
        sensor.cycle(position_deg, speed_deg_s)
        if not sensor.controller.running:
            break
    for _ in range(60):
        message = sensor.cycle(position_deg, speed_deg_s)
    said = [e for e in sensor.controller.events if e.startswith('motion supervision')]
    assert len(said) == 1, sensor.controller.events
    assert message.mciState.state == 1
    assert message.rapidExecState.state == 1
    # At rest, whatever the sensor goes on asking for.
    assert np.ptp(np.array(sensor.planned[-20:]), axis=0).max() == 0.0
    return said[0]


def asked(start_deg, axis, change):
    target = start_deg.copy()
    target[axis] += change
    return target


def test_supervision_of_ranges(guide, start_deg, model):
    sensor = guide(module(speed=20))
    said = fault_of(sensor, asked(start_deg, 2, -40.0), None)
    assert 'axis 3 at its range' in said
    farthest = min(row[2] for row in sensor.planned)
    assert -20.0 - STOPPING_DEG < farthest < -20.0 + 20.0 * CYCLE_S


def test_supervision_of_the_coupled_range(guide, start_deg, model):
    """J3 - J2 is the angle of the parallelogram; axis 3 alone is far from its own end."""
    low, high = np.degrees(model.limits.position_low[2]), np.degrees(model.limits.position_high[2])
    sensor = guide(module(speed=20))
    target = start_deg + np.array([0.0, 39.0, -9.0, 0, 0, 0])
    assert target[2] - target[1] < low < high
    said = fault_of(sensor, target, None)
    assert 'coupled axis 3 at its range' in said
    # Two axes at 20 deg/s towards each other.
    assert min(row[2] - row[1] for row in sensor.planned) > low - 2.0 * STOPPING_DEG


def test_supervision_of_joint_speed(guide, start_deg, model):
    sensor = guide()
    said = fault_of(sensor, start_deg, [0, 0, 0, 0, 0, 300.0])
    assert 'axis 6 too fast' in said
    steps = np.abs(np.diff(np.array(sensor.planned), axis=0)) / CYCLE_S
    assert np.all(steps.max(axis=0) <= 1.05 * np.degrees(model.limits.velocity) + 1e-6)


def test_supervision_of_following(guide, start_deg):
    settings = CellSettings(controller=ControllerSettings(following_error_deg=0.5))
    sensor = guide(settings=settings)
    said = fault_of(sensor, start_deg, [60.0, 0, 0, 0, 0, 0])
    assert 'axis 1 does not follow' in said
    away = np.abs(np.array(sensor.planned) - np.array(sensor.measured)).max()
    assert 0.4 < away < 2.0


@pytest.mark.parametrize('mode', ['manual', 'not confirmed', 'automatic'])
def test_the_flange_keeps_250_mm_s_unless_automatic_is_confirmed(guide, start_deg, model, mode):
    sensor = guide()
    if mode != 'automatic':
        sensor.controller.set_automatic(False)
        if mode == 'not confirmed':
            sensor.controller.set_automatic(True)
        # The change of mode has stopped the program; an operator starts it again.
        sensor.until(lambda: not sensor.controller.axes.moving, start_deg)
        assert not sensor.controller.running
        assert sensor.task.start()
        sensor.until(sensor.guided, start_deg)
    first = len(sensor.planned)
    if mode == 'automatic':
        for _ in range(100):
            sensor.cycle(start_deg, [20.0, 0, 0, 0, 0, 0])
        assert sensor.controller.running
    else:
        assert 'flange faster than 250 mm/s' in fault_of(sensor, start_deg, [20.0, 0, 0, 0, 0, 0])
    path = flange_mm(model, np.array(sensor.planned[first:]))
    fastest = np.linalg.norm(np.diff(path, axis=0), axis=1).max() / CYCLE_S
    assert (fastest > 400.0) if mode == 'automatic' else (fastest <= 250.0 * 1.05 + 1.0)
