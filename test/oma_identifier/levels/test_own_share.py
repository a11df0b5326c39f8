"""What of a change with the level is a mode's own: of shares drawn, and of modes of chains."""

import math

import numpy as np
import pytest
from scipy.linalg import eigh
from scipy.special import expit

import autonomous_modal_analysis as ama
from autonomous_modal_analysis.compared.mode_courses import mode_courses
from autonomous_modal_analysis.compared.mode_levels import mode_levels
from oma_identifier.compare import compare_modes
from oma_identifier.levels import Law
from oma_identifier.levels.own_share import (
    ODDS_SLOPE,
    ODDS_STD,
    own_share,
    Seen,
    STIFFNESS,
)


def test_a_share_is_within_its_deviation_and_others_are_seldom_told_where_they_have_no_part():
    """Of 400 draws of the belief beforehand."""
    seed = 79400
    rng = np.random.default_rng(seed)
    off, wrong, own = [], 0, 0
    for _ in range(400):
        moves = math.exp(3.0 * rng.standard_normal())
        true = expit(ODDS_SLOPE * math.log(moves) + ODDS_STD * rng.standard_normal())
        seen = Seen(1.2, -0.1, 0.15)
        noise = np.array([1.0, 0.4, rng.uniform(0.02, 0.5)])
        ratio = seen.gain * true + seen.offset + seen.error * rng.standard_normal()
        within = [(ratio + each * rng.standard_normal(), each) for each in noise]
        found = own_share((1.0, 0.05), within, seen, moves)
        off.append((found.value - true) / found.std)
        own += true > 0.95
        wrong += true > 0.95 and found.others_told
    said = f'seed {seed}: {np.mean(np.abs(off) < 2.0):.3f}, {wrong} of {own}'
    print(said)
    assert np.mean(np.abs(off) < 2.0) > 0.92, said
    assert wrong < 0.1 * own, said


def test_a_change_that_is_not_told_leaves_what_motion_tells():
    for moves, expected in ((1.0, 0.5), (math.inf, 1.0)):
        found = own_share((0.1, 1.0), [(0.0, 5.0)], Seen(1.0, 0.0, 0.2), moves)
        assert found.value == pytest.approx(expected, abs=0.02)
        assert not found.others_told


def test_a_mode_that_hardly_moves_is_not_said_to_stiffen_itself():
    """Through a base the first mode moves most, and higher ones come and go with its tones."""
    found = own_share((1.0, 0.05), [(0.7, 0.3)], STIFFNESS, 1e-3)
    assert found.value < 0.2
    assert own_share((1.0, 0.05), [(0.7, 0.3)], STIFFNESS, 1e3).value > 0.95


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
