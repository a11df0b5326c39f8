"""Structures in which finding all modes once took a wrong turn; truth is known."""

import numpy as np
import pytest

from benchmarks.scatter import match
from benchmarks.selection import CASES
from oma_identifier.identify import identify_samples
from oma_identifier.likelihood.band_data import averages_from, band_lines, ReducedBand, StartModes
from oma_identifier.likelihood.band_model import BandData, BandFit, BandModel
from oma_identifier.likelihood.group_fits import GroupFit, whole_shape
from oma_identifier.likelihood.line_spectra import Spectra
from oma_identifier.refinement.label_switching import undo_label_switching

PLAIN, WITH_LINES = 4, 5


@pytest.mark.parametrize(
    ('case', 'seed'),
    [
        pytest.param(PLAIN, 97701, id='a pair whose band needs a second pass'),
        pytest.param(PLAIN, 97708, id='a mode found missing whose band needs a further pass'),
        pytest.param(PLAIN, 99029, id='a broad mode near the end of the spectrum, seen 3 % off'),
        pytest.param(PLAIN, 99058, id='three poles for two modes'),
        pytest.param(PLAIN, 99355, id='a broad pair whose band holds the peak of another mode'),
        pytest.param(PLAIN, 99490, id='a narrow mode in a broad one'),
        pytest.param(WITH_LINES, 99230, id='a pair of which some model orders make one'),
        pytest.param(WITH_LINES, 99304, id='a broad mode found missing beside a narrow one'),
        pytest.param(WITH_LINES, 99344, id='a mode missing where forces of tails are below zero'),
        pytest.param(WITH_LINES, 99383, id='four poles for two modes'),
        pytest.param(WITH_LINES, 99431, id='an image of a line that most model orders have'),
    ],
)
def test_all_modes_are_found_and_no_other(case, seed):
    plant, samples, _ = CASES[case].record(seed)
    modes = list(identify_samples(samples).modes)
    values, left = match(modes, plant)
    missing = plant.frequency_hz[~np.isfinite(values[0, 0])]
    assert len(missing) == 0, f'seed {seed}: {missing}'
    assert not left, f'seed {seed}: {[mode.frequency_hz for mode in left]}'


def test_lines_belong_to_the_mode_that_is_nearest_in_half_widths():
    frequency = np.arange(0.0, 100.0, 0.05)
    spectra = Spectra(200.0, frequency, np.zeros((1, len(frequency)), dtype=np.complex64))
    modes = StartModes(
        np.array([40.0, 50.0]), np.array([0.005, 0.05]), np.ones((1, 2), dtype=complex)
    )
    usable = np.ones(len(frequency), dtype=bool)
    lines = frequency[band_lines(spectra, modes, [1], usable)]
    assert lines[0] < 35.0 and lines[-1] == pytest.approx(70.0)
    # Half-widths are 0.2 and 2.5 Hz: they meet at 39.13 and 40.74 Hz.
    assert not np.any((lines > 39.2) & (lines < 40.7))
    assert np.any((lines > 39.0) & (lines < 39.13)) and np.any((lines > 40.75) & (lines < 40.9))


def test_no_average_reaches_over_lines_that_are_left_out():
    frequency = np.concatenate([np.arange(30.0, 39.0, 0.05), np.arange(41.0, 70.0, 0.05)])
    values = np.where(frequency < 40.0, 1.0, 10.0)[:, None] + 0j
    data = averages_from(frequency, values, np.array([50.0]), np.array([2.5]))
    assert data.n_averaged.sum() == len(frequency)
    assert set(np.round(data.periodogram[:, 0, 0].real, 6)) == {1.0, 100.0}


def test_what_was_projected_out_of_a_shape_follows_its_modes_when_they_turn():
    """Two modes changed their shapes inside: each takes over what belongs to the other."""
    line = np.ones((1, 2, 2), dtype=complex)
    data = BandData(np.ones(1), line, np.ones(1), 0.0, 1.0)
    model = BandModel(
        np.ones(2),
        np.ones(2),
        np.eye(2) + 0j,
        np.eye(2) + 0j,
        np.ones(2),
        2,
        one_noise=False,
        reference_hz=1.0,
    )
    axes = np.eye(5)
    band = ReducedBand(
        data, model, np.ones(5), axes[:, :2], axes[:, 2:4], np.arange(1), included=(0, 1)
    )
    old = np.array([[1.0, 0.0, 0.5, 0.0, 0.0], [0.05, 1.0, 0.0, -0.5, 0.0]]).T + 0j
    new = np.array([0.0, 1.0]) + 0j
    found = whole_shape(band, new, old)
    np.testing.assert_allclose(
        found * np.sqrt(1.25 + 0.025**2), [0.0, 1.0, -0.025, -0.5, 0.0], atol=1e-12
    )


def test_modes_keep_their_names_when_a_fit_changes_their_places():
    start = StartModes(np.array([9.1, 13.7]), np.array([0.03, 0.02]), np.eye(3)[:, :2] + 0j)
    # The second went to the place of one that was missing, the third, added, to the second's.
    now = StartModes(
        np.array([9.0, 9.3, 13.6]),
        np.array([0.03, 0.05, 0.02]),
        np.eye(3)[:, [0, 2, 1]] + 0j,
    )
    model = BandModel(
        now.frequency_hz,
        now.damping_ratio,
        now.shapes,
        np.eye(3) + 0j,
        np.ones(3),
        3,
        one_noise=False,
        reference_hz=10.0,
    )
    fit = BandFit(model, np.ones(3), np.ones(3), np.zeros((3, 3, 4)) + 0j, 1.0, True, 1, 1.0, 0.0)
    moved, (group,) = undo_label_switching(now, [GroupFit([0, 1, 2], None, fit)], start)
    assert group.group == [0, 2, 1]
    np.testing.assert_array_equal(moved.frequency_hz, [9.0, 13.6, 9.3])
    np.testing.assert_array_equal(moved.shapes, np.eye(3)[:, [0, 1, 2]])
    alone, same = undo_label_switching(now, [GroupFit([0, 1, 2])], start)
    assert same[0].group == [0, 1, 2]
    np.testing.assert_array_equal(alone.frequency_hz, now.frequency_hz)
