"""The climb to the maximum of the likelihood of a tap test ends at the summit."""

import numpy as np
import pytest

from impact_testing import impact_modes, impact_test
from impact_testing.fit import fitted
from impact_testing.fit.modal_model import climb
from test.support.hammer_bench import random_structure, taps

SEED = 710_000


@pytest.fixture(scope='module')
def summit():
    """Return data of three points and the model that was found; five modes of 5 to 10 %."""
    rng = np.random.default_rng(SEED)
    structure = random_structure(rng, 5, damping=(0.05, 0.10))
    times = 0.5 + 2.5 * np.arange(5)
    records = [taps(structure, hit, times, rng, noise=0.02, last_s=2.5) for hit in (0, 2, 4)]
    found = []
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(impact_test, 'fitted', lambda data: found.append(fitted(data)) or found[0])
        impact_modes(records)
    return found[0]


@pytest.mark.parametrize('seed', range(6))
def test_it_comes_back_from_half_a_band_away(summit, seed):
    data, model = summit
    rng = np.random.default_rng([SEED, seed])
    away = rng.uniform(-0.5, 0.5, (2, len(model.pole)))
    half_width = -model.pole.real
    pole = model.pole + half_width * (away[0] + 1j * away[1])
    again = climb(data, model.places, pole, model.shape)
    assert sum(again.cost) < sum(model.cost) + 1.0, seed


def test_a_pole_on_the_other_side_of_the_real_axis_comes_back_as_its_mirror_image(summit):
    """It explains the same, and its modal mass would be negative."""
    data, model = summit
    pole, shape = 0.99 * model.pole, model.shape.copy()
    pole[1], shape[1] = pole[1].conj(), shape[1].conj()
    again = climb(data, model.places, pole, shape)
    assert np.all(again.pole.imag > 0.0), again.pole
    np.testing.assert_allclose(np.sort_complex(again.pole), np.sort_complex(model.pole), rtol=1e-3)
