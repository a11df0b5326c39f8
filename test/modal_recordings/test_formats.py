"""Files of other programs: what is read is what was written; what is damaged is refused."""

from pathlib import Path
import zipfile

import numpy as np
import pytest
import pyuff
from scipy.io import netcdf_file, savemat, wavfile

from modal_core.errors import RecordingError
from modal_core.units import STANDARD_GRAVITY
from modal_recordings import open_recording
from modal_recordings.formats import NamedArray, NamedArrays, table_of

h5py = pytest.importorskip('h5py')
nptdms = pytest.importorskip('nptdms')

RATE_HZ, N_SAMPLES = 100.0, 3000
TIME_S = np.arange(N_SAMPLES) / RATE_HZ
SAMPLES = np.random.default_rng(20).standard_normal((N_SAMPLES, 3))


def function(column: int, binary: bool, **other: object) -> dict[str, object]:
    return {
        **{'type': 58, 'binary': int(binary), 'func_type': 1, 'rsp_node': 12},
        **{'rsp_dir': (1, 2, -3)[column], 'ref_node': 0, 'ref_dir': 0, 'id1': 'run 1'},
        **{'data': SAMPLES[:, column], 'x': TIME_S, 'num_pts': N_SAMPLES},
        **{'abscissa_spacing': 1, 'abscissa_inc': 0.01, 'abscissa_min': 0.0},
        **{'ordinate_spec_data_type': 12, 'ordinate_axis_units_lab': 'NONE'},
        **{'abscissa_spec_data_type': 17, 'orddenom_spec_data_type': 0},
        **other,
    }


UNITS = {
    **{'type': 164, 'units_code': 5, 'units_description': 'mm (milli-newton)', 'temp_mode': 1},
    **{'length': 1000.0, 'force': 1000.0, 'temp': 1.0, 'temp_offset': 273.15},
}


def universal(path: Path, binary: bool = True, **other: object) -> Path:
    sets = [UNITS, *(function(column, binary, **other) for column in range(3))]
    pyuff.UFF(str(path)).write_sets(sets, 'add')
    return path


def matlab(path: Path) -> Path:
    savemat(path, {'run': {'acc': SAMPLES, 'fs': RATE_HZ}, 'note': 'arm 3', 'limits': [1.0, 2.0]})
    return path


def archive(path: Path) -> Path:
    """One array of samples beside a rate, words and what is pickled."""
    words = {'unit': 'm/s^2', 'limits': [1.0, 2.0], 'notes': np.array([None, {}], dtype=object)}
    np.savez_compressed(path, acc=SAMPLES, fs=RATE_HZ, **words)
    return path


def matlab_7_3(path: Path) -> Path:
    """MATLAB's own header of 512 bytes before an HDF5 file whose axes are the other way round."""
    with h5py.File(path, 'w', userblock_size=512) as file:
        file['acc'] = SAMPLES.T
        file['fs'] = np.array([[RATE_HZ]])
    with path.open('r+b') as file:
        file.write(b'MATLAB 7.3 MAT-file'.ljust(512))
    return path


def hdf(path: Path) -> Path:
    with h5py.File(path, 'w') as file:
        file.create_dataset('run/acc', data=SAMPLES).attrs['fs'] = RATE_HZ
    return path


def netcdf(path: Path) -> Path:
    with netcdf_file(path, 'w') as file:
        file.createDimension('time', N_SAMPLES)
        time = file.createVariable('time', 'd', ('time',))
        time[:], time.units = TIME_S, 'seconds since 2024-05-31 12:00:00'
        for column in range(3):
            one = file.createVariable(f'acc_{column}', 'd', ('time',))
            one[:], one.units = SAMPLES[:, column], 'm/s^2'
    return path


def wav(path: Path) -> Path:
    wavfile.write(path, int(RATE_HZ), (SAMPLES / 10.0).astype(np.float32))
    return path


def tdms(path: Path) -> Path:
    said = {'wf_increment': 0.01, 'unit_string': 'm/s^2'}
    with nptdms.TdmsWriter(path) as writer:
        for first in range(0, N_SAMPLES, 1000):
            part = SAMPLES[first : first + 1000].T
            writer.write_segment(
                [
                    nptdms.ChannelObject('arm', f'c{n}', row.copy(), said)
                    for n, row in enumerate(part)
                ]
            )
    return path


WRITERS = {
    'a.uff': universal, 'a.npz': archive, 'a.mat': matlab, 'b.mat': matlab_7_3, 'a.h5': hdf,
    'a.nc': netcdf, 'a.wav': wav, 'a.tdms': tdms,
}  # fmt: skip
OPTIONS = {'a.wav': {'unit': '10 m/s^2'}}


def read(path: Path, **options: object) -> tuple[np.ndarray, object]:
    recording = open_recording(path, **options)
    blocks = [block.acceleration for block in recording.measurements()]
    return np.concatenate(blocks), recording


@pytest.mark.parametrize('name', WRITERS)
def test_what_is_read_is_what_was_written(name, tmp_path):
    values, recording = read(WRITERS[name](tmp_path / name), **OPTIONS.get(name, {}))
    # The universal file says millimetres.
    scale = 1e-3 if name == 'a.uff' else 1.0
    assert np.allclose(values, scale * SAMPLES, rtol=1e-6)
    assert recording.sample_rate_hz == pytest.approx(RATE_HZ)
    assert set(recording.units) == {'m/s^2'}


@pytest.mark.parametrize('share', [0.999, 0.9, 0.5, 0.1, 0.01, 0.0005])
@pytest.mark.parametrize('name', WRITERS)
def test_a_file_that_is_cut_off_is_refused_and_not_shortened(name, share, tmp_path):
    path = WRITERS[name](tmp_path / name)
    whole = path.read_bytes()
    path.write_bytes(whole[: max(1, int(share * len(whole)))])
    with pytest.raises(RecordingError) as raised:
        read(path, **OPTIONS.get(name, {}))
    assert '\n' not in str(raised.value)


@pytest.mark.parametrize('name', WRITERS)
def test_bytes_of_another_kind_are_refused_in_one_line(name, tmp_path):
    path = tmp_path / name
    path.write_bytes(np.random.default_rng(3).bytes(5000))
    with pytest.raises(RecordingError) as raised:
        open_recording(path)
    assert '\n' not in str(raised.value)


@pytest.mark.parametrize('binary', [True, False])
def test_channels_of_a_universal_file_are_called_by_node_and_direction(binary, tmp_path):
    values, recording = read(universal(tmp_path / 'a.unv', binary, ordinate_axis_units_lab='g'))
    assert recording.channel_names == ('12:+X', '12:+Y', '12:-Z')
    assert np.allclose(values, STANDARD_GRAVITY * SAMPLES, rtol=1e-6, atol=1e-9)


def test_kinds_of_data_of_a_universal_file_are_kept_apart(tmp_path):
    """A force is no response, and a velocity is called one."""
    kinds = (12, 11, 13)
    sets = [function(n, True, ordinate_spec_data_type=kind) for n, kind in enumerate(kinds)]
    pyuff.UFF(str(tmp_path / 'a.uff')).write_sets(sets, 'add')
    _, recording = read(tmp_path / 'a.uff')
    assert recording.units == ('m/s^2', 'm/s')
    assert any('12:-Z left out' in note for note in recording.notes)


def test_a_universal_file_of_frequency_responses_has_no_record(tmp_path):
    path = universal(tmp_path / 'a.uff', func_type=4)
    with pytest.raises(RecordingError, match=r'no time response .found frequency response'):
        open_recording(path)


def test_bytes_that_look_like_the_end_of_a_dataset_end_none(tmp_path):
    """Binary data may hold a line of -1; the length that is stated tells where they end."""
    data = np.frombuffer((b'\n    -1\n' * N_SAMPLES)[: 8 * N_SAMPLES])
    path = tmp_path / 'a.uff'
    pyuff.UFF(str(path)).write_sets([function(0, True, data=data)], 'add')
    with pytest.raises(RecordingError, match='cannot be told apart'):
        open_recording(path)


def test_complex_functions_whose_length_is_stated_half_hide_no_record(tmp_path):
    """The library that writes them states 8 bytes for each value of 16."""
    other = function(0, True, func_type=4, data=SAMPLES[:, 0] + 1j * SAMPLES[:, 1])
    path = universal(tmp_path / 'a.uff')
    pyuff.UFF(str(path)).write_sets([other], 'add')
    values, _ = read(path)
    assert np.allclose(values, 1e-3 * SAMPLES)
    whole = path.read_bytes()
    for n_cut in (1, 100, 8 * N_SAMPLES, 12 * N_SAMPLES):
        path.write_bytes(whole[:-n_cut] if n_cut > 1 else whole[:-4])
        with pytest.raises(RecordingError, match='truncated universal file'):
            open_recording(path)


def test_several_matrices_ask_which_one_by_name(tmp_path):
    savemat(tmp_path / 'a.mat', {'bending': SAMPLES, 'torsion': SAMPLES[:, :2], 'fs': RATE_HZ})
    with pytest.raises(RecordingError, match='--topic bending'):
        open_recording(tmp_path / 'a.mat')
    values, _ = read(tmp_path / 'a.mat', topics=('torsion',))
    assert np.array_equal(values, SAMPLES[:, :2])
    with pytest.raises(RecordingError, match=r'no such array .found twist, expected bending'):
        open_recording(tmp_path / 'a.mat', topics=('twist',))


def test_channels_along_the_first_axis_are_known_by_the_time_beside_them(tmp_path):
    savemat(tmp_path / 'a.mat', {'t': TIME_S, 'acc': SAMPLES.T})
    values, recording = read(tmp_path / 'a.mat')
    assert np.array_equal(values, SAMPLES)
    assert recording.sample_rate_hz == pytest.approx(RATE_HZ)


def test_rates_that_contradict_one_another_are_no_rate(tmp_path):
    savemat(tmp_path / 'a.mat', {'acc': SAMPLES, 'fs': 100.0, 'dt': 0.02})
    with pytest.raises(RecordingError, match='fs: 100 Hz, dt: 50 Hz'):
        open_recording(tmp_path / 'a.mat')


def test_a_rate_that_is_nowhere_is_asked_for(tmp_path):
    savemat(tmp_path / 'a.mat', {'acc': SAMPLES})
    with pytest.raises(RecordingError, match='sample_rate_hz'):
        open_recording(tmp_path / 'a.mat')


def test_what_full_scale_of_a_wav_file_is_must_be_said(tmp_path):
    with pytest.raises(RecordingError, match=r"not calibrated.*--unit '50 m/s"):
        open_recording(wav(tmp_path / 'a.wav'))


def test_what_cannot_be_read_for_want_of_full_scale_says_how_much_it_is(tmp_path):
    """24,000 samples at 8 kHz last 3 s."""
    wavfile.write(tmp_path / 'a.wav', 8000, np.ones((24_000, 4), dtype=np.int16))
    with pytest.raises(RecordingError, match='4 channels of 24000 samples at 8000 Hz: 3 s'):
        open_recording(tmp_path / 'a.wav', to_look=True)


@pytest.mark.parametrize('kind', [np.int16, np.int32, np.uint8])
def test_whole_numbers_of_a_wav_file_are_shares_of_full_scale(kind, tmp_path):
    limits = np.iinfo(kind)
    middle = 0 if limits.min else 128
    values = np.array([middle, limits.max, limits.min, middle] * 100, dtype=kind)
    wavfile.write(tmp_path / 'a.wav', 8000, values)
    found, _ = read(tmp_path / 'a.wav', unit='2 g')
    assert np.allclose(found[:4, 0], 2.0 * STANDARD_GRAVITY * np.array([0, 1, -1, 0]), rtol=0.01)


def test_an_archive_that_claims_more_than_it_holds_is_refused(tmp_path):
    header = np.lib.format.header_data_from_array_1_0(SAMPLES) | {'shape': (10**15, 3)}
    with zipfile.ZipFile(tmp_path / 'a.npz', 'w') as file, file.open('acc.npy', 'w') as member:
        np.lib.format.write_array_header_1_0(member, header)
        member.write(b'\0' * 1000)
    with pytest.raises(RecordingError, match=r'a.npz.*acc.npy ends early'):
        open_recording(tmp_path / 'a.npz')


def test_channels_of_another_length_are_asked_about(tmp_path):
    with nptdms.TdmsWriter(tmp_path / 'a.tdms') as writer:
        fast = nptdms.ChannelObject('a', 'fast', SAMPLES[:, 0], {'wf_increment': 0.01})
        slow = nptdms.ChannelObject('a', 'slow', SAMPLES[:300, 1], {'wf_increment': 0.1})
        writer.write_segment([fast, slow])
    with pytest.raises(RecordingError, match=r'several arrays.*--topic a/fast'):
        open_recording(tmp_path / 'a.tdms')
    values, recording = read(tmp_path / 'a.tdms', topics=('a/slow',))
    assert np.array_equal(values[:, 0], SAMPLES[:300, 1])
    assert recording.sample_rate_hz == pytest.approx(10.0)


def test_a_channel_shorter_than_the_others_is_named(tmp_path):
    with nptdms.TdmsWriter(tmp_path / 'a.tdms') as writer:
        names, lengths = 'abc', (N_SAMPLES, N_SAMPLES - 500, N_SAMPLES)
        writer.write_segment(
            [
                nptdms.ChannelObject('g', name, SAMPLES[:n, 0], {'wf_increment': 0.01})
                for name, n in zip(names, lengths, strict=True)
            ]
        )
    expected = r'different lengths .found g/b 2500, expected 3000 samples.*topics: g/a, g/c'
    with pytest.raises(RecordingError, match=expected):
        open_recording(tmp_path / 'a.tdms')
    values, _ = read(tmp_path / 'a.tdms', topics=('g/a', 'g/c'))
    assert values.shape == (N_SAMPLES, 2)


def test_a_dataset_is_read_in_pieces(tmp_path):
    with h5py.File(tmp_path / 'a.h5', 'w') as file:
        large = file.create_dataset('acc', shape=(900_000, 3), dtype='f4')
        large[123_456] = [1.0, 2.0, 3.0]
        large.attrs['fs'] = 1000.0
    recording = open_recording(tmp_path / 'a.h5')
    rows = np.concatenate([block.acceleration for block in recording.measurements()])
    assert rows[123_456].tolist() == [1.0, 2.0, 3.0]


@pytest.mark.parametrize('name', WRITERS)
def test_damaged_bytes_are_read_or_refused_in_one_line(name, tmp_path):
    """Seed 58: the header of every format, and all of the file."""
    path, rng = WRITERS[name](tmp_path / name), np.random.default_rng(58)
    whole = path.read_bytes()
    for number in range(60):
        data = bytearray(whole)
        for place in rng.integers(min(len(data), (300, 3000, len(data))[number % 3]), size=3):
            data[place] = rng.integers(256)
        path.write_bytes(data)
        try:
            read(path, **OPTIONS.get(name, {}))
        except RecordingError as error:
            assert str(error).isprintable(), f'number {number}'


def test_compressed_data_that_are_damaged_are_refused(tmp_path):
    path = tmp_path / 'a.h5'
    with h5py.File(path, 'w') as file:
        large = file.create_dataset('acc', data=SAMPLES, chunks=(500, 3), compression='gzip')
        large.attrs['fs'] = RATE_HZ
        place = large.id.get_chunk_info(4)
    with path.open('r+b') as file:
        file.seek(place.byte_offset + place.size // 2)
        file.write(bytes(64))
    with pytest.raises(RecordingError, match=r'a.h5: rows from 1: damaged data'):
        open_recording(path)


@pytest.mark.parametrize('kind', ['classic', 'netcdf4'])
def test_packed_numbers_are_unpacked_as_the_cf_conventions_say(tmp_path, kind):
    path, stored = tmp_path / 'a.nc', np.round(SAMPLES[:, 0] * 1000.0).astype(np.int16)
    said = {'scale_factor': 1e-3, 'add_offset': 0.5, '_FillValue': np.int16(-32768)}
    if kind == 'classic':
        with netcdf_file(path, 'w') as file:
            file.fs = RATE_HZ
            file.createDimension('time', N_SAMPLES)
            one = file.createVariable('acc', 'h', ('time',))
            one[:], one.units = stored, 'm s-2'
            for name, value in said.items():
                setattr(one, name, value)
    else:
        with h5py.File(path, 'w') as file:
            file.attrs['fs'] = RATE_HZ
            one = file.create_dataset('acc', data=stored)
            one.attrs.update({'units': 'm s-2', **said})
            # What NetCDF 4 makes of a dimension that nobody gave values.
            file['time'] = np.zeros(N_SAMPLES, np.float32)
            file['time'].attrs['NAME'] = np.bytes_(
                'This is a netCDF dimension but not a netCDF variable.      3000'
            )
    values, recording = read(path)
    assert np.allclose(values[:, 0], stored / 1000.0 + 0.5) and values.shape == (N_SAMPLES, 1)
    assert recording.sample_rate_hz == RATE_HZ


def test_what_was_never_measured_is_no_number(tmp_path):
    with h5py.File(tmp_path / 'a.nc', 'w') as file:
        values = SAMPLES[:, 0].astype(np.float32)
        values[70] = 9.969209968386869e36
        file['acc'] = values
        file['acc'].attrs['fs'] = RATE_HZ
    notes = open_recording(tmp_path / 'a.nc').notes
    assert 'values that are no numbers, taken as lost: 1 of acc' in notes


def test_the_newest_classic_netcdf_is_called_so(tmp_path):
    (tmp_path / 'a.nc').write_bytes(b'CDF\x05' + bytes(100))
    with pytest.raises(RecordingError, match='nccopy -k nc4'):
        open_recording(tmp_path / 'a.nc')


def group(name, columns, **said):
    return [
        nptdms.ChannelObject(name, f'ai{n}', SAMPLES[:, n].copy(), {'wf_increment': 0.01, **said})
        for n in columns
    ]


def at(second):
    return {'wf_start_time': np.datetime64('2026-03-04T10:00:00') + np.timedelta64(second, 's')}


def test_runs_of_one_file_are_not_channels_of_one_recording(tmp_path):
    """The same names in two groups, and no start: at once, or one after the other?"""
    with nptdms.TdmsWriter(tmp_path / 'a.tdms') as writer:
        writer.write_segment([*group('run 1', (0, 1)), *group('run 2', (0, 1))])
    with pytest.raises(RecordingError, match=r'one recording or several.*run 1/ai0, run 2/ai0'):
        open_recording(tmp_path / 'a.tdms')
    values, _ = read(tmp_path / 'a.tdms', topics=('run 2/ai0', 'run 2/ai1'))
    assert np.array_equal(values, SAMPLES[:, :2])
    with nptdms.TdmsWriter(tmp_path / 'b.tdms') as writer:
        writer.write_segment([*group('a', (0,), **at(0)), *group('b', (0, 1), **at(0))])
    assert read(tmp_path / 'b.tdms')[1].channel_names == ('a/ai0', 'b/ai0', 'b/ai1')
    with nptdms.TdmsWriter(tmp_path / 'c.tdms') as writer:
        writer.write_segment([*group('a', (0,), **at(0)), *group('b', (1,), **at(20))])
    with pytest.raises(RecordingError, match=r'begin at different times .found up to 20 s apart'):
        open_recording(tmp_path / 'c.tdms')


def test_one_node_measured_twice_is_not_two_channels(tmp_path):
    sets = [function(n, True) for n in (0, 1, 0, 1)]
    pyuff.UFF(str(tmp_path / 'a.uff')).write_sets(sets, 'add')
    with pytest.raises(RecordingError, match=r'one recording or several.*1/12:\+X, 2/12:\+X'):
        open_recording(tmp_path / 'a.uff')
    _, recording = read(tmp_path / 'a.uff', topics=('2/12:+X', '2/12:+Y'))
    assert recording.channel_names == ('12:+X', '12:+Y')


def test_times_of_few_digits_do_not_bend_the_rate(tmp_path):
    """Uneven spacing of dataset 58 prints times of six digits: steps of 1.95 or 1.96 ms."""
    rate_hz = 512.0
    other = {'x': np.arange(N_SAMPLES) / rate_hz, 'abscissa_spacing': 0}
    _, recording = read(universal(tmp_path / 'a.uff', False, **other))
    assert recording.sample_rate_hz == pytest.approx(rate_hz, rel=2e-6)


def test_times_of_day_of_a_tdms_file_are_its_times(tmp_path):
    stamps = np.datetime64('2026-03-04T10:00:00') + (TIME_S * 1e6).astype('timedelta64[us]')
    channels = [nptdms.ChannelObject('a', 'Time', stamps, {}), *group('a', (0, 1))]
    for channel in channels[1:]:
        del channel.properties['wf_increment']
    with nptdms.TdmsWriter(tmp_path / 'a.tdms') as writer:
        writer.write_segment(channels)
    values, recording = read(tmp_path / 'a.tdms')
    assert recording.channel_names == ('ai0', 'ai1') and np.array_equal(values, SAMPLES[:, :2])
    assert recording.sample_rate_hz == pytest.approx(RATE_HZ, rel=1e-6)


def test_one_clock_written_with_every_channel_is_one_clock(tmp_path):
    with h5py.File(tmp_path / 'a.h5', 'w') as file:
        for number in range(3):
            file[f'{number}/acc_{number}'] = SAMPLES[:, number]
            file[f'{number}/time'] = TIME_S
            file[f'{number}/time'].attrs['unit'] = 's'
    values, recording = read(tmp_path / 'a.h5')
    assert recording.channel_names == ('acc_0', 'acc_1', 'acc_2')
    assert np.array_equal(values, SAMPLES)


G = STANDARD_GRAVITY


def test_a_unit_in_the_same_structure_is_that_of_its_arrays(tmp_path):
    """Nearest one first; a time beside them has a unit of its own."""
    run = {'acc': SAMPLES, 'time': TIME_S, 'unit': 'g'}
    savemat(tmp_path / 'a.mat', {'run': run, 'unit': 'mm/s^2'})
    values, recording = read(tmp_path / 'a.mat')
    assert np.allclose(values, G * SAMPLES)
    assert not any('no unit' in note for note in recording.notes)
    # As Testlab writes it.
    signal = {
        'x_values': {'start_value': 0.0, 'increment': 0.01},
        'y_values': {'values': SAMPLES, 'quantity': {'label': 'g'}},
    }
    savemat(tmp_path / 'b.mat', {'Signal_0': signal})
    values, recording = read(tmp_path / 'b.mat')
    assert np.allclose(values, G * SAMPLES)
    assert recording.sample_rate_hz == pytest.approx(RATE_HZ)
    savemat(tmp_path / 'c.mat', {'acc': SAMPLES, 'fs': RATE_HZ, 'unit': 'furlong'})
    with pytest.raises(RecordingError, match=r'unknown unit .found furlong'):
        open_recording(tmp_path / 'c.mat')


def test_text_of_matlab_7_3_is_no_array(tmp_path):
    with h5py.File(tmp_path / 'a.mat', 'w', userblock_size=512) as file:
        file['run/acc'], file['run/fs'] = SAMPLES.T, np.array([[RATE_HZ]])
        for name, text in (('unit', 'g'), ('note', 'arm 3 after the new gear was mounted')):
            file[f'run/{name}'] = np.array([[ord(letter)] for letter in text], np.uint16)
            file[f'run/{name}'].attrs['MATLAB_class'] = np.bytes_('char')
    with (tmp_path / 'a.mat').open('r+b') as file:
        file.write(b'MATLAB 7.3 MAT-file'.ljust(512))
    values, _ = read(tmp_path / 'a.mat')
    assert np.allclose(values, G * SAMPLES)


def test_what_a_group_states_holds_for_its_arrays(tmp_path):
    with h5py.File(tmp_path / 'a.h5', 'w') as file:
        for name, rate_hz in (('slow', 50.0), ('fast', RATE_HZ)):
            group = file.create_group(name)
            group.attrs['fs'], group.attrs['unit'] = rate_hz, 'g'
            group['x'], group['y'] = SAMPLES[:, 0], SAMPLES[:, 1]
    values, recording = read(tmp_path / 'a.h5', topics=('fast/x', 'fast/y'))
    assert np.allclose(values, G * SAMPLES[:, :2]) and recording.sample_rate_hz == RATE_HZ


def test_columns_have_the_names_and_units_that_are_listed(tmp_path):
    with h5py.File(tmp_path / 'a.h5', 'w') as file:
        file['acc'] = SAMPLES
        said = {'fs': RATE_HZ, 'channel_names': ['x', 'y', 'z'], 'units': ['g', 'm/s^2', 'mm/s']}
        file['acc'].attrs.update(said)
    values, recording = read(tmp_path / 'a.h5')
    assert recording.channel_names == ('x', 'y', 'z')
    assert np.allclose(values, SAMPLES * (G, 1.0, 1e-3))
    assert recording.units == ('m/s^2', 'm/s^2', 'm/s')


def test_a_table_of_records_is_read_column_by_column(tmp_path):
    names = ('time', 'x', 'y')
    with h5py.File(tmp_path / 'a.h5', 'w') as file:
        columns = [TIME_S, SAMPLES[:, 0], SAMPLES[:, 1]]
        file['run/table'] = np.rec.fromarrays(columns, names=names)
    values, recording = read(tmp_path / 'a.h5')
    assert recording.channel_names == ('x', 'y') and np.array_equal(values, SAMPLES[:, :2])


def test_arrays_of_one_name_are_no_more_than_that(tmp_path):
    """A channel called as the times are: known apart by what it is, not by its numbers."""
    table = table_of(
        tmp_path / 'a.h5',
        NamedArrays((
            NamedArray('X_Value', TIME_S, unit='s'),
            NamedArray('X_Value', SAMPLES[:, 0], unit='g', headings=('X_Value',)),
        )),
    )  # fmt: skip
    assert table.units == ('s', 'g')


def test_a_dot_parts_names_of_matlab_structures_alone(tmp_path):
    named = {'elbow.x': SAMPLES[:, 0], 'wrist.x': SAMPLES[:, 1]}
    np.savez(tmp_path / 'a.npz', fs=RATE_HZ, **named)
    assert open_recording(tmp_path / 'a.npz').channel_names == ('elbow.x', 'wrist.x')
    savemat(tmp_path / 'a.mat', {'fs': RATE_HZ, 'run': {'x': SAMPLES[:, 0], 'y': SAMPLES[:, 1]}})
    assert open_recording(tmp_path / 'a.mat').channel_names == ('x', 'y')
