"""Cutting forces against closed forms and against one another."""

import math

import numpy as np
import pytest

from machining.cut import Coefficients, Cut, Cutter, cutting_force, Engagement
from modal_core.errors import SettingsError

# N = 4, a = 2 mm, c = 0.05 mm, K_tc 700, K_rc 210 N/mm², K_te 12, K_re 15 N/mm.
ALUMINIUM = Coefficients(700e6, 210e6, 0.0, 12e3, 15e3)
DEPTH_M, FEED_M = 2e-3, 0.05e-3
TURN = np.linspace(0.0, 2.0 * math.pi, 7200, endpoint=False)


def test_mean_forces_of_slot_and_half_immersion():
    """The slot's closed form of Altintas, Manufacturing Automation, equation 2.68."""
    slot = Cut(Cutter(4, 0.02), Engagement.slot(), ALUMINIUM).mean_force(DEPTH_M, FEED_M)
    assert slot == pytest.approx([-59.197, 100.558, 0.0], abs=1e-3)
    half = Cut(Cutter(4, 0.02), Engagement.up(0.5), ALUMINIUM).mean_force(DEPTH_M, FEED_M)
    assert half == pytest.approx([-67.159, 24.496, 0.0], abs=1e-3)


@pytest.mark.parametrize('engagement', [Engagement.up(0.3), Engagement.down(0.1)])
@pytest.mark.parametrize('lead_deg', [90.0, 60.0])
def test_the_course_has_the_mean_of_the_closed_form(engagement, lead_deg):
    cutter = Cutter(3, 0.016, helix_rad=0.6, lead_rad=math.radians(lead_deg))
    made = Coefficients(700e6, 210e6, 90e6, 12e3, 15e3, 3e3)
    cut = Cut(cutter, engagement, made)
    course = cutting_force(cut, 4e-3, FEED_M, TURN)
    expected = cut.mean_force(4e-3, FEED_M)
    assert course.mean(axis=0) == pytest.approx(expected, rel=2e-3, abs=1e-2)
    # A period of the helix is no part of the pitch: the force never rests on one value.
    assert np.ptp(course[:, 0]) > 1.0


def test_an_end_mill_pulls_the_tool_to_the_work_by_the_axial_coefficient():
    cut = Cut(Cutter(2, 0.02), Engagement.slot(), Coefficients(700e6, 210e6, axial_pa=70e6))
    # Mean of N a K_ac c sin φ over a turn: N a K_ac c / π, downwards.
    assert cut.mean_force(DEPTH_M, FEED_M)[2] == pytest.approx(
        -2 * DEPTH_M * 70e6 * FEED_M / math.pi
    )


def test_directional_matrices_are_the_force_of_a_displacement():
    """A displacement against that of a tooth ago is a feed per tooth in its direction."""
    cut = Cut(Cutter(3, 0.02, helix_rad=0.5), Engagement.up(0.4), Coefficients(7e8, 2e8, 1e8))
    fine = np.linspace(0.0, 2.0 * math.pi / 3.0, 401)
    course = cutting_force(cut, 5e-3, FEED_M, 0.5 * (fine[1:] + fine[:-1])) / (5e-3 * FEED_M)
    made = cut.directional(fine, 5e-3)
    # Slices of the helix enter one by one in the course, within a step in the matrices.
    assert np.abs(made[:, :, 0] - course).mean() < 0.003 * np.abs(course).max()
    assert np.allclose(made.mean(axis=0), cut.mean_directional, rtol=1e-12, atol=1e-3)


def test_directional_factors_of_the_standard_case():
    """α of N = 3, half immersion up, K_t = 600 N/mm², k_r = 0.07."""
    cut = Cut(Cutter(3, 0.02), Engagement.up(0.5), Coefficients(600e6, 42e6))
    alpha = cut.mean_directional / (3 / (2 * math.pi)) / (0.5 * 600e6)
    assert alpha[:2, :2] == pytest.approx(
        np.array([[-1.10996, -1.64080], [1.50080, 0.89004]]), abs=1e-5
    )
    assert not alpha[2].any() and not alpha[:, 2].any()


def spindle_lines(cut):
    """Force along y at the orders 1 to 8 of the spindle, complex [N]."""
    course = cutting_force(cut, DEPTH_M, FEED_M, TURN)[:, 1]
    return np.abs(np.fft.rfft(course)[1:9]) / len(TURN)


def test_runout_makes_lines_of_the_spindle_between_those_of_the_teeth():
    engagement = Engagement.up(0.5)
    true = spindle_lines(Cut(Cutter(4, 0.02), engagement, ALUMINIUM))
    off = spindle_lines(Cut(Cutter(4, 0.02, runout_m=1e-5), engagement, ALUMINIUM))
    between = [0, 1, 2, 4, 5, 6]
    assert true[between].max() < 1e-9 * true[3]
    # The chip of a tooth differs by the step of radius, r√2 for four teeth: 28 % of the feed.
    assert off[0] > 0.1 * true[3]
    # All in all the same metal goes: the mean of the force keeps, but for edges out of the cut.
    mean = cutting_force(
        Cut(Cutter(4, 0.02, runout_m=1e-5), engagement, ALUMINIUM), DEPTH_M, FEED_M, TURN
    ).mean(axis=0)
    assert mean == pytest.approx(
        Cut(Cutter(4, 0.02), engagement, ALUMINIUM).mean_force(DEPTH_M, FEED_M), rel=0.12
    )


def test_with_much_runout_one_tooth_cuts_for_all():
    """Two teeth, runout far above the feed: one cuts two feeds, the other nothing."""
    bare = Coefficients(700e6, 210e6)
    cut = Cut(Cutter(2, 0.02, runout_m=1e-3), Engagement.up(0.5), bare)
    single = Cut(Cutter(1, 0.02), Engagement.up(0.5), bare)
    course = cutting_force(cut, DEPTH_M, FEED_M, TURN)
    assert np.allclose(course, cutting_force(single, DEPTH_M, 2 * FEED_M, TURN), atol=1e-6)


@pytest.mark.parametrize(
    'wrong',
    [
        lambda: Cutter(0, 0.02),
        lambda: Cutter(4, math.nan),
        lambda: Cutter(4, 0.02, helix_rad=1.6),
        lambda: Engagement.up(0.0),
        lambda: Engagement(2.0, 1.0),
        lambda: Coefficients(-1.0, 0.0),
        lambda: Coefficients(7e8, math.inf),
        lambda: Coefficients(7e8, 2e8, relative_std=1.5),
    ],
)
def test_what_is_no_cut_is_refused_in_one_line(wrong):
    with pytest.raises(SettingsError) as caught:
        wrong()
    assert '\n' not in str(caught.value)
