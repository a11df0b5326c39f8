"""What was released is what a program does: from the start pose only, no harder, and once."""

import numpy as np
import pytest

from excitation_planner.plan import check_plan
from excitation_planner.planner import plan_excitation
from excitation_planner.rapid.rapid import rapid_module, start_tolerance_deg
from excitation_planner.request import PlanRequest
from modal_core.errors import PlanError, SettingsError
from test.support.rapid_bench import Bench, CYCLE_S, FRAME

SEED = 13
# What rounding in a module may do to the peaks; measured: none above, range 0.003 %.
MOST_HARDER = 1.005


def some_plan(model, generator, duration_s=3.0, **more):
    """Return a random plan of moves from a random pose, and that pose in controller degrees."""
    pose = ('P1', 'P2', 'P3')[generator.integers(3)]
    if generator.random() < 0.8:
        more |= {'half_range': 10 ** generator.uniform(-3.0, -1.3), 'enforce_tolerance': False}
    request = PlanRequest(
        seed=int(generator.integers(2**31)), signal='random_pulses', duration_s=duration_s,
        start_position=tuple(model.pose(pose).tolist()), require_full_rank=False,
        point_speed_m_s=generator.choice([0.1, 0.25, 0.5]), ramp_high_s=0.3, interval_high_s=0.1,
        sample_period_s=generator.choice([0.004, 0.008]), band_high_hz=45.0, **more,
    )  # fmt: skip
    plan = plan_excitation(model, None, request)
    return plan, np.degrees(model.to_controller(plan.start_position))


def peaks(model, planned_deg):
    """Return peak speed and acceleration of the serial joints, and the fastest point [m/s]."""
    serial = model.to_serial(np.radians(planned_deg))
    speed = np.diff(serial, axis=0) / CYCLE_S
    acceleration = np.diff(speed, axis=0) / CYCLE_S
    points = model.geometry.fastest_point(serial[1:], speed).speed_m_s
    return np.abs(speed).max(axis=0), np.abs(acceleration).max(axis=0), points.max()


@pytest.mark.parametrize('n_plans', [5, pytest.param(30, marks=pytest.mark.slow)])
def test_programs_play_their_plans_no_harder_than_released(model, n_plans, record_property):
    generator = np.random.default_rng(SEED)
    harder = []
    for _ in range(n_plans):
        plan, start = some_plan(model, generator)
        bench = Bench(model, start)
        bench.task.load(rapid_module(plan, model))
        assert bench.task.start()
        bench.to_the_end()
        planned = np.array(bench.planned)
        np.testing.assert_allclose(planned[-1], start, atol=1e-5)
        speed, acceleration, point = peaks(model, planned)
        harder.append([
            (speed / plan.peak_velocity).max(),
            (acceleration / plan.peak_acceleration).max(),
            (np.ptp(model.to_serial(np.radians(planned)), axis=0) / plan.position_range).max(),
            point / plan.peak_point_speed,
        ])  # fmt: skip
    worst = np.max(harder, axis=0)
    record_property('over_released', ' '.join(f'{value:.4f}' for value in worst))
    print('speed, acceleration, range, point over released:', worst)
    assert np.all(worst <= MOST_HARDER), worst
    assert np.min(harder) > 0.85


def test_an_approach_is_a_plan_of_its_own_slow_for_every_point_of_the_arm(model):
    generator = np.random.default_rng(SEED)
    target = model.pose('P1')
    # A wrist that turns alone, base and wrist, then random poses.
    here = [np.radians([0, 45, -10, 90, -90, 170]), np.radians([80, 45, -10, 90, -90, -100])]
    while len(here) < 6:
        pose = np.degrees(model.to_controller(target)) + generator.uniform(-40.0, 40.0, 6)
        if model.limits.position_violation(model.to_serial(np.radians(pose))) is None:
            here.append(np.radians(pose))
    for pose in here:
        request = PlanRequest(
            signal='approach', approach_from=tuple(model.to_serial(pose).tolist()),
            start_position=tuple(target.tolist()), sample_period_s=0.008, band_high_hz=45.0,
        )  # fmt: skip
        plan = plan_excitation(model, None, request)
        check_plan(plan)
        bench = Bench(model, np.degrees(pose))
        bench.task.load(rapid_module(plan, model))
        bench.task.start()
        bench.to_the_end(200.0)
        planned = np.array(bench.planned)
        speed, acceleration, point = peaks(model, planned)
        np.testing.assert_allclose(planned[-1], np.degrees(model.to_controller(target)), atol=1e-4)
        assert np.all(speed <= plan.peak_velocity * MOST_HARDER + 1e-9)
        assert np.all(acceleration <= plan.peak_acceleration * MOST_HARDER + 1e-6)
        assert point <= plan.peak_point_speed * MOST_HARDER
        assert plan.peak_point_speed <= 0.1 * MOST_HARDER
        assert np.degrees(speed).max() < 0.41 * 190.0


def test_an_approach_through_the_arm_itself_or_out_of_the_box_is_refused(model):
    target = tuple(model.pose('P1').tolist())
    here = tuple(model.to_serial(np.radians([80, 45, -10, 90, -90, 0])).tolist())
    with pytest.raises(PlanError, match='box'):
        plan_excitation(model, None, PlanRequest(
            signal='approach', approach_from=here, start_position=target,
            box_m=(-0.5, -0.8, 0.0, 3.0, 0.8, 3.0),
        ))  # fmt: skip
    with pytest.raises(PlanError, match='there already'):
        plan_excitation(model, None, PlanRequest(
            signal='approach', approach_from=target, start_position=target,
        ))  # fmt: skip
    for wrong in ({'signal': 'approach'}, {'approach_from': here}):
        with pytest.raises(SettingsError, match='approach'):
            PlanRequest(**wrong)


@pytest.mark.parametrize('signal', ['random_pulses', 'band_limited_noise'])
def test_a_program_started_elsewhere_moves_nothing(model, signal):
    generator = np.random.default_rng(SEED)
    request = PlanRequest(
        signal=signal, duration_s=4.0, start_position=tuple(model.pose('P1').tolist())
    )
    plan = plan_excitation(model, None, request)
    start = np.degrees(model.to_controller(plan.start_position))
    module, near = rapid_module(plan, model), start_tolerance_deg(plan)
    assert near <= 0.05
    for way in (80.0, 5.0, 1.2 * near, -1.2 * near, -30.0):
        axis = int(generator.integers(6))
        bench = Bench(model, start + way * np.eye(6)[axis])
        bench.task.load(module)
        bench.task.start()
        bench.to_the_end()
        assert np.ptp(bench.planned, axis=0).max() == 0.0, (axis, way)
        assert any('nothing moves' in event for event in bench.controller.events)
        assert not bench.task.start(), 'a second press of the button'
    bench = Bench(model, start + 0.5 * near * np.eye(6)[0])
    bench.task.load(module)
    bench.task.start()
    bench.cycles(1500)
    assert not any('nothing moves' in event for event in bench.controller.events)


def test_a_program_stopped_and_jogged_away_goes_no_further(model):
    plan, start = some_plan(
        model, np.random.default_rng(SEED), half_range=0.05, enforce_tolerance=False
    )
    bench = Bench(model, start)
    bench.task.load(rapid_module(plan, model))
    bench.task.start()
    while not bench.controller.axes.moving:
        bench.cycles(1)
    while bench.controller.axes.moving:
        bench.cycles(1)
    bench.cycles(20)
    bench.task.stop()
    bench.controller.axes.planned_deg = bench.controller.axes.planned_deg + 3.0
    bench.cycles(100)
    begun = len(bench.planned)
    bench.task.start()
    bench.to_the_end()
    assert np.ptp(bench.planned[begun:], axis=0).max() == 0.0
    assert any('nothing moves' in event for event in bench.controller.events)


@pytest.mark.parametrize('cycle', ['once', 'forever'])
def test_an_exported_program_ends_in_any_run_mode(model, cycle):
    plan, start = some_plan(model, np.random.default_rng(SEED))
    bench = Bench(model, start)
    bench.task.cycle = cycle
    bench.task.load(rapid_module(plan, model))
    bench.task.start()
    bench.to_the_end(20.0)
    assert bench.task.pointer is None
    assert not bench.task.start(), 'only a pointer moved to main starts it again'
    assert bench.task.reset() and bench.task.start()


def test_run_mode_continuous_begins_main_anew_until_exit(bench_of):
    text = FRAME.format('TPWrite "main"; WaitTime 0.1;')
    once, forever, exits = (
        bench_of(text, 'once'),
        bench_of(text, 'forever'),
        bench_of(text.replace('WaitTime 0.1;', 'EXIT;'), 'forever'),
    )
    for bench, mains in ((once, 1), (exits, 1)):
        assert not bench.task.running
        assert bench.controller.events.count('TPWrite: main') == mains
    assert forever.task.running
    assert forever.controller.events.count('TPWrite: main') > 5


@pytest.fixture
def bench_of(model, start_deg):
    def made(text, cycle):
        bench = Bench(model, start_deg)
        bench.task.cycle = cycle
        bench.task.load(text)
        bench.task.start()
        return bench.cycles(250)

    return made
