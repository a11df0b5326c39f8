"""Several sensors or recorders, of one topic or two; columns in another order; long blocks."""

from dataclasses import replace

import numpy as np
import pytest

from modal_core.measurements import SampleBlock, StampedSamples
from oma_identifier.intake.sample_buffer import SampleBuffer
from oma_identifier.settings import IdentificationSettings

START, RATE_HZ, SEED = 1_700_000_000_000_000_000, 200.0, 7
SETTINGS = IdentificationSettings(window_s=4.0, hop_s=2.0)
NAMES = ('a', 'b', 'c', 'd')


def windows_of(measurements):
    buffer = SampleBuffer(SETTINGS)
    windows = []
    for measurement in measurements:
        buffer.add(measurement)
        windows += buffer.windows()
    return buffer, [*windows, *buffer.finish()]


def blocks(topic='/block', names=NAMES, seed=SEED, n_rows=2400, rows=20):
    values = np.random.default_rng(seed).normal(size=(n_rows, len(names))).astype(np.float32)
    return [
        SampleBlock(
            topic,
            START + round(first / RATE_HZ * 1e9),
            first,
            RATE_HZ,
            names,
            values[first : first + rows],
        )
        for first in range(0, n_rows, rows)
    ]


def imu(frame_id, delay_ns, seed, n_samples=2400):
    stamps = START + delay_ns + np.round(np.arange(n_samples) / RATE_HZ * 1e9).astype(np.int64)
    values = np.random.default_rng(seed).normal(size=(n_samples, 3))
    return [
        StampedSamples('/imu', frame_id, stamps[i : i + 1], values[i : i + 1])
        for i in range(n_samples)
    ]


def check_same(windows, truth):
    assert len(windows) == len(truth) > 3
    for window, true in zip(windows, truth, strict=True):
        assert window.samples.channel_names == true.samples.channel_names
        np.testing.assert_array_equal(window.samples.acceleration, true.samples.acceleration)


@pytest.mark.parametrize('order', [(3, 2, 1, 0), (1, 2, 3, 0), (0, 2, 1, 3)])
@pytest.mark.parametrize('since', [1, 57, 119])
def test_columns_that_change_their_order_keep_their_names(order, since):
    sent = blocks()
    names = tuple(NAMES[place] for place in order)
    turned = [
        replace(block, channel_names=names, acceleration=block.acceleration[:, list(order)])
        if number >= since
        else block
        for number, block in enumerate(sent)
    ]
    buffer, windows = windows_of(turned)
    check_same(windows, windows_of(sent)[1])
    assert buffer.counters.reasons == {}


def test_two_sensors_of_one_topic_are_not_mixed():
    """Samples of two sensors in turn would look like one of twice the rate."""
    first, second = imu('link_3', 0, SEED), imu('link_5', 2_100_000, SEED + 1)
    mixed = [sample for pair in zip(first, second, strict=True) for sample in pair]
    buffer, windows = windows_of(mixed)
    check_same(windows, windows_of(first)[1])
    assert buffer.counters.reasons == {'channel_sent_twice': 1}
    assert 'link_5' in buffer.counters.texts['channel_sent_twice']


def test_a_frame_that_is_damaged_once_costs_that_sample_only():
    sent = imu('link', 0, SEED)
    for at in (0, 1000):
        damaged = [*sent]
        damaged[at] = replace(sent[at], frame_id='lijk')
        buffer, windows = windows_of(damaged)
        assert len(windows) == len(windows_of(sent)[1])
        assert set(buffer.counters.reasons) <= {'stamp_unconfirmed', 'rate_unconfirmed'}


def test_names_that_two_topics_send_are_told():
    sent = blocks()
    buffer, windows = windows_of(
        [block for pair in zip(sent, blocks('/other', seed=8), strict=True) for block in pair]
    )
    check_same(windows, windows_of(sent)[1])
    assert '/other' in buffer.counters.texts['channel_sent_twice']


@pytest.mark.parametrize('rows', [200, 400, 1000, 3000, 12000])
def test_long_blocks_lose_no_samples(rows):
    """Blocks of 1 s to 60 s, which are a record of their own."""
    sent = blocks(rows=rows, n_rows=12000)
    windows = windows_of(sent)[1]
    check_same(windows, windows_of(blocks(n_rows=12000))[1])


@pytest.mark.parametrize('rows', [200, 400, 1000])
def test_two_recorders_of_long_blocks_begin_together(rows):
    """The second is confirmed a block later than the first, of which much is there then."""
    first = blocks(rows=rows, n_rows=12000)
    second = blocks('/other', ('e', 'f'), rows=rows, n_rows=12000)
    pairs = [block for pair in zip(first, second, strict=True) for block in pair]
    for window in windows_of(pairs)[1]:
        assert window.samples.channel_names == (*NAMES, 'e', 'f')
        assert not any(channel.flags for channel in window.quality.channels)
