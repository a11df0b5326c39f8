"""A light mode inside the bell of a broad one, where one channel sees both."""

import numpy as np
import pytest

from oma_identifier.identify import identify_samples
from oma_identifier.settings import IdentificationSettings

SETTINGS = IdentificationSettings(refine=False)


@pytest.mark.parametrize(
    ('frequency_hz', 'damping'),
    [((9.2, 10.6), (0.0015, 0.08)), ((9.2,), (0.0015,)), ((10.6,), (0.08,))],
)
def test_alike_shapes_do_not_make_two_modes_one(structure, frequency_hz, damping):
    known = structure(frequency_hz, damping, n_channels=1)
    found = []
    for seed in range(7000, 7010):
        samples = known.simulate(np.random.default_rng(seed), 400.0, 64.0)
        found.append(len(identify_samples(samples, SETTINGS).modes))
    print('seeds 7000 to 7009:', found)
    right = [count == len(frequency_hz) for count in found]
    assert not any(count > len(frequency_hz) for count in found)
    assert sum(right) >= 8  # of two modes 4 were, when alike shapes alone made them one
