"""Taps are found and judged: what a person at the hammer does wrong."""

import numpy as np
import pytest

from impact_testing import Fault, find_taps, ImpactRecord, judge_taps, PointFrf, PointSpectra
from modal_core.channel import Channel
from modal_core.samples import Samples
from test.support.hammer_bench import bench, taps

SEED = 42
TIMES = 0.5 + 3.0 * np.arange(5)


def faults(record):
    return [{fault for fault, _ in each.faults} for each in judge_taps(record)]


@pytest.mark.parametrize('seed', range(20))
def test_every_healthy_tap_is_found_and_none_is_blamed(seed):
    """Random widths, sizes, times, polarity, noise of the force up to 1 N."""
    rng = np.random.default_rng(seed)
    times = np.cumsum(rng.uniform(1.5, 4.0, 6))
    record = taps(
        bench(),
        int(rng.integers(3)),
        times,
        rng,
        width_s=rng.uniform(0.003, 0.012),
        noise=rng.uniform(0.0, 0.1),
        force_noise_n=rng.uniform(0.0, 1.0),
    )
    polarity = rng.choice([-1.0, 1.0])
    record = ImpactRecord(polarity * record.force_n + 3.0, record.responses, record.hit)
    assert faults(record) == [set()] * 6
    found = [tap.peak / 512.0 for tap in find_taps(record.force_n, 512.0)]
    assert found == pytest.approx(times, abs=0.015)


@pytest.mark.parametrize(('delay_s', 'share'), [(0.02, 0.5), (0.05, 0.1), (0.12, 0.9), (0.2, 0.3)])
def test_a_double_hit_is_named(delay_s, share):
    rng = np.random.default_rng(SEED)
    record = taps(
        bench(), 2, TIMES, rng, noise=0.01, force_noise_n=0.2, second=[(1, delay_s, share)]
    )
    said = faults(record)
    assert said[1] == {Fault.DOUBLE_HIT}
    assert [each for n, each in enumerate(said) if n != 1] == [set()] * 4


def test_clipped_forces_and_responses_are_named_and_coarse_converters_are_not():
    rng = np.random.default_rng(SEED)
    record = taps(bench(), 2, TIMES, rng, width_s=0.02)
    force, motion = record.force_n, record.responses.acceleration
    coarse = ImpactRecord(
        np.round(force / 2.0) * 2.0,
        Samples(np.round(motion / 0.05) * 0.05, 512.0, record.responses.channels),
    )
    assert faults(coarse) == [set()] * 5
    cut = ImpactRecord(np.minimum(force, 0.7 * force.max()), record.responses)
    assert Fault.FORCE_CLIPPED in set.union(*faults(cut))
    # Short pulses have two samples or one at the limit: all that reach it are cut.
    for rate_hz in (512.0, 1024.0):
        short = taps(bench(), 2, TIMES, rng, rate_hz, width_s=0.004)
        limited = np.minimum(short.force_n, 50.0)
        said = faults(ImpactRecord(limited, short.responses))
        assert all(Fault.FORCE_CLIPPED in each for each in said), said
    top = 0.6 * np.abs(motion).max()
    cut = ImpactRecord(
        force, Samples(np.clip(motion, -top, top), 512.0, record.responses.channels)
    )
    assert Fault.RESPONSE_CLIPPED in set.union(*faults(cut))


def test_a_weak_tap_is_named():
    rng = np.random.default_rng(SEED)
    record = taps(bench(), 2, TIMES, rng, noise=0.001)
    force = record.force_n.copy()
    rows = slice(round(3.3 * 512), round(3.7 * 512))
    force[rows] *= 0.05
    said = faults(ImpactRecord(force, record.responses))
    assert said[1] == {Fault.WEAK}


def test_estimators_stand_in_their_order_and_scatter_as_bendat_and_piersol_say():
    """|H1| ≤ |Hv| ≤ |H2|, and the random error of |H1| over 200 sets of four noisy taps."""
    rng, rate_hz, n = np.random.default_rng(SEED), 128.0, 128
    errors, predicted = [], []
    for _ in range(200):
        force = np.zeros(4 * n)
        force[20::n] = 1.0
        force[21::n] = 0.7
        motion = 2.0 * force + 0.02 * rng.standard_normal(4 * n)
        record = ImpactRecord(force, Samples(motion[:, None], rate_hz, (Channel('a'),)))
        frf = PointFrf(PointSpectra.of(record, judge_taps(record), 0.8))
        assert (np.abs(frf.h1) <= np.abs(frf.hv) + 1e-12).all()
        assert (np.abs(frf.hv) <= np.abs(frf.h2) + 1e-12).all()
        errors.append(np.abs(frf.h1[5, 0]) / 2.0 - 1.0)
        predicted.append(frf.random_error[5, 0] ** 2)
    # Four averages leave three degrees of freedom: the formula is short by 3/4.
    assert np.std(errors) == pytest.approx(np.sqrt(np.mean(predicted) * 4.0 / 3.0), rel=0.2)


def test_a_limit_that_several_taps_reach_with_a_sample_each_is_told():
    """Largest responses go with the force: three that are the very same are cut."""
    rng = np.random.default_rng(SEED)
    record = taps(bench(), 2, TIMES, rng, noise=0.01, width_s=0.004)
    motion = record.responses.acceleration.copy()
    tops = [motion[round(time * 512) : round(time * 512) + 128, 2].max() for time in TIMES]
    # Cut just so that three taps lose a sample or two, too few in a row to be a flat top.
    limit = 0.95 * sorted(tops)[-3]
    motion[:, 2] = np.minimum(motion[:, 2], limit)
    said = faults(ImpactRecord(record.force_n, Samples(motion, 512.0, record.responses.channels)))
    assert [Fault.RESPONSE_CLIPPED in each for each in said] == [top >= limit for top in tops]
    assert faults(record) == [set()] * 5
