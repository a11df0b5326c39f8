"""Channels with the samples of another one."""

import numpy as np

from oma_identifier.quality import copies

RNG = np.random.default_rng(5)


def found_in(values):
    return copies(list(values.T), np.array([values.min(axis=0), values.max(axis=0)]))


def test_a_copy_is_found_whichever_precision_and_alike_channels_are_none():
    values = RNG.standard_normal((2048, 4))
    values[:, 3] = values[:, 1]
    assert found_in(values) == [3]
    assert found_in(values.astype(np.float32)) == [3]
    values[:, 2] = values[:, 1]
    assert found_in(values) == [2, 3]


def test_channels_of_a_coarse_converter_that_see_one_motion_are_no_copies():
    """Two sensors of one place, with noise of a step of a converter of 24 and of 8 bits."""
    motion = RNG.standard_normal((2048, 1))
    for step in (2.0**-20, 2.0**-4):
        noisy = motion + step * RNG.standard_normal((2048, 2))
        assert not found_in(np.round(noisy / step) * step)
        assert not found_in((np.round(noisy / step) * step).astype(np.float32))


def test_one_sample_that_differs_is_no_copy():
    values = np.repeat(RNG.standard_normal((2048, 1)), 2, axis=1)
    values[1000, 1] *= 1.001
    assert not found_in(values)
