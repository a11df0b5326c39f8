"""What makes finding all modes hard, one mechanism at a time; truth is known."""

import numpy as np
import pytest

from benchmarks.identifier.plant import Plant, simulate
from benchmarks.identifier.scatter import match
from oma_identifier.identify import identify_samples
from oma_identifier.likelihood.averages import averages_from
from oma_identifier.likelihood.band_model import BandData, BandFit, BandModel
from oma_identifier.likelihood.group_fits import GroupFit, whole_shape
from oma_identifier.likelihood.line_spectra import Spectra
from oma_identifier.likelihood.mode_groups import band_lines, StartModes
from oma_identifier.likelihood.reduced_band import ReducedBand
from oma_identifier.refinement.label_switching import undo_label_switching

SEED = 97_700
N_CHANNELS = 6


def plant(frequency_hz, damping_ratio, force=None, alike=0.0):
    """Return modes under forces of their own; ``alike`` mixes each shape with the next one's."""
    n_modes = len(frequency_hz)
    shapes = np.linalg.qr(np.random.default_rng(SEED).standard_normal((N_CHANNELS, N_CHANNELS)))[0]
    shapes = shapes[:, :n_modes] + alike * np.roll(shapes[:, :n_modes], 1, axis=1)
    return Plant(
        np.array(frequency_hz),
        np.array(damping_ratio),
        shapes / np.linalg.norm(shapes, axis=0),
        np.diag(np.ones(n_modes) if force is None else np.array(force)),
    )


@pytest.mark.parametrize(
    ('structure', 'lines'),
    [
        pytest.param(
            plant((20.0, 20.6, 31.0), (0.02, 0.025, 0.015), alike=0.6),
            (),
            id='a pair that overlaps, of shapes alike',
        ),
        pytest.param(
            plant((20.0, 20.5, 22.5), (0.03, 0.02, 0.03), (1.0, 1.0, 0.15)),
            (),
            id='a strong pair beside a weak mode',
        ),
        pytest.param(
            plant((12.0, 30.0, 95.0), (0.02, 0.015, 0.05)),
            (),
            id='a broad mode near the end of the band',
        ),
        pytest.param(
            plant((24.0, 24.4), (0.03, 0.035)), (), id='two modes that some orders make three'
        ),
        pytest.param(
            plant((29.0, 32.0, 30.6), (0.05, 0.05, 0.004), (1.0, 1.0, 0.3)),
            (),
            id='a broad pair whose band holds the peak of another mode',
        ),
        pytest.param(
            plant((20.0, 20.2), (0.06, 0.004), (1.0, 0.12)), (), id='a narrow mode in a broad one'
        ),
        pytest.param(
            plant((15.0, 60.0, 62.0), (0.03, 0.012, 0.015), (0.4, 1.0, 0.1)),
            (),
            id='a weak mode under the tails of strong ones',
        ),
        pytest.param(
            plant((20.0, 20.35, 40.0), (0.015, 0.02, 0.012)),
            ((30.0, 0.5),),
            id='a pair that some orders make one, and a line',
        ),
        pytest.param(
            plant((40.0, 42.0), (0.004, 0.05), (1.0, 0.8)),
            ((24.0, 0.5), (48.0, 0.25)),
            id='a broad mode beside a narrow one, and a line in its flank',
        ),
        pytest.param(
            plant((23.5, 41.0), (0.02, 0.015)), ((24.0, 0.5), (48.0, 0.25)), id='a line in a mode'
        ),
    ],
)
def test_all_modes_are_found_and_no_other(structure, lines):
    for seed in range(SEED, SEED + 3):
        samples = simulate(structure, np.random.default_rng(seed), 60.0, 256.0, lines=lines)
        values, left = match(list(identify_samples(samples).modes), structure)
        missing = structure.frequency_hz[~np.isfinite(values[0, 0])]
        assert len(missing) == 0, f'seed {seed}: {missing}'
        assert not left, f'seed {seed}: {[mode.frequency_hz for mode in left]}'


def test_lines_belong_to_the_mode_that_is_nearest_in_half_widths():
    frequency = np.arange(0.0, 100.0, 0.05)
    values = np.zeros((1, len(frequency)), dtype=np.complex64)
    spectra = Spectra(200.0, frequency, values, (20.0,), np.zeros(len(frequency), int))
    modes = StartModes(
        np.array([40.0, 50.0]), np.array([0.005, 0.05]), np.ones((2, 2), dtype=complex)
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
    data = BandData(np.ones(1), line, np.ones(1))
    model = BandModel(
        np.ones(2),
        np.ones(2),
        np.eye(2) + 0j,
        np.eye(2) + 0j,
        np.ones(2),
        2,
        reference_hz=1.0,
    )
    axes = np.eye(5)
    band = ReducedBand(
        data, model, np.ones(5), axes[:, :2], axes[:, 2:4], np.arange(1), (0, 1), 0, 1.0
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
