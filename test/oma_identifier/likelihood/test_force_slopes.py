"""What bands say of the slope of the force in others, and what a steep one says: nothing."""

import math

import pytest

from oma_identifier.likelihood import ForceSlope, pooled_slopes

GENTLE = [ForceSlope(math.log(hz), value, 25.0) for hz, value in ((8.0, 0.4), (12.0, 0.6))]
STEEP = ForceSlope(math.log(40.0), -15.0, 25.0)


def test_gentle_slopes_tell_of_each_other():
    first, second = pooled_slopes(GENTLE, [slope.place for slope in GENTLE])
    assert 0.4 < first.mean < 0.6 and 0.3 < second.mean < 0.4
    assert first.std < 0.6 and second.std < 0.6


def test_beside_a_steep_slope_nothing_is_assumed():
    slopes = [*GENTLE, STEEP]
    for prior in pooled_slopes(slopes, [slope.place for slope in slopes]):
        assert prior.mean == 0.0 and prior.std == 15.0


@pytest.mark.parametrize(
    ('value', 'std', 'steep'), [(-9.0, 0.1, True), (-5.0, 0.1, False), (-15.0, 6.0, False)]
)
def test_a_slope_is_steep_that_the_data_tell(value, std, steep):
    """That of displacements, -4, is not."""
    assert ForceSlope(0.0, value, std**-2.0).is_steep is steep
