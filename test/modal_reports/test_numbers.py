"""Numbers with their deviation and unit, the same in every report and table."""

import math

import pytest

from modal_reports import (
    DAMPING,
    deviation_text,
    fixed,
    FREQUENCY,
    MPD,
    percent,
    significant,
    value_text,
    with_sigma,
)


@pytest.mark.parametrize(
    ('value', 'std', 'text', 'deviation'),
    [
        (12.34567, 0.0123, '12.346', '0.012'),
        (12.34567, math.nan, '12.35', '–'),
        (12.34567, None, '12.35', '–'),
        (1234.5, 25.0, '1234', '25'),
        (math.nan, 0.1, '–', '0.10'),
        (None, None, '–', '–'),
        (3.4e6, 2e4, '3.400e6', '0.020e6'),
    ],
)
def test_numbers_show_the_digits_their_deviation_supports(value, std, text, deviation):
    assert value_text(value, std) == text
    assert deviation_text(value, std) == deviation


@pytest.mark.parametrize(
    ('value', 'std', 'unit', 'text'),
    [
        (3.42, 0.018, 'Hz', '3.420 ± 0.018 Hz'),
        (3.42, math.nan, 'Hz', '3.420 Hz'),
        (3.42, 0.0, 'Hz', '3.420 Hz'),
        (math.nan, 0.1, 'Hz', '–'),
        (math.inf, None, 'Hz', '–'),
        (0.708, 0.015, '1', '0.708 ± 0.015'),
        (-2.5, 0.3, 'kg', '−2.50 ± 0.30 kg'),
        (0.0, 0.1, 'm', '0.00 ± 0.10 m'),
        (3.4e6, 2e4, 'N m/rad', '(3.400 ± 0.020)e6 N m/rad'),
        (1.2e-5, 3e-6, 'rad', '(1.20 ± 0.30)e-5 rad'),
        (5e-324, None, 'm', '0.000000 m'),
        (4.43, 1e-9, 'Hz', '4.430000 ± 1.0e-09 Hz'),
    ],
)
def test_a_value_is_written_with_its_deviation_and_unit(value, std, unit, text):
    assert with_sigma(value, std, unit) == text


def test_quantities_know_their_units():
    assert FREQUENCY.text(3.42, 0.018) == '3.420 ± 0.018 Hz'
    assert DAMPING.text(0.0234, 0.0012) == '2.34 ± 0.12 %'
    assert MPD.number(math.radians(12.0)) == '12.00'
    assert FREQUENCY.of('measured').heading == 'Measured frequency [Hz]'


def test_no_rounding_hides_a_value_and_no_digit_is_made_up():
    for value in (1e-300, 3.3e-7, 0.00099, 0.5, 9.9996, 999_999.9, 1e6, 4.2e11):
        for relative in (1e-3, 0.02, 0.4, 3.0):
            std = relative * value
            shown, deviation = value_text(value, std), deviation_text(value, std)
            # Two digits of the deviation: half a unit of the second is 5 % of it at most.
            assert float(shown) == pytest.approx(value, abs=0.06 * std), (value, std)
            assert float(deviation) == pytest.approx(std, rel=0.06), (value, std)


def test_significant_digits():
    assert [significant(value) for value in (0.0, 1.0, 128.004, 1e-7, -2.5)] == [
        '0', '1.00', '128', '1.00e-07', '\N{MINUS SIGN}2.50',
    ]  # fmt: skip


def test_zero_has_no_sign():
    texts = [fixed(value, 1, sign=True) for value in (-0.01, 0.0, 0.14, -0.06)]
    assert texts == ['0.0', '0.0', '+0.1', '\N{MINUS SIGN}0.1']


def test_fractions_as_per_cent():
    assert [percent(value) for value in (0.021, None, math.inf)] == ['2.1 %', '–', '–']
