"""A digital output in a recording marks the motion; the recording is cut to it."""

import numpy as np
import pytest

from modal_core.errors import RecordingError
from modal_core.measurements import JointSamples, SampleBlock
from modal_recordings import open_recording, RecordingWriter
from modal_recordings.messages import encode

RATE_HZ, SECOND_NS = 500.0, 1_000_000_000
SEED = 20


def count_of(row):
    """Return a value that no other row has, and that looks like no counter."""
    return np.round(np.sin(1.3 * row), 6)


def table(begin, end, n_samples=5000, noise=0.02, low=0.1, high=23.7):
    """Return two responses that count rows, and a mark with noise and a few slow edges."""
    rng = np.random.default_rng(SEED)
    rows = np.arange(n_samples)
    mark = np.where((rows >= begin) & (rows <= end), high, low)
    mark += noise * (high - low) * rng.normal(size=n_samples)
    return np.column_stack([count_of(rows), 1.0 + np.sin(rows), mark])


def write_csv(path, values, heading='doAmaRun [V]'):
    np.savetxt(path, values, '%.9g', ',', header=f'tip [m/s^2],mid [m/s^2],{heading}', comments='')
    return path


@pytest.mark.parametrize('heading', ['doAmaRun [V]', 'doAmaRun', 'doAmaRun [m/s^2]'])
@pytest.mark.parametrize('noise', [0.0, 0.02, 0.05])
def test_a_table_is_cut_to_its_mark(tmp_path, heading, noise):
    path = write_csv(tmp_path / 'log.csv', table(1000, 3999, noise=noise), heading)
    recording = open_recording(path, sample_rate_hz=RATE_HZ, mark='doAmaRun')
    blocks = list(recording.measurements())
    rows = np.concatenate([block.acceleration[:, 0] for block in blocks])
    np.testing.assert_allclose(rows, count_of(np.arange(1000, 4000)), atol=1e-6)
    assert recording.info().channels == ('tip', 'mid')
    assert any('rows 1001 to 4000 of 5000' in note for note in recording.info().notes)


def test_a_mark_that_is_pulled_down_is_told_by_its_levels_too(tmp_path):
    path = write_csv(tmp_path / 'log.csv', table(100, 4000, low=-5.0, high=0.0))
    recording = open_recording(path, sample_rate_hz=RATE_HZ, mark='doAmaRun')
    first = next(iter(recording.measurements()))
    assert first.acceleration[0, 0] == pytest.approx(count_of(100))


def edges(*pairs):
    values = table(0, -1)
    for begin, end in pairs:
        values[begin : end + 1, 2] += 23.6
    return values


WRONG = {
    'noise alone': (lambda: table(0, -1), 'two levels'),
    'a tone': (lambda: np.column_stack([table(0, -1)[:, :2], np.sin(np.arange(5000) / 9)]),
               'two levels'),
    'nothing': (lambda: np.column_stack([table(0, -1)[:, :2], np.zeros(5000)]), 'never changes'),
    'twice': (lambda: edges((500, 900), (2000, 3000)), '2 times'),
}  # fmt: skip


@pytest.mark.parametrize('case', WRONG)
def test_what_is_no_mark_is_refused_in_one_line(tmp_path, case):
    make, words = WRONG[case]
    path = write_csv(tmp_path / 'log.csv', make())
    with pytest.raises(RecordingError, match=words) as caught:
        open_recording(path, sample_rate_hz=RATE_HZ, mark='doAmaRun')
    assert len(str(caught.value).splitlines()) == 1


def test_a_column_that_is_not_there_is_named(tmp_path):
    path = write_csv(tmp_path / 'log.csv', table(100, 200))
    with pytest.raises(RecordingError, match='doAmaRun'):
        open_recording(path, sample_rate_hz=RATE_HZ, mark='doOther')


def test_messages_are_cut_to_the_mark_of_their_own_clock(tmp_path):
    path, values = tmp_path / 'cell.mcap', table(1000, 3999)
    start_ns, size = 5 * SECOND_NS, 128
    with RecordingWriter(path) as writer:
        for first in range(0, len(values), size):
            part = values[first : first + size].astype(np.float32)
            stamp_ns = start_ns + round(first * SECOND_NS / RATE_HZ)
            block = SampleBlock('daq', stamp_ns, first, RATE_HZ, ('tip', 'mid', 'doAmaRun'), part)
            times = stamp_ns + np.arange(4) * 4_000_000
            joints = JointSamples(
                times, ('j1',), np.full((4, 1), float(first)), np.zeros((4, 1)), np.zeros((4, 1))
            )
            for topic, item in (('daq', block), ('joint_states', joints)):
                for message in encode(item, topic):
                    writer.write(
                        message.topic, message.message_type, message.log_time_ns, message.data
                    )
    recording = open_recording(path, mark='doAmaRun')
    for _ in range(2):
        found = list(recording.measurements())
        blocks = [item for item in found if isinstance(item, SampleBlock)]
        rows = np.concatenate([block.acceleration[:, 0] for block in blocks])
        np.testing.assert_allclose(rows, count_of(np.arange(1000, 4000)), atol=1e-6)
        assert blocks[0].stamp_ns == start_ns + 2 * SECOND_NS
        assert blocks[0].first_index == 1000
        assert {block.channel_names for block in blocks} == {('tip', 'mid')}
        stamps = np.concatenate([i.stamp_ns for i in found if isinstance(i, JointSamples)])
        assert stamps.min() >= start_ns + 2 * SECOND_NS
        assert stamps.max() <= start_ns + 8 * SECOND_NS
    assert recording.info().channels == ('tip', 'mid')
