"""MDF files of the library that measures with them: read as they were written, or refused."""

from pathlib import Path

import numpy as np
import pytest

from modal_core.errors import RecordingError
from modal_core.units import STANDARD_GRAVITY
from modal_recordings import open_recording

asammdf = pytest.importorskip('asammdf')

RATE_HZ, N_SAMPLES, SEED = 100.0, 3000, 20
TIME_S = np.arange(N_SAMPLES) / RATE_HZ
SAMPLES = np.random.default_rng(SEED).standard_normal((N_SAMPLES, 3))
VERSIONS = ('4.10', '4.20', '3.30')


def signal(column, name=None, unit='m/s^2', times=TIME_S, kind=float):
    values = SAMPLES[: len(times), column].astype(kind)
    return asammdf.Signal(values, times, name=name or f'acc_{column}', unit=unit)


def mdf(path: Path, *groups, version='4.10', compression=0) -> Path:
    with asammdf.MDF(version=version) as file:
        for signals in groups or ([signal(column) for column in range(3)],):
            file.append(signals, common_timebase=True)
        return Path(file.save(path, overwrite=True, compression=compression))


def read(path, **options):
    recording = open_recording(path, **options)
    return np.concatenate([block.acceleration for block in recording.measurements()]), recording


@pytest.mark.parametrize('compression', [0, 1, 2])
@pytest.mark.parametrize('version', VERSIONS)
def test_what_is_read_is_what_was_written(version, compression, tmp_path):
    """Plain, and with blocks deflated or transposed and deflated, which MDF 3 does not know."""
    path = mdf(tmp_path / 'a.mf4', version=version, compression=compression)
    # What MDF 3 is called is up to who writes it.
    values, recording = read(path.rename(tmp_path / 'a.mf4'))
    assert np.array_equal(values, SAMPLES)
    assert recording.sample_rate_hz == pytest.approx(RATE_HZ)
    assert recording.channel_names == ('acc_0', 'acc_1', 'acc_2')
    assert recording.units == ('m/s^2',) * 3


def test_whole_numbers_with_a_rule_are_read_as_what_they_mean(tmp_path):
    """Of a converter: the channel states gain and offset, as measuring modules do."""
    raw = np.round(1000.0 * SAMPLES[:, 0]).astype(np.int16)
    rule = {'a': 0.001, 'b': 0.5}
    one = asammdf.Signal(raw, TIME_S, name='acc', unit='g', conversion=rule)
    values, recording = read(mdf(tmp_path / 'a.mf4', [one]))
    assert np.allclose(values[:, 0], STANDARD_GRAVITY * (0.001 * raw + 0.5), rtol=1e-9)
    assert recording.units == ('m/s^2',)


def test_words_beside_the_samples_are_left_out(tmp_path):
    state = asammdf.Signal(np.array([b'runs'] * N_SAMPLES), TIME_S, name='state', encoding='utf-8')
    values, recording = read(mdf(tmp_path / 'a.mf4', [signal(0), state, signal(1)]))
    assert recording.channel_names == ('acc_0', 'acc_1')
    assert np.array_equal(values, SAMPLES[:, :2])


def test_single_precision_is_kept(tmp_path):
    values, _ = read(mdf(tmp_path / 'a.mf4', [signal(n, kind=np.float32) for n in range(3)]))
    assert np.array_equal(values, SAMPLES.astype(np.float32))


def test_groups_of_another_rate_are_asked_about(tmp_path):
    slow = TIME_S[:300] * 10.0
    path = mdf(tmp_path / 'a.mf4', [signal(0), signal(1)], [signal(2, 'temperature', '', slow)])
    with pytest.raises(RecordingError, match=r'--topic 0/acc_0'):
        open_recording(path)
    values, recording = read(path, topics=('0/acc_0', '0/acc_1'))
    assert np.array_equal(values, SAMPLES[:, :2])
    assert recording.sample_rate_hz == pytest.approx(RATE_HZ)


def test_a_unit_that_is_not_stated_is_said_or_assumed_with_a_note(tmp_path):
    path = mdf(tmp_path / 'a.mf4', [signal(0, unit='')])
    values, recording = read(path, unit='g')
    assert np.allclose(values[:, 0], STANDARD_GRAVITY * SAMPLES[:, 0])
    assert recording.units == ('m/s^2',)


@pytest.mark.parametrize('share', [0.999, 0.9, 0.5, 0.1, 0.01, 0.0005])
@pytest.mark.parametrize('version', VERSIONS)
def test_a_file_that_is_cut_off_is_refused_and_not_shortened(version, share, tmp_path):
    path = mdf(tmp_path / 'a.mf4', version=version)
    whole = path.read_bytes()
    cut = tmp_path / 'cut.mf4'
    cut.write_bytes(whole[: max(1, int(share * len(whole)))])
    with pytest.raises(RecordingError) as raised:
        read(cut)
    assert '\n' not in str(raised.value)


def test_a_file_that_was_never_finished_is_called_so(tmp_path):
    path = mdf(tmp_path / 'a.mf4')
    path.write_bytes(b'UnFinMF ' + path.read_bytes()[8:])
    with pytest.raises(RecordingError, match='never finished'):
        open_recording(path)


def test_what_is_no_mdf_file_is_called_so(tmp_path):
    (tmp_path / 'a.mf4').write_bytes(b'hello' * 1000)
    with pytest.raises(RecordingError, match='not an MDF file'):
        open_recording(tmp_path / 'a.mf4')


@pytest.mark.slow
@pytest.mark.parametrize('version', VERSIONS)
def test_damaged_bytes_are_read_or_refused_in_one_line(version, tmp_path):
    """Seed 58: three bytes in the head of the file, in its first blocks, anywhere."""
    whole, rng = mdf(tmp_path / 'a.mf4', version=version).read_bytes(), np.random.default_rng(58)
    path = tmp_path / 'damaged.mf4'
    for number in range(30):
        data = bytearray(whole)
        reach = min(len(data), (300, 3000, len(data))[number % 3])
        for place in rng.integers(reach, size=3):
            data[place] = rng.integers(256)
        path.write_bytes(bytes(data))
        try:
            values, _ = read(path)
        except RecordingError as error:
            assert '\n' not in str(error), (number, error)
        else:
            assert np.isfinite(values).all()
