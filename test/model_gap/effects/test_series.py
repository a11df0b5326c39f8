"""A compliance in series with a spring the base has: as stiff and as lossy as the two."""

import numpy as np
import pytest

from model_gap.effects.base_compliance import series
from structural_model.description import Spring


@pytest.mark.parametrize('share', [0.01, 0.3, 1.0, 5.0])
def test_springs_in_series_are_as_stiff_and_as_lossy_as_the_two_of_them(share):
    """Exactly: 1 / (1 / (k + iωc) + 1 / (k' + iωc')), at a frequency of the arm."""
    spring, loss_s, omega = Spring(2e6, 800.0), 2e-3, 2.0 * np.pi * 12.0
    compliance = share / spring.stiffness
    found = series(spring, compliance, loss_s)
    own = 1.0 / (spring.stiffness + 1j * omega * spring.damping)
    both = 1.0 / (own + compliance / (1.0 + 1j * omega * loss_s))
    assert found.stiffness == pytest.approx(both.real, rel=0.03)
    assert omega * found.damping == pytest.approx(both.imag, rel=0.03)


def test_what_a_foundation_loses_counts_beside_the_base_of_the_model():
    """Ten times the loss time of the compliance, 30 % of the whole: a multiple of the damping."""
    spring = Spring(2e6, 800.0)
    slow, fast = (series(spring, 0.3 / 2e6, loss_s).damping for loss_s in (4e-4, 4e-3))
    assert fast > 3.0 * slow
