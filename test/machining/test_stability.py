"""Limits against published examples, closed forms and a simulation in time."""

import math

import numpy as np
import pytest

from machining.cut import Coefficients, Cut, Cutter, Engagement
from machining.stability import (
    DepthSearch,
    limits_of_modes,
    limits_of_periods,
    limits_of_response,
    spectral_radius,
)
from modal_core.tool_modes import ToolModes
from test.support.milling_bench import growth

SEED = 20261124
WIDE = DepthSearch(5e-5, 8e-3)


def tool(frequency_hz, damping_ratio, stiffness_n_m, shape):
    frequency = np.array(frequency_hz, float)
    mass = np.array(stiffness_n_m) / (2 * np.pi * frequency) ** 2
    made = np.array(shape, float) / np.sqrt(mass)[:, None]
    return ToolModes(frequency, np.array(damping_ratio, float), made)


# Weck's machine as in Altintas and Budak: 3 teeth, half immersion up, K_t = 600 N/mm², k_r 0.07.
WECK = tool([603, 666], [0.039, 0.035], [5.59e6, 5.715e6], [[1, 0, 0], [0, 1, 0]])
WECK_CUT = Cut(Cutter(3, 0.02), Engagement.up(0.5), Coefficients(600e6, 42e6))
# The standard example of semi-discretisation: one mode along the feed, two teeth.
ONE = tool([922], [0.011], [0.03993 * (2 * np.pi * 922) ** 2], [[1, 0, 0]])
ONE_MATERIAL = Coefficients(600e6, 200e6)


def one_cut(engagement):
    return Cut(Cutter(2, 0.01), engagement, ONE_MATERIAL)


def test_zeroth_order_of_the_textbook_machine():
    speeds = [4000, 6000, 8000, 10000, 12000, 14000, 15000]
    found = limits_of_modes(WECK, WECK_CUT, speeds)
    expected = [1.419, 1.945, 1.095, 1.339, 4.032, 2.793, 1.958]
    assert found.depth_m * 1e3 == pytest.approx(expected, rel=2e-3)
    assert found.chatter_hz == pytest.approx([659, 665, 627, 657, 675, 599, 603], abs=0.6)


def test_zeroth_order_finds_the_absolute_minimum():
    found = limits_of_modes(WECK, WECK_CUT, np.linspace(2500.0, 16000.0, 1500))
    assert found.depth_m.min() * 1e3 == pytest.approx(1.087, rel=2e-3)
    one = limits_of_modes(ONE, one_cut(Engagement.slot()), np.linspace(4000.0, 25000.0, 1500))
    # 2 k ζ (1 + ζ) / mean directional factor: 0.29805 mm.
    assert one.depth_m.min() * 1e3 == pytest.approx(0.29805, rel=2e-3)


def test_zeroth_order_of_a_measured_response_is_that_of_its_modes():
    lines = np.arange(100.0, 1500.0, 1.0)
    speeds = np.linspace(4000.0, 15000.0, 40)
    of_lines = limits_of_response(lines, WECK.receptance(lines), WECK_CUT, speeds)
    assert of_lines.depth_m == pytest.approx(
        limits_of_modes(WECK, WECK_CUT, speeds).depth_m, rel=3e-3
    )


def test_spectral_radius_of_the_standard_example():
    """Of the literature on full discretisation, 5000 rpm, slot."""
    cut = one_cut(Engagement.slot())
    for depth_mm, expected in ((0.2, 0.8192), (0.5, 1.0726), (1.0, 1.4040)):
        found = spectral_radius(ONE, cut, 5000.0, depth_mm * 1e-3)
        assert found == pytest.approx(expected, rel=2e-3)


@pytest.mark.parametrize(
    ('engagement', 'expected'),
    [
        (Engagement.slot(), (0.677, 0.3226, 2.148, 0.387, 0.690, 1.418)),
        (Engagement.up(0.5), (0.406, 0.2137, 1.061, 0.259, 0.397, 1.185)),
        (Engagement.down(0.5), (0.798, 2.105, 0.613, 2.597, 1.620, 0.720)),
        (Engagement.up(0.05), (3.496, 1.657, 6.243, 1.887, 4.424, 3.774)),
        (Engagement.down(0.05), (2.161, 4.088, 1.679, math.inf, 1.295, 2.296)),
    ],
)
def test_semi_discretisation_of_the_standard_example(engagement, expected):
    """Limits of first order with 220 steps a period; flip lobes are among them."""
    speeds = [8000, 10000, 12000, 15000, 18000, 20000]
    found = limits_of_periods(ONE, one_cut(engagement), speeds, WIDE).depth_m * 1e3
    assert found == pytest.approx(expected, rel=0.01)


def test_the_zeroth_order_misses_chatter_that_doubles_the_period():
    cut = one_cut(Engagement.up(0.05))
    (mean,) = limits_of_modes(ONE, cut, [20000.0]).depth_m
    (whole,) = limits_of_periods(ONE, cut, [20000.0], WIDE).depth_m
    assert mean > 2.0 * whole


def robot(rng):
    """A soft arm that couples its directions, with two modes of the spindle."""
    turned = np.linalg.qr(rng.standard_normal((3, 3)))[0]
    return tool(
        [11.0, 13.0, 28.0, 640.0, 700.0],
        [0.03, 0.03, 0.04, 0.03, 0.035],
        [4e5, 5e5, 3e6, 9e6, 1.1e7],
        [*turned, [1, 0.1, 0], [-0.1, 1, 0]],
    )


@pytest.mark.parametrize('speed_rpm', [6000.0, 13000.0])
def test_modes_that_act_on_one_another_against_a_simulation_in_time(speed_rpm):
    print('seed', SEED)
    modes, teeth = robot(np.random.default_rng(SEED)), 2
    engaged = (math.pi / 2, math.pi)
    cut = Cut(Cutter(teeth, 0.02), Engagement(*engaged), Coefficients(800e6, 250e6))
    (limit,) = limits_of_periods(modes, cut, [speed_rpm], WIDE).depth_m
    for share, grows in ((0.9, False), (1.25, True)):
        found = growth(modes, teeth, engaged, (800e6, 250e6), speed_rpm, share * limit, 60)
        said = spectral_radius(modes, cut, speed_rpm, share * limit)
        assert (said > 1.0) == grows == (found > 1.0)
    # Below the limit slow modes fall too slowly to be told; above it one mode rules soon.
    assert found == pytest.approx(said, rel=0.01)


def test_a_finer_period_changes_little():
    rng = np.random.default_rng(SEED)
    speeds = rng.uniform(4000.0, 20000.0, 6)
    for modes, cut in ((WECK, WECK_CUT), (ONE, one_cut(Engagement.down(0.2)))):
        coarse = limits_of_periods(modes, cut, speeds, WIDE).depth_m
        fine = limits_of_periods(modes, cut, speeds, WIDE, finer=3.0).depth_m
        assert coarse == pytest.approx(fine, rel=0.006)


def test_turning_tool_and_machine_together_changes_nothing():
    """A lead angle lets the axial direction in: a 3 x 3 response is taken as it is."""
    rng = np.random.default_rng(SEED)
    modes = robot(rng)
    steep = Cut(Cutter(4, 0.05, lead_rad=math.radians(45)), Engagement.up(0.6), ONE_MATERIAL)
    flat = Cut(Cutter(4, 0.05), Engagement.up(0.6), ONE_MATERIAL)
    (with_axial,) = limits_of_modes(modes, steep, [5000.0]).depth_m
    stiff = ToolModes(modes.frequency_hz, modes.damping_ratio, modes.shape * [1, 1, 0])
    (without,) = limits_of_modes(stiff, steep, [5000.0]).depth_m
    assert abs(with_axial / without - 1.0) > 0.01
    (end_mill,) = limits_of_modes(modes, flat, [5000.0]).depth_m
    (end_mill_stiff,) = limits_of_modes(stiff, flat, [5000.0]).depth_m
    assert end_mill == pytest.approx(end_mill_stiff, rel=1e-9)
