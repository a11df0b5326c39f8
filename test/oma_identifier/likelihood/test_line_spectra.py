"""Lines of the spectra near a mode, wherever a fit led it."""

import numpy as np
import pytest

from oma_identifier.likelihood.line_spectra import Spectra

LINES = np.ones((2, 51), dtype=np.complex64)
SPECTRA = Spectra(10.0, np.linspace(0.0, 5.0, 51), LINES, (10.0,), np.zeros(51, int))


CASES = [(1.02, 1.0), (4.98, 5.0), (5.3, 5.0), (60.0, 5.0), (0.0, 0.1)]


@pytest.mark.parametrize(('frequency_hz', 'expected_hz'), CASES)
def test_a_mode_has_at_least_one_line_even_beyond_the_end_of_the_spectrum(
    frequency_hz, expected_hz
):
    near = SPECTRA.frequency_hz[SPECTRA.near(frequency_hz, 0.15)]
    assert len(near) >= 1
    assert np.abs(near - expected_hz).min() < 0.15


def test_along_gives_one_value_for_a_mode_that_a_fit_led_beyond_the_end():
    response = SPECTRA.along(np.array([1.0 + 0j, 2.0]), SPECTRA.near(9.0, 0.15))
    assert response == pytest.approx([3.0])
