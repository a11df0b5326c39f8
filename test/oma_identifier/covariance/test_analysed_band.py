"""Which band is analysed, and what says so."""

import math

import pytest

from oma_identifier.covariance.analysed_band import (
    analysed_band,
    AnalysedBand,
    below_edge,
    sharp_edge_hz,
)
from oma_identifier.settings import IdentificationSettings

FREE = IdentificationSettings()


def test_only_band_limited_noise_ends_at_an_edge():
    assert sharp_edge_hz('band_limited_noise', 60.0) == 60.0
    assert sharp_edge_hz('random_pulses', 60.0) is None
    assert sharp_edge_hz('band_limited_noise', math.nan) is None
    assert sharp_edge_hz('band_limited_noise', 0.0) is None


def test_the_band_ends_below_the_edge_unless_the_settings_say_where():
    assert below_edge(FREE, None) is FREE
    assert below_edge(FREE, 60.0).max_frequency_hz == pytest.approx(57.0)
    stated = IdentificationSettings(max_frequency_hz=200.0)
    assert below_edge(stated, 60.0) is stated
    above = IdentificationSettings(min_frequency_hz=80.0)
    assert below_edge(above, 60.0) is above


def test_the_band_says_what_chose_its_edges():
    limited = below_edge(FREE, 60.0)
    assert analysed_band(1000.0, 300.0, FREE, FREE) == AnalysedBand(0.1, 450.0)
    assert analysed_band(1000.0, 300.0, FREE, limited) == AnalysedBand(0.1, 57.0, 'data', 'plan')
    stated = IdentificationSettings(min_frequency_hz=2.0, max_frequency_hz=80.0)
    expected = AnalysedBand(2.0, 80.0, 'settings', 'settings')
    assert analysed_band(1000.0, 300.0, stated, stated) == expected
    # A slow recording ends below the edge of the excitation.
    assert analysed_band(100.0, 300.0, FREE, limited).high_from == 'data'
