"""Settings and the split into bands."""

from itertools import pairwise

import numpy as np
import pytest

from modal_core.errors import IdentificationError, SettingsError
from oma_identifier.covariance.bands import plan_bands
from oma_identifier.covariance.condition import BandConditioner
from oma_identifier.settings import IdentificationSettings


@pytest.mark.parametrize(
    ('field', 'value'),
    [
        ('window_s', 0.0),
        ('window_s', float('nan')),
        ('hop_s', 100.0),
        ('max_order', 101),
        ('min_frequency_hz', -1.0),
        ('max_damping_ratio', 2.0),
    ],
)
def test_out_of_range_names_field_value_and_range(field, value):
    with pytest.raises(SettingsError) as caught:
        IdentificationSettings(**{field: value})
    text = str(caught.value)
    assert field in text and str(value) in text and 'expected' in text


def test_empty_band_is_refused():
    with pytest.raises(SettingsError, match='empty band'):
        IdentificationSettings(min_frequency_hz=10.0, max_frequency_hz=5.0)


@pytest.mark.parametrize(
    ('rate_hz', 'duration_s', 'highest'),
    [(512.0, 60.0, None), (100.0, 5400.0, None), (100.0, 5400.0, 5.0), (425.08, 59.5, None),
     (4096.0, 30.0, 200.0), (1000.0, 120.0, 3.0)],
)  # fmt: skip
def test_bands_leave_no_hole(rate_hz, duration_s, highest):
    settings = IdentificationSettings(max_frequency_hz=highest)
    bands = plan_bands(rate_hz, duration_s, settings)
    assert bands[0].high_hz == pytest.approx(highest or 0.45 * rate_hz)
    for upper, lower in pairwise(bands):
        assert lower.high_hz > upper.low_hz
    for band in bands:
        assert band.sample_rate_hz == pytest.approx(rate_hz / np.prod(band.factors))
        assert band.high_hz <= (0.4001 if band.factors else 0.4501) * band.sample_rate_hz
        assert band.high_pass_hz < band.low_hz


def test_how_slow_a_mode_may_be_follows_from_the_length_whatever_the_rate():
    """A pendulum in a record that was sampled for what sings beside it."""
    for rate_hz in (4.0, 100.0, 20_000.0):
        bands = plan_bands(rate_hz, 600.0, IdentificationSettings())
        assert bands[-1].low_hz == pytest.approx(30.0 / 600.0)


def test_too_short_a_record_says_so():
    with pytest.raises(IdentificationError, match='too short'):
        plan_bands(100.0, 0.5, IdentificationSettings())


@pytest.mark.parametrize('band_index', [0, 1, 2])
def test_conditioning_keeps_the_band_and_nothing_above(band_index):
    rate_hz = 512.0
    band = plan_bands(rate_hz, 60.0, IdentificationSettings())[band_index]
    time = np.arange(60 * 512) / rate_hz

    def power(frequency_hz):
        rows = np.sin(2 * np.pi * frequency_hz * time)[:, None]
        return np.mean(BandConditioner(band).condition(rows)[len(time) // 100 :] ** 2)

    for share in (0.1, 0.25, 0.39):
        assert power(share * band.sample_rate_hz) == pytest.approx(0.5, rel=0.05)
    if band.factors:
        # Would alias to 0.3 of the band's rate.
        assert power(0.7 * band.sample_rate_hz) < 1e-6
    assert power(0.1 * band.high_pass_hz) < 1e-4


def test_conditioning_in_chunks_is_the_same():
    band = plan_bands(512.0, 60.0, IdentificationSettings())[2]
    rows = np.random.default_rng(50).standard_normal((9000, 2)) + 9.81
    whole = BandConditioner(band).condition(rows)
    conditioner = BandConditioner(band)
    pieces = [conditioner.condition(piece) for piece in np.split(rows, [1, 17, 500, 4096, 4097])]
    np.testing.assert_allclose(np.concatenate(pieces), whole, atol=1e-12)
