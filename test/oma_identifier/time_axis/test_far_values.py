"""Values far outside of all others: placeholders and sparks are found, what vibrates is not."""

import numpy as np
from numpy.testing import assert_array_equal
import pytest
from scipy.signal import lfilter

from oma_identifier.time_axis import FarValues

SEED = 989500
RATE = 200
N = 20 * RATE


@pytest.fixture
def rng():
    return np.random.default_rng(SEED)


def ringing(force):
    """Return the response of a mode at a tenth of the rate to a force."""
    return lfilter([1.0], [1.0, -1.6, 0.98], force, axis=0)


def found(values):
    """Return what is marked, stretch by stretch as it comes, and the watch."""
    watch = FarValues(values.shape[1])
    stamps = np.arange(len(values)) * 5_000_000
    far = np.zeros(values.shape, dtype=bool)
    for start in range(0, len(values), RATE):
        first, last = max(0, start - 40), min(len(values), start + RATE + 5)
        mark = watch.mark(
            stamps[first:last], values[first:last], 5_000_000 * start, 5_000_000 * (start + RATE)
        )
        far[start : start + RATE] = mark[start - first : start - first + RATE]
    return far, watch


@pytest.mark.parametrize('value', [9999.0, -999.0, 32.767])
def test_a_value_that_recurs_far_outside_is_no_measurement(rng, value):
    values = rng.standard_normal((N, 3))
    lost = np.sort(rng.choice(np.arange(10, N - 10), 200, replace=False))
    values[lost, 1] = value
    far, watch = found(values)
    # One that is not ten times as far may be a tap until it comes again.
    assert np.count_nonzero(far[lost, 1]) >= len(lost) - 1
    far[lost, 1] = False
    assert not far.any()
    told = watch.told(0, 5_000_000 * N)
    assert {each[1] for each in told[1]} == {value}
    assert sum(each[2] for each in told[1]) >= len(lost) - 1
    assert told[0] == told[2] == ()


def test_a_long_run_of_a_known_value_is_lost_as_a_whole(rng):
    values = rng.standard_normal((N, 2))
    values[[500, 700], 0] = 9999.0
    values[1000:2000, 0] = 9999.0
    far, _ = found(values)
    assert_array_equal(far[:, 0], values[:, 0] == 9999.0)


def test_a_run_at_the_beginning_hides_none_of_later(rng):
    values = rng.standard_normal((N, 2))
    values[60:450, 0] = 9999.0
    values[[1500, 1700, 2000], 0] = 9999.0
    far, _ = found(values)
    assert_array_equal(far[600:, 0], values[600:, 0] == 9999.0)


def test_zeros_amid_gravity_are_no_measurement(rng):
    values = 9.81 + 0.05 * rng.standard_normal((N, 2))
    values[[333, 334, 900, 2500], 1] = 0.0
    far, _ = found(values)
    assert_array_equal(far, values == 0.0)


def test_sparks_are_no_measurement(rng):
    values = ringing(rng.standard_normal((N, 2)))
    rows = [450, 1717, 1990, 3000]
    values[rows, 0] += 60.0 * values.std() * np.array([1.0, -1.3, 0.9, 1.1])
    far, _ = found(values)
    assert_array_equal(np.flatnonzero(far[:, 0]), rows)
    assert not far[:, 1].any()


def test_taps_and_what_begins_suddenly_stay(rng):
    force = np.zeros((N, 2))
    for row in (600, 1500, 2411, 3307):
        force[row : row + 3] = [[1.0], [3.0], [1.0]]
    values = ringing(force) + 1e-3 * rng.standard_normal((N, 2))
    values[:, 0] += 30.0 * force[:, 0]  # Beside the hammer.
    assert not found(values)[0].any()
    force = rng.standard_normal((N, 2))
    force[: N // 2] *= 1e-3
    assert not found(ringing(force))[0].any()


@pytest.mark.parametrize('dof', [2, 3])
def test_heavy_tails_stay(rng, dof):
    assert not found(ringing(rng.standard_t(dof, size=(N, 3))))[0].any()


def test_steps_and_limits_of_a_converter_stay(rng):
    coarse = np.round(2.0 * rng.standard_normal((N, 1)))
    coarse[[40, 900, 1800]] = 40.0  # Of levels so few, no more is known.
    assert not found(coarse)[0].any()
    stepped = rng.standard_normal((N, 1))
    stepped[1730:] += 80.0
    assert not found(np.round(stepped, 2))[0].any()
    clipped = np.clip(rng.standard_normal((N, 1)), -1.0, 1.0)
    assert not found(clipped)[0].any()
