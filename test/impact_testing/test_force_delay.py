"""Forces that come late or early against the responses: other filters, other converters."""

import numpy as np
import pytest

from impact_testing import impact_modes, ImpactRecord, ScaledMode
from impact_testing.checks import remarks_on
from impact_testing.fit import Places
from modal_core.mode import Mode
from test.support.hammer_bench import even_chain, taps

SEED = 44
N = 5
TRUE_HZ = np.sqrt(4e4) / np.pi * np.sin((2 * np.arange(1, N + 1) - 1) * np.pi / (4 * N + 2))
MASS_KG = float(10.0 * (2 * N + 1) / 4 / np.cos(np.pi / (4 * N + 2)) ** 2)


@pytest.mark.parametrize('samples', [-1, 1, 2])
def test_a_delay_of_whole_samples_is_estimated_told_and_taken_out(samples):
    """Half-widths of poles that should explain it grew without end: a traceback."""
    rng = np.random.default_rng(SEED)
    record = taps(
        even_chain(), 4, 1.0 + 3.0 * np.arange(4), rng, last_s=3.0, noise=0.01, force_noise_n=0.1
    )
    late = ImpactRecord(np.roll(record.force_n, samples), record.responses, record.hit)
    found = impact_modes([late])
    assert found.modes.frequency_hz == pytest.approx(TRUE_HZ, rel=1e-4)
    masses = [each.modal_mass_kg for each in found.scaled_modes]
    assert masses == pytest.approx([MASS_KG] * N, rel=0.01)
    (told,) = (each for each in found.remarks if each.startswith('the force comes'))
    words = told.split()
    true_ms = 1e3 * abs(samples) / 512.0
    assert float(words[3]) == pytest.approx(true_ms, abs=max(0.01, 5.0 * float(words[5])))
    assert ('later' in words) == (samples > 0)
    assert not any(each.startswith('the force comes') for each in impact_modes([record]).remarks)


def remark_on(modes, length_s=3.0):
    """Return what is said of modes without deviations."""
    places = Places(('a1', 'a2'), 2, (0,), (np.arange(2),))
    (said,) = remarks_on((), modes, places, misfit=1.0, length_s=length_s)
    return said


def test_what_took_the_deviations_is_told_as_what_it_is():
    """A mode by itself without σ has no other near it; two within their half-widths have."""
    nan = float('nan')

    def mode(hz, damping):
        shape = np.ones(2, dtype=complex)
        return ScaledMode(Mode(hz, damping, shape, frequency_std_hz=nan), 1.0, nan)

    apart = remark_on([mode(9.06, 0.01), mode(26.4, 0.015)])
    assert 'over modes at 9.06, 26.4 Hz lies something broad' in apart
    near = remark_on([mode(20.0, 0.02), mode(20.2, 0.02)])
    assert 'modes at 20, 20.2 Hz lie within their half-widths' in near
    ringing = remark_on([mode(9.06, 0.001), mode(26.4, 0.001)])
    # Its amplitude decays by e within 1 / (2π 0.001 9.06 Hz) = 18 s.
    assert 'modes at 9.06, 26.4 Hz ring on' in ringing
    assert 'pauses of 18 s' in ringing
