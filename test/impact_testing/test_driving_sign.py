"""Points that are said to be hit and are not, and hammers of the other sign."""

import numpy as np
import pytest

from impact_testing import impact_modes, ImpactRecord
from test.support.hammer_bench import even_chain, taps

SEED = 43
N = 5
MASS_KG = float(10.0 * (2 * N + 1) / 4 / np.cos(np.pi / (4 * N + 2)) ** 2)
NAMES = [f'm{number + 1}' for number in range(N)]


def struck_at_the_end(sign=1.0, hit='m5'):
    rng = np.random.default_rng(SEED)
    record = taps(even_chain(), 4, 0.5 + 3.0 * np.arange(4), rng, last_s=3.0, noise=0.01)
    return ImpactRecord(sign * record.force_n, record.responses, hit)


@pytest.mark.parametrize('said', NAMES[:-1])
def test_a_channel_that_was_not_struck_gives_no_masses(said):
    """Shapes sin(jπ (2r - 1) / (2n + 1)): at all masses but the last modes have both signs."""
    right, found = impact_modes([struck_at_the_end()]), impact_modes([struck_at_the_end(hit=said)])
    assert not right.remarks
    assert any(f'at {said} the answer to the force has one sign' in each for each in found.remarks)
    assert np.isnan([each.modal_mass_kg for each in found.scaled_modes]).all()
    assert found.modes.frequency_hz == pytest.approx(right.modes.frequency_hz, rel=1e-6)


@pytest.mark.parametrize(('sign', 'hit'), [(-1.0, 'm5'), (1.0, '-m5')])
def test_a_force_of_the_other_sign_is_turned_round_and_told(sign, hit):
    right, found = (
        impact_modes([struck_at_the_end()]),
        impact_modes([struck_at_the_end(sign, hit)]),
    )
    assert any('opposite signs at m5 in every mode' in each for each in found.remarks)
    for mine, theirs in zip(found.scaled_modes, right.scaled_modes, strict=True):
        assert mine.modal_mass_kg == pytest.approx(MASS_KG, rel=3e-3)
        assert mine.modal_mass_std_kg == pytest.approx(theirs.modal_mass_std_kg, rel=1e-3)
    # So have the FRFs that are written and drawn, and the phase of the driving point.
    (mine,), (theirs,) = found.points, right.points
    assert mine.measured == pytest.approx(theirs.measured)
    assert mine.synthesised == pytest.approx(theirs.synthesised, abs=1e-5)
    assert np.abs(found.driving_phase_deg['m5']).max() < 5.0
