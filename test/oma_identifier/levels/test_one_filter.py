"""A mode is told from its neighbours alike at all levels, also where one of them was missed."""

from dataclasses import replace

import numpy as np
import pytest

import autonomous_modal_analysis as ama
from autonomous_modal_analysis.compared.mode_courses import mode_courses
from autonomous_modal_analysis.compared.mode_levels import mode_levels
from oma_identifier.compare import compare_modes

RATE_HZ, SEED = 100.0, 7910
SHAPES = np.array([[1.0, 1.0], [0.7, -0.3], [0.4, 0.6], [0.2, 0.9]])


def without_last(result):
    """Return a result in which one mode was missed."""
    said = result.found.identification
    fewer = replace(said, modes=replace(said.modes, modes=said.modes.modes[:-1]))
    return replace(result, found=replace(result.found, identification=fewer))


def stiffnesses(results):
    changes = [compare_modes(results[0].modes, each.modes) for each in results[1:]]
    first = mode_levels(results, mode_courses(results[0].modes, changes))[0]
    return {number: motion.stiffness for number, _, motion in first.points}


def moved(result, share):
    """Return a result in which the first mode was identified elsewhere."""
    said = result.found.identification
    first, *others = said.modes.modes
    elsewhere = replace(first, frequency_hz=first.frequency_hz * (1.0 + share))
    modes = replace(said.modes, modes=(elsewhere, *others))
    return replace(result, found=replace(result.found, identification=replace(said, modes=modes)))


@pytest.fixture(scope='module')
def results(structure):
    made = replace(structure(np.array([10.0, 10.6]), np.full(2, 0.02)), shapes=SHAPES)
    rng = np.random.default_rng(SEED)
    results = []
    for level in (1.0, 2.0, 4.0):
        samples = made.simulate(rng, 240.0, RATE_HZ)
        rows = level * samples.acceleration
        results.append(ama.identify(rows, sample_rate_hz=RATE_HZ, window_s=240))
    assert [len(each.modes) for each in results] == [2, 2, 2], f'seed {SEED}'
    return results


def test_a_mode_whose_band_has_its_motion_elsewhere_has_no_law(results):
    """A half-width and a half from where it was identified, as where others are in the band."""
    off = [moved(each, 0.03) for each in results]
    changes = [compare_modes(off[0].modes, each.modes) for each in off[1:]]
    first = mode_levels(off, mode_courses(off[0].modes, changes))[0]
    assert first.law is None and 'off its frequency' in first.reason, f'seed {SEED}'
    assert np.isnan(first.stiffness.std).all()


def test_a_neighbour_missed_at_one_level_changes_nothing(results):
    whole = stiffnesses(results)
    fewer = without_last(results[0])
    assert len(fewer.modes) == 1
    missed = stiffnesses([fewer, *results[1:]])
    assert missed[0] == pytest.approx(whole[0], rel=1e-3), f'seed {SEED}: {missed}, {whole}'
