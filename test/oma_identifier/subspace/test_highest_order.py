"""An order that the rows of a Hankel matrix do not hold is not asked for."""

from dataclasses import replace

import numpy as np
import pytest

from oma_identifier.identify import identify_samples
from oma_identifier.settings import IdentificationSettings

SEED = 4


@pytest.mark.parametrize(('n_channels', 'rows', 'order'), [(1, 40, 80), (2, 10, 40), (3, 10, 40)])
def test_few_rows_and_a_high_order_are_no_traceback(structure, n_channels, rows, order):
    made = structure(np.array([8.0, 21.0]), np.array([0.01, 0.01]))
    made = replace(made, shapes=made.shapes[:n_channels])
    samples = made.simulate(np.random.default_rng(SEED), 120.0, 100.0)
    settings = IdentificationSettings(block_rows=rows, max_order=order, refine=False)
    found = identify_samples(samples, settings).modes.frequency_hz
    assert np.min(np.abs(found - 8.0)) < 0.2, f'seed {SEED}: {found}'
