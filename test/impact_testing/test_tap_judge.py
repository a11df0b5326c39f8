"""Guidance while tapping: the same stream in blocks of any size."""

import numpy as np
import pytest

from impact_testing import Fault, TapJudge
from test.support.hammer_bench import bench, taps

SEED = 45


@pytest.mark.parametrize('block', [7, 64, 1000])
def test_each_tap_is_judged_once_whatever_the_blocks(block):
    rng = np.random.default_rng(SEED)
    times = np.array([0.5, 3.5, 6.5, 9.5, 12.5])
    record = taps(
        bench(), 2, times, rng, noise=0.01, force_noise_n=0.2, second=[(2, 0.08, 0.5)], last_s=2.0
    )
    judge = TapJudge(record.rate_hz, record.responses.channels)
    said = []
    for first in range(0, len(record.force_n), block):
        rows = slice(first, first + block)
        said += judge.feed(record.force_n[rows], record.responses.acceleration[rows])
    assert [each.time_s for each in said] == pytest.approx(times, abs=0.02)
    assert [each.judged.good for each in said] == [True, True, False, True, True]
    assert said[2].words.startswith('again: double hit')
    assert said[-1].words == 'good, 4 so far'


def test_a_hurried_and_a_weak_tap_are_named():
    rng = np.random.default_rng(SEED)
    times = np.array([0.5, 3.5, 6.5, 7.5, 10.5])
    record = taps(bench(), 2, times, rng, noise=0.001, last_s=2.0)
    force = record.force_n.copy()
    force[round(10.3 * 512) :] *= 0.05
    judge = TapJudge(record.rate_hz, record.responses.channels)
    said = [
        each
        for first in range(0, len(force), 128)
        for each in judge.feed(
            force[first : first + 128], record.responses.acceleration[first : first + 128]
        )
    ]
    faults = [{fault for fault, _ in each.judged.faults} for each in said]
    assert faults == [set(), set(), set(), {Fault.TOO_CLOSE}, {Fault.WEAK}]
