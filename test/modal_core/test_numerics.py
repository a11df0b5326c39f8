"""What the identifier does without SciPy's larger packages gives what they give."""

import numpy as np
from scipy.optimize import linear_sum_assignment
from scipy.signal import find_peaks, peak_widths
from scipy.signal.windows import blackmanharris
from scipy.signal.windows import hann as scipy_hann
from scipy.stats import f as fisher_f

from modal_core.numbers.assignment import cheapest_pairs
from modal_core.numbers.chance import fisher_tail
from modal_core.numbers.prominence import crossings, prominent_peaks
from modal_core.numbers.tapers import blackman_harris, hann

SEED = 20261


def test_pairs_are_the_cheapest():
    rng = np.random.default_rng(SEED)
    for _ in range(1000):
        cost = rng.standard_normal(rng.integers(1, 9, 2))
        cost = np.where(cost > rng.uniform(0.0, 4.0), 1e3, cost)
        rows, columns = cheapest_pairs(cost)
        least = cost[linear_sum_assignment(cost)].sum()
        assert len(set(rows)) == len(set(columns)) == min(cost.shape)
        np.testing.assert_allclose(cost[rows, columns].sum(), least, err_msg=f'seed {SEED}')


def test_peaks_and_their_widths():
    rng = np.random.default_rng(SEED)
    for _ in range(300):
        curve = rng.standard_normal(rng.integers(3, 300))
        curve = np.round(2.0 * curve) / 2.0 if rng.random() < 0.5 else curve
        place, known = find_peaks(curve, prominence=0.7)
        found = prominent_peaks(curve, 0.7)
        np.testing.assert_array_equal(found.place, place, err_msg=f'seed {SEED}')
        np.testing.assert_array_equal(found.left, known['left_bases'])
        np.testing.assert_array_equal(found.right, known['right_bases'])
        widths = peak_widths(curve, place, 0.5, prominence_data=tuple(known.values()))
        for number, top in enumerate(place):
            half = curve[top] - 0.5 * found.prominence[number]
            ends = crossings(curve, top, half, found.left[number], found.right[number])
            np.testing.assert_allclose(ends, (widths[2][number], widths[3][number]))


def test_tapers_and_chances():
    for length in (16, 101):
        np.testing.assert_array_equal(hann(length), scipy_hann(length, sym=False))
        np.testing.assert_array_equal(blackman_harris(length), blackmanharris(length, sym=False))
    ratio = np.array([0.0, 0.3, 1.0, 7.0, 1e3])
    np.testing.assert_allclose(fisher_tail(ratio, 6, 40), fisher_f.sf(ratio, 6, 40))
