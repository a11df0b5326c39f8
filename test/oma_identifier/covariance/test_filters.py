"""The filters of a band are the textbook's, however the rows come in stretches."""

from itertools import pairwise

import numpy as np
import pytest
from scipy.signal import butter, firwin, kaiser_beta, sosfilt, sosfilt_zi

from oma_identifier.covariance.filters import (
    butterworth_high_pass,
    kaiser_low_pass,
    RunningFilter,
)

SEED = 20262


@pytest.mark.parametrize(('n_taps', 'cutoff'), [(33, 0.5), (171, 0.1)])
def test_low_pass(n_taps, cutoff):
    known = firwin(n_taps, cutoff, window=('kaiser', kaiser_beta(70.0)))
    np.testing.assert_allclose(kaiser_low_pass(n_taps, cutoff, 70.0), known, atol=1e-15)


@pytest.mark.parametrize('corner', [1e-3, 1e-2, 0.2])
def test_high_pass_in_stretches_on_top_of_gravity(corner):
    rng = np.random.default_rng(SEED)
    rows = rng.standard_normal((5000, 3)) + 9.81
    sections = butter(4, corner, 'highpass', fs=1.0, output='sos')
    known, _ = sosfilt(sections, rows, axis=0, zi=sosfilt_zi(sections)[:, :, None] * rows[0])
    running = RunningFilter(butterworth_high_pass(4, corner))
    cuts = [0, 1, 40, 1777, 5000]
    parts = [running.filter(rows[a:b]) for a, b in pairwise(cuts)]
    np.testing.assert_allclose(np.concatenate(parts), known, atol=1e-9)
