"""Chances of chatter and proposals, on machines whose answer is known."""

import math

import numpy as np
import pytest

from machining.cut import Coefficients, Cut, Cutter, Engagement
from machining.cut_settings import CutSettings
from machining.lobes import stability_lobes
from machining.stability import (
    DepthSearch,
    limits_of_modes,
    limits_of_periods,
    linear_std,
    sampled_limits,
    spectral_radius,
)
from machining.task import axes_of, cut_of, ToolResponse
from modal_core.errors import SettingsError
from modal_core.tool_modes import ToolModes

SEED = 20261125
F_STD, Z_STD, PHI_STD = 0.004, 0.05, 0.03


def uncertain(frequency_hz=(603.0, 666.0), ratio=(0.039, 0.035)):
    mass = np.array([5.59e6, 5.715e6]) / (2 * np.pi * np.array([603.0, 666.0])) ** 2
    shape = np.eye(2, 3) / np.sqrt(mass)[:, None]
    deviation = np.zeros((2, 5))
    deviation[:, :2] = F_STD, Z_STD
    deviation[:, 2:] = PHI_STD * np.abs(shape)
    covariance = np.diag(deviation.ravel() ** 2)
    return ToolModes(np.array(frequency_hz), np.array(ratio), shape, covariance)


CUT = Cut(Cutter(3, 0.02), Engagement.up(0.5), Coefficients(600e6, 42e6, relative_std=0.08))
ASKED = {
    'n_teeth': 3,
    'diameter_mm': 20,
    'tangential_n_mm2': 600,
    'radial_n_mm2': 42,
    'way': 'up',
    'radial_depth_mm': 10,
    'min_speed_rpm': 8000,
    'max_speed_rpm': 16000,
    'n_speeds': 9,
}


def test_straight_lines_and_samples_agree_at_the_foot_of_a_lobe():
    """There the limit goes with 2 k ζ / K: its σ is that of ζ, twice that of φ, and of K."""
    one = ToolModes(np.array([922.0]), np.array([0.011]), np.array([[5.0, 0.0, 0.0]]))
    deviation = np.array([F_STD, Z_STD, PHI_STD * 5.0, 0.0, 0.0])
    one = ToolModes(one.frequency_hz, one.damping_ratio, one.shape, np.diag(deviation**2))
    cut = Cut(Cutter(2, 0.01), Engagement.slot(), Coefficients(6e8, 2e8, relative_std=0.08))
    wide = np.linspace(9000.0, 16000.0, 400)
    foot = wide[[int(np.argmin(limits_of_modes(one, cut, wide).depth_m))]]
    (line,) = linear_std(one, cut, lambda modes, other: limits_of_modes(modes, other, foot))
    expected = math.sqrt(Z_STD**2 + (2 * PHI_STD) ** 2 + 0.08**2)
    assert line == pytest.approx(expected, rel=0.05)


def test_straight_lines_and_samples_agree_on_a_slope():
    print('seed', SEED)
    speeds = np.array([8400.0, 13000.0, 15500.0])

    def limits_of(modes, cut):
        return limits_of_modes(modes, cut, speeds)

    sample = sampled_limits(uncertain(), CUT, limits_of, 500, np.random.default_rng(SEED))
    spread = np.log(sample.depth_m).std(axis=0)
    # Five hundred samples tell a deviation to 3 %; lobes are a little curved.
    assert linear_std(uncertain(), CUT, limits_of) == pytest.approx(spread, rel=0.12)
    nominal = limits_of(uncertain(), CUT).depth_m
    assert sample.chance(nominal) == pytest.approx(0.5, abs=0.1)
    assert sample.chance(0.3 * nominal).max() == 0.0


def test_without_deviation_every_sample_is_the_nominal_limit():
    sure = ToolModes(
        uncertain().frequency_hz, uncertain().damping_ratio, uncertain().shape, np.zeros((10, 10))
    )
    cut = Cut(CUT.cutter, CUT.engagement, Coefficients(600e6, 42e6))

    def limits_of(modes, other):
        return limits_of_modes(modes, other, np.array([9000.0]))

    sample = sampled_limits(sure, cut, limits_of, 5, np.random.default_rng(SEED))
    assert np.ptp(sample.depth_m) < 1e-12
    bare = ToolModes(sure.frequency_hz, sure.damping_ratio, sure.shape)
    with pytest.raises(SettingsError, match='σ'):
        sampled_limits(bare, cut, limits_of, 5, np.random.default_rng(SEED))


@pytest.mark.slow
def test_proposals_take_much_and_chatter_seldom():
    settings = CutSettings.from_mapping({**ASKED, 'coefficients_std': 0.08, 'n_samples': 12})
    found = stability_lobes(uncertain(), settings)
    assert found.proposals
    rng = np.random.default_rng(SEED)
    for proposal in found.proposals:
        turned = uncertain().turned(axes_of(settings, proposal.feed_deg))
        limit = limits_of_periods(
            turned, cut_of(settings), [proposal.speed_rpm], DepthSearch(1e-4, 0.02)
        ).depth_m[0]
        assert 0.5 * limit < proposal.depth_m < limit
        off = rng.multivariate_normal(np.zeros(10), turned.covariance, 150)
        grows = [
            spectral_radius(
                turned.with_parameters(turned.parameters + step),
                cut_of(settings),
                proposal.speed_rpm,
                proposal.depth_m * math.exp(0.08 * rng.standard_normal()),
            )
            > 1.0
            for step in off
        ]
        # The stated chance is at most 5 %; 150 samples scatter by 1.8 %.
        assert np.mean(grows) < 0.05 + 3 * 0.018
        # Teeth do not pass near a mode.
        passing = proposal.speed_rpm * 3 / 60
        assert np.abs(passing / uncertain().frequency_hz - 1.0).min() > 3 * 0.035


def test_of_two_directions_the_better_is_chosen():
    settings = CutSettings.from_mapping({**ASKED, 'feed_deg': [0.0, 90.0], 'theory': 'mean'})
    found = stability_lobes(uncertain(), settings)
    first, second = (chart.mean.depth_m for chart in found.charts)
    assert first.max() > second.max()
    assert {each.feed_deg for each in found.proposals} == {found.charts[0].feed_deg}


def test_a_feed_turned_back_cuts_the_same():
    """Half a turn changes the sign of feed and normal alike."""
    settings = CutSettings.from_mapping({**ASKED, 'feed_deg': [30.0, 210.0], 'theory': 'mean'})
    one, other = stability_lobes(uncertain(), settings).charts
    assert one.mean.depth_m == pytest.approx(other.mean.depth_m, rel=1e-9)


def test_a_measured_response_gives_the_limits_of_its_modes():
    lines = np.arange(200.0, 1500.0, 1.0)
    tool = ToolResponse(lines, uncertain().receptance(lines))
    settings = CutSettings.from_mapping({**ASKED, 'theory': 'mean'})
    of_lines, of_modes = (stability_lobes(each, settings) for each in (tool, uncertain()))
    assert of_lines.charts[0].mean.depth_m == pytest.approx(
        of_modes.charts[0].mean.depth_m, rel=5e-3
    )
    assert any('doubled period' in remark for remark in of_lines.remarks)


def test_a_response_beside_the_modes_is_refused():
    lines = np.arange(20.0, 60.0, 1.0)
    tool = ToolResponse(lines, np.abs(uncertain().receptance(lines)) + 0j)
    with pytest.raises(SettingsError, match='response'):
        stability_lobes(tool, CutSettings.from_mapping({**ASKED, 'theory': 'mean'}))


def test_without_deviations_no_chance_is_stated():
    bare = uncertain()
    bare = ToolModes(bare.frequency_hz, bare.damping_ratio, bare.shape)
    found = stability_lobes(bare, CutSettings.from_mapping(ASKED))
    assert found.charts[0].sample is None
    assert all(math.isnan(each.chance) for each in found.proposals)
    assert any('by convention' in remark for remark in found.remarks)
