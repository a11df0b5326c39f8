"""A slope of the force is steep where the data say so, whatever was assumed before them."""

from types import SimpleNamespace

import pytest

from oma_identifier.likelihood import is_steep


@pytest.mark.parametrize(
    ('value', 'std', 'steep'), [(-9.0, 0.1, True), (-5.0, 0.1, False), (-15.0, 6.0, False)]
)
def test_a_slope_is_steep_that_the_data_tell(value, std, steep):
    """That of displacements, -4, is not."""
    precision = std**-2.0
    drawn = value * precision / (precision + 1.0)
    fit = SimpleNamespace(model=SimpleNamespace(slope=drawn), slope_std=(precision + 1.0) ** -0.5)
    assert is_steep(fit) is steep
