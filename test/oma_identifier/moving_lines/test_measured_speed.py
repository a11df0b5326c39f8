"""The spindle's measured speed tells how its orders move."""

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.methods.milled import Cut, DURATION_S, excess_db, Milled, milled
from modal_core.channel import Channel
from modal_core.measurements import SampleBlock
from modal_core.samples import Samples
from modal_core.spindle_speed import SpindleSpeed
from oma_identifier.moving_lines import measured_course, without_moving
from oma_identifier.pipeline import IdentificationPipeline
from oma_identifier.settings import IdentificationSettings

SECOND_NS = 1_000_000_000


def tachometer(cut: Cut, seed: int, noise: float = 1e-3) -> SpindleSpeed:
    """Return ten values a second of 13 turns a second, each off by noise."""
    share = np.linspace(0.0, 1.0, int(10 * DURATION_S) + 1)
    speed = 1.0 + cut.ramp * (share - 0.5) + cut.waver * np.sin(2.0 * np.pi * 3.3 * share)
    speed *= 1.0 + noise * np.random.default_rng(seed).standard_normal(len(share))
    stamps = np.round(share * DURATION_S * SECOND_NS).astype(np.int64)
    return SpindleSpeed.of(stamps, 13.0 * speed)


def with_speed(record: Milled, seed: int) -> Samples:
    return replace(record.samples, speed=tachometer(record.cut, seed))


@pytest.mark.parametrize('seed', range(700_400, 700_403))
def test_orders_of_a_ramp_are_taken_out_to_3_db_of_the_floor(seed):
    record = milled(seed, Cut(speed=seed % 3, ramp=0.1))
    assert min(excess_db(record, record.samples)) > 10.0
    left, lines = without_moving(with_speed(record, seed))
    assert max(excess_db(record, left)) < 3.0, (seed, excess_db(record, left))
    assert all(line.moved == pytest.approx(0.1, abs=0.01) for line in lines)


def test_a_speed_that_does_not_move_or_that_no_line_follows_changes_nothing():
    seed = 700_410
    still = milled(seed, Cut())
    steady = with_speed(still, seed)
    assert measured_course(steady) is None
    assert without_moving(steady)[0] is steady
    # A spindle that turns, but not in these samples.
    quiet = replace(milled(seed, Cut(turns=False)).samples, speed=tachometer(Cut(ramp=0.1), seed))
    assert without_moving(quiet)[0] is quiet


def test_a_speed_counts_where_it_is_known_all_along():
    times = np.arange(0.0, 10.5, 0.5)
    stamps = (times * SECOND_NS).astype(np.int64)
    speed = SpindleSpeed.of(stamps, 10.0 + times)
    np.testing.assert_allclose(speed.at(0, 4.0, 41), 10.0 + np.arange(41) / 4.0)
    assert speed.at(0, 4.0, 53) is None  # three seconds beyond the last value
    gap = SpindleSpeed.of(stamps[(times < 3.0) | (times > 6.0)], times[(times < 3) | (times > 6)])
    assert gap.at(0, 4.0, 41) is None
    assert SpindleSpeed.of(stamps, 0.0 * times).at(0, 4.0, 41) is None  # it stands
    # Values that are no numbers, or come twice, are passed over.
    odd = SpindleSpeed.of(np.array([2, 1, 1, 3]), np.array([2.0, 1.0, 9.0, np.nan]))
    np.testing.assert_array_equal(odd.stamp_ns, [1, 2])
    both = speed.joined(SpindleSpeed.of(stamps + 11 * SECOND_NS, 21.0 + times))
    assert both.at(0, 4.0, 85) is not None
    part = both.between(5 * SECOND_NS, 6 * SECOND_NS)
    assert part.stamp_ns[0] >= 3 * SECOND_NS and part.stamp_ns[-1] <= 8 * SECOND_NS


def test_a_part_of_samples_keeps_its_time():
    samples = Samples(np.arange(20.0)[:, None], 10.0, (Channel('a'),), start_ns=5 * SECOND_NS)
    assert samples.part(slice(10, None)).start_ns == 6 * SECOND_NS
    assert samples.part(slice(-5, None)).start_ns == 5 * SECOND_NS + 3 * SECOND_NS // 2


def test_the_pipeline_gives_each_window_the_speed_of_its_time():
    rng = np.random.default_rng(5)
    pipeline = IdentificationPipeline(IdentificationSettings(window_s=10.0, hop_s=10.0))
    times = np.arange(0.0, 40.0, 0.1)
    stamps = np.round(times * SECOND_NS).astype(np.int64)
    pipeline.add_speed(None)
    pipeline.add_speed(SpindleSpeed.of(stamps[:200], 20.0 + times[:200]))
    pipeline.add_speed(SpindleSpeed.of(stamps[200:], 20.0 + times[200:]))
    rows = rng.standard_normal((3000, 2)).astype(np.float32)
    for first in range(0, 3000, 100):
        part = rows[first : first + 100]
        pipeline.add(SampleBlock('s', first * SECOND_NS // 100, first, 100.0, ('a', 'b'), part))
    windows = [pipeline.begin(window) for window in pipeline.finish()]
    assert len(windows) == 3
    for number, begun in enumerate(windows):
        samples = begun.cleaned.samples
        speed_hz = samples.speed.at(samples.start_ns, samples.sample_rate_hz, 1000)
        np.testing.assert_allclose(speed_hz[[0, -1]], 20.0 + 10.0 * number + np.array([0, 9.99]))
        assert len(samples.speed.stamp_ns) <= 141  # not that of the whole record
