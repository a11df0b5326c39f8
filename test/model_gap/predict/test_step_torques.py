"""Torque laws: their implicit equations, and stepped in time against integrated oscillators."""

import numpy as np
import pytest
from scipy.integrate import cumulative_simpson, solve_ivp
from scipy.optimize import brentq

from model_gap.cell.cell_model import JointForce
from model_gap.effects.stiffness_drift import DriftLaw
from model_gap.laws import (
    CubicLaw,
    FrictionCurveLaw,
    FrictionLaw,
    JointContext,
    SpeedStiffnessLaw,
)
from model_gap.laws.law import MEMORY
from model_gap.predict.joint_path import JointPath
from model_gap.predict.step_torque import step_torque


def torques_at(law, values, context, twists, rates=None):
    """Return the law's torque at the end of a step at many twists, each from rest."""
    constants = np.array(law.constants(values, context))
    rates = np.zeros_like(twists) if rates is None else rates
    pairs = zip(twists, rates, strict=True)
    return np.array([law.torque(constants, np.zeros(MEMORY), *pair, 0.0)[0] for pair in pairs])


MASS, LOSS, SPRING = 40.0, 900.0, 2e6  # kg m², N m s/rad, N m/rad: 36 Hz, 5 %
STEPS_PER_S = 4800.0
TIME = np.arange(4801) / STEPS_PER_S


def oscillator(twist, rate, keep, speed=None, static=0.0):
    """Return the path of the linear oscillator, every so many of its instants."""
    pole = np.roots([MASS, LOSS, SPRING])[0]
    return JointPath(
        poles=np.array([pole]),
        residues=np.array([2.0 / (2j * MASS * pole.imag)]),
        instant=0.0,
        twist=twist[::keep],
        rate=rate[::keep],
        speed=(np.zeros_like(TIME) if speed is None else speed)[::keep],
        vector=np.ones(1),
        stiffness=SPRING,
        static_twist=static,
        steps_per_s=STEPS_PER_S / keep,
    )


def excitation(rng, size):
    """Return a force of a dozen lines that grows from nothing."""
    lines, phase = rng.uniform(5.0, 30.0, 12), rng.uniform(0.0, 2 * np.pi, 12)

    def push(t):
        return size * min(t / 0.3, 1.0) ** 3 * np.cos(2 * np.pi * lines * t + phase).sum()

    return push


def error_of(path, force, exact, high_hz=None):
    """Return the relative error of the means over steps, up to a frequency."""
    found = step_torque(path, force)
    keep = round(STEPS_PER_S / path.steps_per_s)
    whole = cumulative_simpson(exact, dx=1.0 / keep, initial=0.0)
    pair = np.array([found[:-1], np.diff(whole[::keep])])
    if high_hz:
        pair = np.fft.rfft(pair)[:, : round(high_hz * TIME[-1])]
    return np.linalg.norm(pair[0] - pair[1]) / np.linalg.norm(pair[1])


@pytest.mark.parametrize(
    ('alpha', 'share', 'static'),
    [(1e6, 1.0, 6e-4), (1e6, 0.0, 6e-4), (4e6, 1.0, -1e-3), (2e6, 0.5, 8e-4), (-2e5, 1.0, 4e-4)],
)
def test_preloaded_oscillator_moves_as_integrated(alpha, share, static):
    """M y'' + C y' + k y (1 + α y²) = preload + f(t), from rest, by an integrator of its own.

    The error is that of a parabola through three steps: it falls with their third power.
    """
    push = excitation(np.random.default_rng(8), 90.0)

    def restoring(y):
        return SPRING * y * (1.0 + alpha * y * y)

    load = share * SPRING * static
    rest = brentq(lambda y: restoring(y) - load, -1.2e-3, 1.2e-3, xtol=1e-16)

    def rates(t, state):  # the whole twist, and the linear spring's about its rest
        y, y_rate, e, e_rate = state
        f = push(t)
        spring = restoring(y) - load
        return [
            y_rate,
            (f - LOSS * y_rate - spring) / MASS,
            e_rate,
            (f - LOSS * e_rate - SPRING * e) / MASS,
        ]

    solved = solve_ivp(
        rates,
        (0.0, TIME[-1]),
        [rest, 0.0, 0.0, 0.0],
        'DOP853',
        TIME,
        rtol=1e-9,
        atol=1e-12,
        max_step=4e-3,
    )
    whole, _, linear, linear_rate = solved.y
    exact = restoring(whole) - load - SPRING * (whole - rest)

    def error(keep):
        path = oscillator(linear, linear_rate, keep, static=static)
        return error_of(path, JointForce('joint_2', CubicLaw, (alpha, share)), exact)

    bent = np.abs(alpha) * np.abs(whole**2 - rest**2).max()
    assert bent > 0.05, f'moves far enough to bend the spring: {bent:.3f}'
    usual, finer = error(4), error(2)  # 1200 steps a second, and 2400
    assert usual < 0.015, f'{usual:.4f}'
    assert finer < 0.2 * usual, f'{finer:.5f} of {usual:.4f}'


def test_cubic_torque_solves_its_implicit_equation(rng):
    """Torque, the twist it leaves and the twist at rest belong together."""
    for _ in range(400):
        alpha = rng.choice([-1.0, 1.0, 1.0]) * 10.0 ** rng.uniform(3.0, 5.5)
        share, static, k = (
            rng.uniform(0.0, 1.5),
            rng.uniform(-5e-4, 5e-4),
            10.0 ** rng.uniform(5, 7),
        )
        context = JointContext(k, static, rng.uniform(0.0, 0.3) / k, 0.0, 1 / 600)
        twist = rng.uniform(-7e-4, 7e-4)
        still, torque = torques_at(CubicLaw, (alpha, share), context, [0.0, twist])
        assert abs(still) < 1e-9, 'at rest'
        left = twist - context.give * torque
        load = share * static
        rest = brentq(lambda y, a=alpha, v=load: y + a * y**3 - v, -1e-3, 1e-3, xtol=1e-17)
        expected = k * alpha * ((rest + left) ** 3 - rest**3)
        assert torque == pytest.approx(expected, rel=1e-6, abs=1e-7 * k * abs(alpha) * 1e-10)


def test_cubic_torque_without_preload_is_the_dynamic_one(rng):
    """The share 0 forgets gravity; so does a joint that carries none."""
    twists = rng.uniform(-5e-4, 5e-4, 60)
    for share, static in ((0.0, 6e-4), (1.0, 0.0)):
        found = torques_at(
            CubicLaw, (2e6, share), JointContext(1e6, static, 0.0, 0.0, 1 / 600), twists
        )
        np.testing.assert_allclose(found, 1e6 * 2e6 * twists**3, rtol=1e-9, atol=1e-12)


def test_softening_spring_never_turns_round():
    """Past its strongest the spring is held: nothing jumps, not even under too much preload."""
    twist = np.linspace(-5e-3, 5e-3, 4001)
    for static in (0.0, 5e-3):
        context = JointContext(1e6, static, 1e-7, 0.0, 1 / 600)
        torque = torques_at(CubicLaw, (-1e6, 1.0), context, twist)
        assert np.all(np.isfinite(torque))
        slope = np.diff(torque) / np.diff(twist)
        assert slope.max() <= 1e-3
        assert slope.min() > -1e6 * 1.8 / (1.0 - 0.18) - 1.0


@pytest.mark.parametrize('alpha', [1e8, 1e9])
def test_very_hard_spring_does_not_run_away(alpha, rng):
    """Steps that no longer resolve it: the torque stays of the size of what drives it."""
    steps = 3000
    pole = np.roots([MASS, LOSS, SPRING])[0]
    time = np.arange(steps) / 600.0
    lines = rng.uniform(5.0, 30.0, 12)
    twist = 3e-5 * np.cos(2 * np.pi * np.multiply.outer(time, lines) + lines).sum(axis=1)
    path = JointPath(
        poles=np.array([pole]),
        residues=np.array([2.0 / (2j * MASS * pole.imag)]),
        instant=0.0,
        twist=twist,
        rate=np.gradient(twist),
        speed=np.zeros(steps),
        vector=np.ones(1),
        stiffness=SPRING,
        static_twist=1e-3,
    )
    torque = step_torque(path, JointForce('joint_2', CubicLaw, (alpha, 1.0)))
    assert np.abs(torque[-600:]).max() < 20.0 * SPRING * np.abs(twist).max()
    assert torque[-600:].std() > 0.1 * SPRING * twist.std()


def test_friction_that_gives_way_first_moves_as_integrated():
    """M y'' + C y' + k y + F = f(t) with p F'/k = y' - v₀ artanh(F/τ), by an integrator.

    Up to 60 Hz the error of the torque falls with the step.
    """
    level, width, compliance = 60.0, 5e-4, 0.08
    push = excitation(np.random.default_rng(9), 60.0)

    def rates(t, state):
        y, y_rate, sliding, e, e_rate = state
        grip = np.tanh(sliding / width)  # the sliding speed as the state: its torque stays inside
        slope = level / width * (1.0 - grip * grip)
        pushing = push(t)
        return [
            y_rate,
            (pushing - LOSS * y_rate - SPRING * y - level * grip) / MASS,
            (y_rate - sliding) * SPRING / compliance / max(slope, 1e-6),
            e_rate,
            (pushing - LOSS * e_rate - SPRING * e) / MASS,
        ]

    solved = solve_ivp(
        rates, (0.0, TIME[-1]), np.zeros(5), 'LSODA', TIME, rtol=1e-8, atol=1e-12, max_step=1e-3
    )
    assert solved.success, solved.message
    sliding, linear, linear_rate = solved.y[2:]
    exact = level * np.tanh(sliding / width)
    assert np.abs(exact).max() > 0.95 * level, 'it slides'
    assert np.mean(np.abs(exact) < 0.8 * level) > 0.2, 'and sticks'
    force = JointForce('joint_2', FrictionLaw, (level, width, compliance))

    def error(keep):
        return error_of(oscillator(linear, linear_rate, keep), force, exact, 60.0)

    usual, finer = error(4), error(1)
    assert usual < 0.035, f'{usual:.4f}'
    assert finer < 0.3 * usual, f'{finer:.5f} of {usual:.4f}'


@pytest.mark.parametrize('share', [0.0, 1.0])
def test_spring_that_stiffens_with_speed_moves_as_integrated(share):
    """M y'' + C y' + k (1 + β|v|) (r + y) = k r + f(t), v the motor's speed."""
    beta, static = 5.0, 4e-4
    push = excitation(np.random.default_rng(10), 90.0)

    def speed(t):
        return 0.08 * np.sin(2 * np.pi * 3.0 * t) + 0.03 * np.sin(2 * np.pi * 8.0 * t)

    def rates(t, state):
        y, y_rate, e, e_rate = state
        added = SPRING * beta * abs(speed(t)) * (share * static + y)
        return [
            y_rate,
            (push(t) - LOSS * y_rate - SPRING * y - added) / MASS,
            e_rate,
            (push(t) - LOSS * e_rate - SPRING * e) / MASS,
        ]

    solved = solve_ivp(
        rates, (0.0, TIME[-1]), np.zeros(4), 'DOP853', TIME, rtol=1e-9, atol=1e-12, max_step=1e-3
    )
    whole, _, linear, linear_rate = solved.y
    exact = SPRING * beta * np.abs(speed(TIME)) * (share * static + whole)
    force = JointForce('joint_2', SpeedStiffnessLaw, (beta, share))

    def error(keep):
        path = oscillator(linear, linear_rate, keep, speed(TIME), static)
        return error_of(path, force, exact, 60.0)

    usual, finer = error(4), error(2)  # the speed's kinks limit the order
    assert usual < 0.01, f'{usual:.4f}'
    assert finer < 0.35 * usual, f'{finer:.5f} of {usual:.4f}'


def test_mean_friction_over_a_step_is_the_integral_of_the_law(rng):
    """The speed runs straight from -v to v' in one step: the torque's mean is known."""
    constants = np.array(
        FrictionLaw.constants((30.0, 2e-3, 0.0), JointContext(1.0, 0.0, 0.0, 0.0, 1 / 600))
    )
    for _ in range(50):
        memory = np.zeros(MEMORY)
        start, end = -rng.uniform(1e-3, 1e-1), rng.uniform(1e-3, 1e-1)
        first, _ = FrictionLaw.torque(constants, memory, 0.0, start, 0.0)
        last, surplus = FrictionLaw.torque(constants, memory, 0.0, end, 0.0)
        fine = start + (end - start) * (np.arange(20000) + 0.5) / 20000
        expected = np.mean(30.0 * np.tanh(fine / 2e-3))
        assert 0.5 * (first + last) + surplus == pytest.approx(expected, abs=1e-3)


def test_friction_solves_its_implicit_equation(rng):
    """Torque and the speed it leaves belong together, from stuck to sliding."""
    for _ in range(400):
        level, width = rng.uniform(10.0, 300.0), 10.0 ** rng.uniform(-4.0, -2.0)
        give = 10.0 ** rng.uniform(-7.0, -4.0)
        rate = rng.standard_normal() * 10.0 ** rng.uniform(-4.0, 0.0)
        context = JointContext(1.0, 0.0, 0.0, give, 1 / 600)
        (torque,) = torques_at(FrictionLaw, (level, width, 0.0), context, [0.0], [rate])
        left = rate - give * torque
        # An error of the torque changes the speed it leaves: judged where both meet.
        grip = np.tanh(left / width)
        slope = 1.0 + give * level / width * (1.0 - grip * grip)
        assert abs((torque - level * grip) / slope / level) < 1e-6


def test_a_friction_curve_solves_its_implicit_equation(rng):
    """w + g F(w) = v, F = (τ + μ|k (r + e)|) (1 + s exp(-(w/v_s)²)) tanh(w/v₀), whatever it is."""
    stiffness, at_rest = 2e6, 3e-5
    for _ in range(200):
        level, width = rng.uniform(1.0, 200.0), 10.0 ** rng.uniform(-4.0, -2.0)
        rise, knee, per_load = (
            rng.uniform(0.0, 3.0),
            10.0 ** rng.uniform(-3, -1),
            rng.uniform(0, 0.1),
        )
        rate_give, twist, rate = (
            10.0 ** rng.uniform(-6, -4),
            rng.normal(0, 1e-4),
            rng.normal(0, 0.02),
        )
        context = JointContext(stiffness, at_rest, 0.0, rate_give, 1e-3)
        values = (level, width, rise, knee, per_load, 0.0)
        constants = np.array(FrictionCurveLaw.constants(values, context))
        torque, _ = FrictionCurveLaw.torque(constants, np.zeros(MEMORY), twist, rate, 0.0)
        speed = rate - rate_give * torque
        size = level + per_load * abs(stiffness * (at_rest + twist))
        wanted = size * (1.0 + rise * np.exp(-((speed / knee) ** 2))) * np.tanh(speed / width)
        assert torque == pytest.approx(wanted, rel=1e-5, abs=1e-6 * size)


@pytest.mark.parametrize('gives', [0.0, 0.03])
def test_a_friction_curve_without_rise_and_load_is_coulombs(rng, gives):
    context = JointContext(2e6, 0.0, 0.0, 1e-5, 1e-3)
    plain = np.array(FrictionLaw.constants((50.0, 1e-3, gives), context), dtype=float)
    curve = np.array(FrictionCurveLaw.constants((50.0, 1e-3, 0.0, 1.0, 0.0, gives), context))
    one, two = np.zeros(MEMORY), np.zeros(MEMORY)
    for rate in rng.normal(0.0, 5e-3, 50):
        expected = FrictionLaw.torque(plain, one, 0.0, rate, 0.0)
        assert FrictionCurveLaw.torque(curve, two, 0.0, rate, 0.0) == pytest.approx(
            expected, rel=1e-5, abs=1e-5
        )


def test_a_drifting_spring_has_gained_what_time_says():
    context = JointContext(1e6, 0.0, 0.0, 0.0, 0.5, start_s=100.0)
    constants, memory = np.array(DriftLaw.constants((-1e-3,), context)), np.zeros(MEMORY)
    found = [DriftLaw.torque(constants, memory, 1e-4, 0.0, 0.0)[0] for _ in range(3)]
    assert found == pytest.approx([-10.0, -10.05, -10.1])
