"""Hum of the mains on the hammer and the sensors is no mode, and nothing else is taken for it."""

from dataclasses import replace
from functools import lru_cache

import numpy as np
import pytest
from scipy.signal import lfilter

from impact_testing import Fault, impact_modes
from impact_testing.checks import remarks_on_lines
from impact_testing.steady_lines import Cleared, without_steady_lines
from impact_testing.taps import judge_taps
from test.support.hammer_bench import bench, even_chain, taps

SEED, NOISE = 900_700, 0.02


@lru_cache
def without_noise(begin_s):
    rng = np.random.default_rng(SEED)
    return taps(bench(), 0, begin_s + 3.5 * np.arange(5), rng)


def a_record(seed, begin_s=1.0):
    rng, record = np.random.default_rng(seed), without_noise(begin_s)
    rows = record.responses.acceleration
    rows = rows + NOISE * rng.standard_normal(rows.shape)
    force_n = record.force_n + 0.02 * rng.standard_normal(len(rows))
    return replace(record, force_n=force_n, responses=replace(record.responses, acceleration=rows))


def humming(record, rng, share=0.02, at_hz=50.0):
    """Add a line of wandering frequency and two multiples, of other size in every channel."""
    time_s = np.arange(len(record.force_n)) / record.rate_hz
    turns = at_hz * time_s + 0.02 * np.sin(2.0 * np.pi * time_s / 11.0 + rng.uniform(0.0, 6.0))
    columns = np.column_stack([record.force_n, record.responses.acceleration])
    size = np.abs(columns).max(axis=0)
    for order in (1, 2, 3):
        angle = 2.0 * np.pi * order * turns[:, None] + rng.uniform(0.0, 6.28, len(size))
        columns = columns + share * size * rng.uniform(0.2, 1.0, len(size)) * np.cos(angle)
    samples = replace(record.responses, acceleration=columns[:, 1:])
    return replace(record, force_n=columns[:, 0], responses=samples)


@pytest.mark.parametrize('at_hz', [50.0, 24.4])
def test_lines_are_taken_out_to_a_small_part_of_the_noise(at_hz):
    """The wander is 11 mHz; 24.4 Hz lies among the modes."""
    for seed in range(SEED, SEED + 3):
        record = a_record(seed)
        found = without_steady_lines(humming(record, np.random.default_rng(seed), at_hz=at_hz))
        cleared = found.record
        np.testing.assert_allclose(found.taken_hz, at_hz * np.arange(1, 4), rtol=1e-3)
        wrong = cleared.responses.acceleration - record.responses.acceleration
        assert np.sqrt(np.mean(wrong**2)) < 0.3 * NOISE
        assert np.sqrt(np.mean((cleared.force_n - record.force_n) ** 2)) < 0.02


@lru_cache
def ringing():
    """Return taps on three masses whose modes of 14, 40 and 57 Hz never come to rest."""
    structure = even_chain(3, damping=0.0015)
    rng = np.random.default_rng(SEED + 1)
    return taps(structure, 0, 1.0 + 3.5 * np.arange(4), rng), structure.modes()[0]


def test_a_line_within_ringing_is_taken_out_or_left_and_never_made_larger():
    """Four lines per mode, within its half-width; it had been up to 16 times the noise."""
    record, poles = ringing()
    rows = record.responses.acceleration
    for seed in range(SEED + 70, SEED + 74):
        rng = np.random.default_rng(seed)
        noisy = rows + NOISE * rng.standard_normal(rows.shape)
        clean = replace(
            record,
            force_n=record.force_n + 0.02 * rng.standard_normal(len(rows)),
            responses=replace(record.responses, acceleration=noisy),
        )
        for pole in poles:
            at_hz = (abs(pole) + rng.uniform(-1.0, 1.0) * abs(pole.real)) / (2.0 * np.pi)
            with_line = humming(clean, rng, share=0.004, at_hz=at_hz)
            found = without_steady_lines(with_line)
            was = np.std(with_line.responses.acceleration - noisy, axis=0)
            left = np.std(found.record.responses.acceleration - noisy, axis=0)
            said = f'seed {seed}, {at_hz:.2f} Hz: {left / NOISE} of {was / NOISE}, {found.left_hz}'
            assert (left < 1.05 * was + 0.1 * NOISE).all(), said
            assert found.left_hz or (left < 0.7 * was).all(), said


def test_a_hum_that_hides_the_taps_is_taken_out():
    record = a_record(SEED + 75)
    force_n = record.force_n.copy()
    time_s = np.arange(len(force_n)) / record.rate_hz
    size = 0.25 * force_n.max()
    hidden = replace(record, force_n=force_n + size * np.cos(2.0 * np.pi * 50.0 * time_s))
    found = without_steady_lines(hidden)
    np.testing.assert_allclose(found.taken_hz, [50.0], rtol=1e-3)
    assert np.std(found.record.force_n - force_n) < 1e-3 * size
    assert len(judge_taps(found.record)) == len(judge_taps(record))


def test_lines_that_are_left_in_are_told():
    record = a_record(SEED + 76)
    soon, left = (
        Cleared(record, too_soon_hz=(50.0,)),
        Cleared(record, left_hz=(18.0, 36.2)),
    )
    said = remarks_on_lines([soon, left])
    assert [each.split(' Hz ')[0] for each in said] == ['at 18, 36.2', 'at 50']
    assert 'left in' in said[0] and 'half a second of rest' in said[1]


def test_modes_are_those_of_the_record_without_hum():
    record = a_record(SEED + 10)
    clean = impact_modes([record])
    found = impact_modes([humming(record, np.random.default_rng(SEED + 10))])
    assert len(found.scaled_modes) == len(clean.scaled_modes) == 3
    for one, other in zip(found.scaled_modes, clean.scaled_modes, strict=True):
        off_hz = abs(one.mode.frequency_hz - other.mode.frequency_hz)
        assert off_hz < other.mode.frequency_std_hz
        assert one.modal_mass_kg == pytest.approx(other.modal_mass_kg, rel=5e-3)
    assert 'at 50, 100, 150 Hz taps on m1 hums without a tap' in found.remarks[0]


def test_a_record_without_a_line_stays_as_it_is():
    for seed in range(SEED + 20, SEED + 40):
        record = a_record(seed)
        assert without_steady_lines(record) == Cleared(record)


def test_a_mode_that_the_floor_shakes_is_no_line():
    """Damped by 0.3 to 2 %, far above the noise; of twenty one at most is taken for a line."""
    taken = 0
    for seed in range(SEED + 40, SEED + 60):
        rng, record = np.random.default_rng(seed), a_record(seed)
        at, damping = 2.0 * np.pi * rng.uniform(10.0, 100.0), rng.uniform(0.003, 0.02)
        pole = np.exp(at * complex(-damping, 1.0) / record.rate_hz)
        forces = rng.standard_normal(len(record.force_n) + 5000)
        moved = lfilter([1.0], [1.0, -2.0 * pole.real, abs(pole) ** 2], forces)[5000:]
        shape = rng.normal(size=3) * 5.0 * NOISE / moved.std()
        rows = record.responses.acceleration + np.outer(moved, shape)
        shaken = replace(record, responses=replace(record.responses, acceleration=rows))
        taken += without_steady_lines(shaken).record is not shaken
    assert taken <= 1


def test_without_rest_before_the_first_tap_nothing_is_taken_out():
    record = humming(a_record(SEED + 60, begin_s=0.3), np.random.default_rng(SEED))
    found = without_steady_lines(record)
    (told_hz,) = found.too_soon_hz
    assert found.record is record
    assert told_hz == pytest.approx(50.0 * round(told_hz / 50.0), rel=0.01)


def test_clipped_responses_are_told_under_hum():
    record = humming(a_record(SEED + 61), np.random.default_rng(SEED))
    rows = record.responses.acceleration
    limit = 0.7 * np.abs(rows[:, 0]).max()
    rows[:, 0] = np.clip(rows[:, 0], -limit, limit)
    cleared = without_steady_lines(record).record
    assert any(tap.has(Fault.RESPONSE_CLIPPED) for tap in judge_taps(cleared, record))
