"""Plans for the modes that a map expects: they are excited where they are."""

from dataclasses import replace

import numpy as np
import pytest

from excitation_planner.forecast.expected_modes import ExpectedModes, pairs, with_expected
from excitation_planner.forecast.participation import forecast, mode_participation
from excitation_planner.motion.raised_shape import LARGEST_GAIN, raised_shape, Stretch
from excitation_planner.planner import plan_excitation
from excitation_planner.request import PlanRequest
from structural_model import load_layout, load_robot

ROBOT = 'irb6660_205_190'
REQUEST = PlanRequest(
    duration_s=10.0, signal='band_limited_noise', require_full_rank=False, seed=3,
    acceleration_rms=0.2,
)  # fmt: skip
FACTOR, WEAK = 1.08, 0.002


@pytest.fixture(scope='module')
def robot():
    return load_robot(ROBOT), load_layout(ROBOT)


@pytest.fixture(scope='module')
def expected(robot):
    """Return the modes of an arm that is 17 % stiffer than its model."""
    model, layout = robot
    q = model.pose('P1')
    found = mode_participation(model, q, layout.channels, 55.0)
    hz = FACTOR * found.frequency_hz
    return ExpectedModes(
        q, hz, 0.005 * hz, 1.5 * found.damping_ratio, found.response, found.channel_names
    )


def test_the_plan_foresees_the_modes_of_the_map(robot, expected):
    model, layout = robot
    request = replace(REQUEST, start_position=tuple(model.pose('P1')))
    plan = plan_excitation(model, layout, request, expected)
    count = len(expected.frequency_hz)
    assert plan.mode_frequency_hz[:count] == pytest.approx(expected.frequency_hz, rel=1e-5)
    assert [mode.damping_ratio for mode in plan.prediction.modes[:count]] == pytest.approx(
        expected.damping_ratio
    )


def test_the_mode_that_would_drown_gets_more_and_is_known_better(robot, expected):
    model, layout = robot
    weak = replace(REQUEST, acceleration_rms=WEAK)
    request = replace(weak, start_position=tuple(model.pose('P1')))
    flat = plan_excitation(model, layout, request)
    own = plan_excitation(model, layout, request, expected)
    modes = with_expected(
        mode_participation(model, model.pose('P1'), layout.channels, 55.0), expected
    )
    reached = [
        np.array(
            [
                mode.frequency_std_hz / mode.frequency_hz
                for mode in forecast(
                    modes, plan.prediction.spectrum, request.noise_density**2, plan.duration_s
                )
            ]
        )
        for plan in (flat, own)
    ]
    inside = expected.frequency_hz < 0.9 * request.band_high_hz
    worst = int(np.argmax(np.where(inside, reached[0], 0.0)))
    print(f'worst sigma {reached[0][worst]:.4f} flat, {reached[1][worst]:.4f} for the map')
    assert reached[1][worst] < 0.8 * reached[0][worst]


def test_where_every_mode_stands_out_the_motion_stays_as_it_is(robot, expected):
    model, layout = robot
    request = replace(REQUEST, start_position=tuple(model.pose('P1')))
    plain = plan_excitation(model, layout, request)
    told = plan_excitation(model, layout, request, expected)
    assert np.array_equal(plain.position, told.position)
    assert told.mode_frequency_hz[0] == pytest.approx(expected.frequency_hz[0], rel=1e-5)


def test_without_a_map_or_with_a_shape_of_ones_own_nothing_changes(robot, expected):
    model, layout = robot
    request = replace(REQUEST, start_position=tuple(model.pose('P1')))
    plain = plan_excitation(model, layout, request)
    assert plan_excitation(model, layout, request, None).plan_hash == plain.plan_hash
    own = replace(request, shape_frequency_hz=(5.0, 60.0), shape_gain=(1.0, 0.5))
    asked = plan_excitation(model, layout, own)
    told = plan_excitation(model, layout, own, expected)
    assert np.array_equal(asked.position, told.position)


def test_modes_are_paired_by_shape_where_frequencies_have_crossed(robot):
    model, layout = robot
    own = mode_participation(model, model.pose('P1'), layout.channels, 55.0)
    hz = own.frequency_hz.copy()
    close = int(np.argmin(np.diff(np.log(hz))))
    hz[[close, close + 1]] = hz[[close + 1, close]]
    told = ExpectedModes(
        model.pose('P1'), hz, 0.01 * hz, own.damping_ratio, own.response, own.channel_names
    )
    assert pairs(own, told) == [(at, at) for at in range(len(hz))]
    other = replace(told, channel_names=tuple(f'x{name}' for name in own.channel_names))
    assert pairs(own, other) == []


def test_a_stretch_is_as_wide_as_its_mode_may_be_off():
    narrow, wide = (Stretch(20.0, 0.01, 4.0, std) for std in (0.0, 2.0))
    least = Stretch(40.0, 0.01, 1.0)
    shapes = [raised_shape((5.0, 60.0), (each, least)) for each in (narrow, wide)]
    gains = [np.interp([20.0, 23.0, 40.0], s.frequency_hz, s.gain) for s in shapes]
    assert gains[0] == pytest.approx([LARGEST_GAIN, 1.0, 1.0], abs=0.05)
    assert gains[1] == pytest.approx([LARGEST_GAIN, LARGEST_GAIN, 1.0], abs=0.05)
