"""What of a change with the level is a mode's own: of shares drawn, and of modes of chains."""

import math

import numpy as np
import pytest
from scipy.linalg import eigh

import autonomous_modal_analysis as ama
from autonomous_modal_analysis.compared.mode_courses import mode_courses
from autonomous_modal_analysis.compared.mode_levels import mode_levels
from oma_identifier.compare import compare_modes
from oma_identifier.levels import Law
from oma_identifier.levels.own_share import own_share, Seen


def test_a_share_is_within_its_deviation_and_others_are_seldom_told_where_there_are_none():
    """Of 400 draws of the belief beforehand: half have no others."""
    seed = 79400
    rng = np.random.default_rng(seed)
    off, wrong, alone = [], 0, 0
    for _ in range(400):
        true = 1.0 if rng.random() < 0.5 else rng.random()
        seen = Seen(1.2, -0.1, 0.15)
        noise = np.array([1.0, 0.4, rng.uniform(0.02, 0.5)])
        ratio = seen.gain * true + seen.offset + seen.error * rng.standard_normal()
        within = [(ratio + each * rng.standard_normal(), each) for each in noise]
        found = own_share((1.0, 0.05), within, seen)
        off.append((found.value - true) / max(found.std, 0.01))
        alone += true == 1.0
        wrong += true == 1.0 and found.others_told
    said = f'seed {seed}: {np.mean(np.abs(off) < 2.0):.3f}, {wrong} of {alone}'
    assert np.mean(np.abs(off) < 2.0) > 0.92, said
    assert wrong < 0.1 * alone, said


def test_a_change_that_is_not_told_leaves_what_was_believed():
    found = own_share((0.1, 1.0), [(0.0, 5.0)], Seen(1.0, 0.0, 0.2))
    assert found.value == pytest.approx(0.75, abs=0.02) and not found.others_told


@pytest.mark.slow
@pytest.mark.parametrize('seed', [7833, 7842])
def test_cubic_stiffness_is_the_own_one_of_a_mode_in_a_chain(seed):
    """What other modes add through the same spring had been in it, up to 13 deviations."""
    pytest.importorskip('numba')
    from test.support.cubic_chain import LEVELS, random_chain, RATE_HZ

    chain = random_chain(seed)
    results = [
        ama.identify(chain.accelerations(level, 300.0), sample_rate_hz=RATE_HZ, window_s=300)
        for level in LEVELS
    ]
    changes = [compare_modes(results[0].modes, each.modes) for each in results[1:]]
    _, shapes = eigh(chain.stiffness, np.diag(chain.mass))
    names = [each.name for each in results[0].found.parts[0].channels]
    off, of_all = [], []
    for each in mode_levels(results, mode_courses(results[0].modes, changes)):
        law = each.law
        if law is None or Law.CUBIC not in law.stiffness.laws:
            continue
        at = int(np.argmin(np.abs(chain.frequency_hz - law.mode.frequency_hz)))
        shape = shapes[:, at] / shapes[names.index(each.channel), at]
        stretched = [shape[i] - (shape[j] if j >= 0 else 0.0) for i, j in chain.places]
        own = chain.cubic @ np.array(stretched) ** 4 / (shape**2 @ chain.mass)
        off.append((law.mode.cubic_stiffness - own) / law.cubic_stiffness_std)
        total = law.stiffness.cubic
        of_all.append((total.slope - own) / total.slope_std)
    said = f'seed {seed}: {np.round(off, 1)}, of all modes {np.round(of_all, 1)}'
    print(said)
    assert math.sqrt(np.mean(np.square(off))) < 2.0, said
    assert max(of_all) > 4.0, said
