"""`ama.merge`: set-ups of roving sensors become one result over all points."""

import numpy as np
import pytest
from scipy.signal import lfilter

import autonomous_modal_analysis as ama
from modal_core.errors import SettingsError
from modal_core.numbers.indicators import mac

RATE_HZ, SEED = 100.0, 7310
TRUTH_HZ = (4.0, 9.0)
POINTS = ('ref', 'mast', 'a', 'b', 'c')
SHAPES = np.array([[1.0, 0.7], [0.6, 0.9], [0.8, -0.4], [0.3, 0.2], [-0.2, 0.9]])
FIRST, SECOND = ('ref', 'mast', 'a', 'b'), ('ref', 'mast', 'c')


def moved(seed, points):
    """Return accelerations at some points of one structure under random forces."""
    rng = np.random.default_rng(seed)
    total = np.zeros((12_000, len(points)))
    rows = [POINTS.index(point) for point in points]
    for hz, shape in zip(TRUTH_HZ, SHAPES[rows].T, strict=True):
        root = np.exp(2 * np.pi * hz * (-0.015 + 1j) / RATE_HZ)
        force = rng.normal(size=len(total))
        total += np.outer(lfilter([1.0, -1.0], np.poly([root, root.conj()]).real, force), shape)
    return total + 0.02 * total.std() * rng.normal(size=total.shape)


def identified(points, seed, **settings):
    return ama.identify(moved(seed, points), RATE_HZ, channel_names=points, **settings)


@pytest.fixture(scope='module')
def first():
    return identified(FIRST, SEED)


def elsewhere():
    return ama.identify(moved(SEED + 3, ('a', 'b')), RATE_HZ, channel_names=('x', 'y'))


def test_two_results_become_one_over_all_points(first, tmp_path):
    merged = ama.merge([first, identified(SECOND, SEED + 1)])
    assert merged.channel_names == POINTS
    assert len(merged) == 2, f'seed {SEED}'
    off = np.abs(merged.frequencies_hz - TRUTH_HZ)
    assert (off < 4.0 * merged.frequencies_std_hz).all(), f'seed {SEED}'
    assert (np.diag(mac(merged.shapes, SHAPES)) > 0.99).all(), f'seed {SEED}'
    assert '2 of 2 modes are in all set-ups' in repr(merged)
    assert len(merged.to_dict()['modes']) == 2
    merged.save(tmp_path / 'merged')
    assert (tmp_path / 'merged' / 'report.html').is_file()


def test_a_recording_that_is_given_twice_is_refused(first):
    with pytest.raises(SettingsError, match='the same recording twice'):
        ama.merge([first, identified(SECOND, SEED + 1), first])


def test_noise_alone_is_merged_to_no_modes():
    rng = np.random.default_rng(SEED + 9)
    noise = [ama.identify(rng.normal(size=(6000, 2)), RATE_HZ) for _ in range(2)]
    merged = ama.merge(noise)
    assert not len(merged) and merged.headline() == 'no modes: no set-up shows one'


def test_what_is_to_be_known_of_a_set_up_is_told(first):
    values = moved(SEED + 4, SECOND)
    values[:, 1] = np.clip(values[:, 1], -0.5, 0.5)
    clipped = ama.identify(values, RATE_HZ, channel_names=SECOND)
    (told,) = ama.merge([first, clipped]).identification.remarks
    assert 'mast (signal clipped at the sensor range)' in told, f'seed {SEED + 4}'


def test_a_reference_that_is_dead_in_one_set_up_takes_no_part_there(first):
    """Its noise had stood in the shape, and the set-up's modes beside those of the others."""
    values = moved(SEED + 5, ('ref', 'mast', 'a', 'c'))
    values[:, 0] = 1e-3 * np.random.default_rng(SEED + 6).normal(size=len(values))
    names = 'ref', 'mast', 'a', 'c'
    dead = ama.identify(values, RATE_HZ, channel_names=names)
    merged = ama.merge([first, identified(names, SEED + 7), dead])
    assert merged.set_ups.references == ('mast', 'a'), f'seed {SEED}'
    assert len(merged) == 2 and merged.channel_names == POINTS
    assert (np.diag(mac(merged.shapes, SHAPES)) > 0.99).all(), f'seed {SEED}'
    (told,) = (said for said in merged.identification.remarks if 'takes no part' in said)
    assert told.startswith('array: ref takes no part')


def test_a_mode_that_a_set_up_missed_is_read_out_of_the_samples_it_was_identified_from(first):
    narrow = identified(SECOND, SEED + 2, max_frequency_hz=6.0)
    assert len(narrow) == 1, f'seed {SEED}'
    merged = ama.merge([first, narrow])
    assert merged.set_ups.seen_in[1] == merged.set_ups.read_in[1] == ('array',), f'seed {SEED}'
    assert np.isfinite(merged.shapes).all()
    assert mac(merged.shapes[:, 1], SHAPES[:, 1]).item() > 0.95, f'seed {SEED}'


def test_results_that_were_kept_are_taken_too(first, tmp_path):
    identified(SECOND, SEED + 1).save(tmp_path / 'kept')
    merged = ama.merge([first, tmp_path / 'kept'])
    assert merged.set_ups.names == ('array', 'kept') and merged.channel_names == POINTS


@pytest.mark.parametrize(
    ('given', 'words'),
    [
        (lambda first: [first], 'nothing to merge'),
        (lambda first: [first, elsewhere()], 'share no channel'),
        (lambda first: [first, 'record.npy'], 'not the results of an identification'),
    ],
)
def test_what_cannot_be_merged_says_why(first, given, words):
    with pytest.raises(ama.ModalAnalysisError, match=words):
        ama.merge(given(first))
