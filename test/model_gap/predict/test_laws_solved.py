"""Laws of joints solved step by step, against their equations integrated finely."""

import numpy as np
import pytest

from model_gap.laws.backlash import BacklashLaw
from model_gap.laws.law import JointContext
from model_gap.laws.solve import bouc_wen, play, slipping, stopped

RATE_HZ = 1200.0
FINER = 200


def twist():
    time = np.arange(0.0, 2.0, 1.0 / RATE_HZ)
    return 1e-4 * (np.sin(2 * np.pi * 3.0 * time) + 0.6 * np.sin(2 * np.pi * 7.3 * time + 1.0))


@pytest.mark.parametrize('knee', [1.0, 2.0, 6.0, 30.0])
def test_a_spring_slips_along_its_knee(knee):
    """Wen's equation, in two hundred explicit steps each."""
    limit, path = 5e-5, twist()
    place, expected = 0.0, [0.0]
    for change in np.diff(path) / FINER:
        for _ in range(FINER):
            onwards = 0.5 * (1.0 + np.sign(change * place))
            place += change * (1.0 - abs(place / limit) ** knee * onwards)
            place = min(max(place, -limit), limit)
        expected.append(place)
    memory = np.array([0.0, path[0], 0.0, 0.0])
    constants = np.array([1.0, limit, 0.0, knee])
    found = [slipping(constants, memory, each, 0.0, 0.0)[0] for each in path]
    np.testing.assert_allclose(found, expected, atol=2e-4 * limit)


@pytest.mark.parametrize('knee', [1.0, 2.0, 8.0])
def test_what_slips_gives_way_as_it_is_pushed(knee):
    stiffness, limit, give = 2e6, 5e-5, 2e-7
    for push in (1e-6, 3e-5, 2e-4, -7e-5):
        torque, _ = slipping(np.array([stiffness, limit, give, knee]), np.zeros(4), push, 0.0, 0.0)
        left = (push - give * torque) / limit
        assert torque / (stiffness * limit) == pytest.approx(bouc_wen(0.0, left, knee), abs=1e-8)


def test_a_stop_is_damped_while_it_is_pressed_and_never_pulls():
    gap, stiffness, give, rate_give, loss = 8e-5, 6e6, 1e-7, 2e-5, 40.0
    constants = np.array([gap, stiffness, give, 0.0, loss, rate_give])
    for side in (1.0, -1.0):
        for rate in (0.01, 0.0, -0.01, -0.2):
            torque, _ = stopped(constants, np.zeros(4), side * 1.5e-4, side * rate, 0.0)
            deep = 1.5e-4 - gap - give * side * torque
            grows = 1.0 + loss * (rate - rate_give * side * torque)
            assert side * torque >= 0.0
            if rate > -0.02:
                assert side * torque == pytest.approx(stiffness * deep * grows, rel=1e-9)
    assert stopped(constants, np.zeros(4), 7e-5, 0.01, 0.0)[0] == 0.0
    assert stopped(constants, np.zeros(4), 1.5e-4, -0.2, 0.0)[0] == 0.0


def test_between_the_flanks_of_play_neither_spring_nor_damper_acts():
    """On them both do; teeth that slide along one feel no more than the damper."""
    seed, half, rest, stiffness, damping = 5, 5e-5, 3e-5, 2e6, 800.0
    context = JointContext(stiffness, rest, 1e-7, 2e-4, 1.0 / RATE_HZ, damping=damping)
    constants = np.array(BacklashLaw.constants((half, 1.0), context))
    rng, seen = np.random.default_rng(seed), {'between': 0, 'on': 0, 'at': 0}
    for _ in range(300):
        twist, rate = rng.uniform(-3e-4, 3e-4), rng.uniform(-0.02, 0.02)
        torque, _ = play(constants, np.zeros(4), twist, rate, 0.0)
        left, speed = twist - context.give * torque, rate - context.rate_give * torque
        place, damped = rest + half + left, damping * speed
        whole = stiffness * (rest + left) + damped + torque
        beyond = max(place - half, 0.0) + min(place + half, 0.0)
        if abs(abs(place) - half) < 1e-9 * half:
            seen['at'] += 1
            low, high = sorted((0.0, damped))
            assert low - 1e-6 < whole < high + 1e-6, f'seed {seed}: {twist}, {rate}'
        elif abs(place) < half:
            seen['between'] += 1
            assert whole == pytest.approx(0.0, abs=1e-7), f'seed {seed}: {twist}, {rate}'
        else:
            seen['on'] += 1
            expected = stiffness * beyond + damped
            assert whole == pytest.approx(expected, abs=1e-7), f'seed {seed}: {twist}, {rate}'
    assert min(seen['between'], seen['on']) > 20, f'seed {seed}: {seen}'
