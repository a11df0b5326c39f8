"""Text files as data loggers and spreadsheets write them: read as stated, or refused."""

import numpy as np
import pytest

from modal_core.errors import RecordingError
from modal_core.measurements import SampleBlock
from modal_recordings.convert import to_mcap
from modal_recordings.open_recording import open_recording

SEED = 1308
N_ROWS, RATE_HZ = 300, 250.0
G = 9.80665
VALUES = np.round(np.random.default_rng(SEED).normal(size=(N_ROWS, 2)), 4)
TIMES_S = np.arange(N_ROWS) / RATE_HZ


def table(first=None, separator=',', decimal='.', above='', end='\n', after=''):
    """Return text of two columns, after a first one of the strings given."""
    rows = [[f'{v:.4f}'.replace('.', decimal) for v in row] for row in VALUES]
    if first is not None:
        rows = [[cell, *row] for cell, row in zip(first, rows, strict=True)]
    return above + ''.join(separator.join(row) + after + end for row in rows)


def seconds(factor=1.0, decimals=4, mark='.'):
    return [f'{factor * t:.{decimals}f}'.replace('.', mark) for t in TIMES_S]


def quoted(text):
    """Return the text with every cell in quotes, decimal commas and commas between the cells."""
    cells = [line.replace('.', ',').split(';') for line in text.splitlines()]
    return ''.join(','.join(f'"{cell}"' for cell in row) + '\n' for row in cells)


def clock_times(pattern='{:02d}:{:02d}:{:06.3f}', start_s=0.0):
    t = (start_s + TIMES_S) % 86400.0
    return [pattern.format(int(s // 3600), int(s % 3600 // 60), s % 60) for s in t]


COUNT = [str(n) for n in range(N_ROWS)]
COMMA = seconds(mark=',')
MS = seconds(1e3)
STAMPS = [f'{1700000000 + n // 250},{n % 250 * 4_000_000}' for n in range(N_ROWS)]
SPREAD = [f'{int(t // 60) % 60:02d}:{t % 60:06.3f}' for t in TIMES_S + 3599.5]
READ = {
    'semicolon and decimal comma': table(COMMA, ';', ',', 'Zeit [s];a [g];b [g]\n'),
    'tab and decimal comma': table(COMMA, '\t', ',', 'Zeit\ta [g]\tb [g]\n', '\r\n'),
    'blanks': table(seconds(), '   ', '.', 't a b\n'),
    'decimal commas between blanks': table(COMMA, '  ', ',', 't a b\n'),
    'quoted': quoted(table(seconds(), ';', '.', 'Time (s);a;b\n')),
    'excel': table(COMMA, ';', ',', 'sep=;\nTime (s);a;b\n', '\r\n'),
    'separator at the end': table(seconds(), ';', '.', 't [s];a;b;\n', after=';'),
    'separators at the end of rows': table(seconds(), above='time,a,b\n', after=',,'),
    'remarks': table(seconds(), above='# ADXL355\n% x\n// y\n\ntime,a,b\n'),
    'savetxt': table(seconds(), ' ', '.', '# time a b\n'),
    'row of units': table(seconds(1e3, mark=','), ';', ',', 'Zeit;a;b\nms;g;g\n'),
    'row of units in brackets': table(MS, '\t', '.', 'Time\ta\tb\n[msec]\t[g]\t[g]\n'),
    'text above': table(seconds(), above='Device: X1\nSerial, 42, b, c\n\ntime,a,b\n'),
    'minutes': table(seconds(1 / 60, 10), above='t [min],a,b\n'),
    'hours': table(seconds(1 / 3600, 12), above='t (h),a,b\n'),
    'msec': table(MS, above='Time [msec],a,b\n'),
    'time ms': table(MS, above='time ms,a,b\n'),
    'time_ms': table(MS, above='time_ms,a,b\n'),
    'timeMs': table(MS, above='timeMs,a,b\n'),
    't [us]': table(seconds(1e6), above='t [us],a,b\n'),
    't [µs] of Windows': table(seconds(1e6), above='t [µs],a [m/s²],b [m/s²]\n').encode('cp1252'),
    'ms': table(MS, above='ms,a,b\n'),
    'timestamp_ns': table(seconds(1e9), above='timestamp_ns,a,b\n'),
    'elapsed': table(seconds(), above='elapsed,a,b\n'),
    'Temps': table(COMMA, ';', ',', 'Temps (s);a;b\n'),
    'tiempo': table(COMMA, ';', ',', 'tiempo;a;b\n'),
    'byte order mark': ('\ufeff' + table(seconds(), above='time,a,b\n')).encode(),
    'UTF-16': table(COMMA, '\t', ',', 'time\ta\tb\n').encode('utf-16'),
    'UTF-16 without mark': table(COMMA, '\t', ',', 'time\ta\tb\n').encode('utf-16-le'),
    'ISO 8601': table([f'2024-05-31T{c}Z' for c in clock_times(start_s=86000.0)],
                      above='time,a,b\n'),
    'date and time': table([f'31.05.2024 {c}' for c in clock_times()], ';', ',', 'Datum;a;b\n'),
    'date, time': table([f'2024/05/31,{c}' for c in clock_times()], above='Date,Time,a,b\n'),
    'over midnight': table(clock_times(start_s=86399.5), above='Uhrzeit,a,b\n'),
    'minutes and seconds of a spreadsheet': table(SPREAD, above='time,a,b\n'),
    'whole seconds and nanoseconds': table(STAMPS, above='sec,nanosec,a,b\n'),
    'row numbers of pandas beside a time': table(
        [f'{n},{t}' for n, t in enumerate(seconds())], above=',time,a,b\n'),
    'units in a remark': table(MS, ';', '.', '# t;a;b\n# ms;g;g\n'),
    'names over two lines': table(seconds(), ';', '.', 'x;a;b\nTime;g;g\n'),
    'a slow channel beside fast ones': table(
        COMMA, ';', ',', 't [s];a [g];b [g];n [1/min]\n', after=';').replace(';\n', ';9\n', 3),
    'a slow channel with dashes': table(
        COMMA, ';', ',', 't [s];a [g];b [g];T [°C]\n', after=';-').replace('-\n', '9,5\n', 2),
    'a number in full at the end': table(seconds(), above='time,a,b\n').rstrip(),
    'rate above the table': table(None, above='# Sample rate: 250 Hz\na,b\n'),
    'interval above the table': table(None, ';', ',', 'Sampling interval [ms];4\n\na;b\n'),
}  # fmt: skip


def put(folder, text, name='logger.csv'):
    path = folder / name
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    return path


def gathered(recording):
    return np.concatenate([part.acceleration for part in recording.measurements()])


@pytest.mark.parametrize('case', READ)
def test_what_loggers_write_is_read_as_stated(tmp_path, case):
    recording = open_recording(put(tmp_path, READ[case]))
    factor = G if 'g]' in str(READ[case]) or ';g' in str(READ[case]) else 1.0
    assert recording.channel_names == ('a', 'b')
    assert recording.sample_rate_hz == pytest.approx(RATE_HZ, rel=1e-5)
    assert np.allclose(gathered(recording), factor * VALUES, rtol=1e-12)
    if recording.stamp_ns is not None:
        assert np.abs(np.diff(recording.stamp_ns) - 4e6).max() <= 1e3


JITTERED = [
    f'{t:.6f}' for t in (np.arange(N_ROWS) + np.random.default_rng(SEED).normal(size=N_ROWS)) / 250
]
UNEVEN = [f'{t:.6f}' for t in np.sort(np.random.default_rng(SEED).lognormal(0, 3, N_ROWS))]
ASKED = {
    'decimal commas between commas': (table(None, ',', ',', 'a,b\n'), 'decimal comma'),
    'the same without names': (table(None, ',', ','), 'decimal comma'),
    'rows longer than the names': (table(seconds(), above='a,b\n'), '2 names, 3 columns'),
    'one row longer': (table(None) + '1,2,3\n', 'line 301: row too long'),
    'one row shorter': (table(None) + '1\n1,2\n', 'line 301: row too short'),
    'a word': (table(None) + '1,n.a.\n1,2\n', 'line 301, column 2: not a number'),
    'thousands': (table(None) + '"1,234.5",2\n' * 300, 'thousands'),
    'thousands or decimals': (table(None, ';') + '1,234;2\n' * 301, 'decimal'),
    'commas and points': (table(None, ';', ',') + '1.5;2.5\n' * 299, 'decimal commas'),
    'counts up, no name': (table(seconds()), 'column 1: counts up'),
    'counts up, no name, whole': (table(COUNT), 'column 1: counts up'),
    'counts up, unknown name': (table(seconds(), above='foo,a,b\n'), r'\(foo\): counts up'),
    'counts up, wraps around': (table([str(n % 100) for n in range(N_ROWS)]), 'counts up'),
    'coarse, no name': (table([str(n // 10) for n in range(N_ROWS)]), 'counts up'),
    'jitters by more than its step, no name': (table(JITTERED), 'column 1: counts up'),
    'counts down, no name': (table(seconds()[::-1]), 'column 1: counts up'),
    'index of pandas': (table(COUNT, above=',a,b\n'), 'column 1: counts up'),
    'whole times without unit': (table(COUNT, above='time,a,b\n'), 'time without unit'),
    'milliseconds without unit': (table(MS, above='time,a,b\n'), 'time without unit'),
    'unknown unit': (table(None, above='a [m/s^3],b [m/s^3]\n'), 'unknown unit'),
    'unknown unit of time': (table(seconds(), above='time [1/x],a,b\n'), 'unknown unit'),
    'one unit of two': (table(None, above='a [g],b\n'), 'no unit, where others have one'),
    'no response': (table(None, above='a [V],b [V]\n'), 'no column of responses'),
    'rotation without unit': (table(None, above='acc_x,gyro_x\n'), r'\(gyro_x\)'),
    'two times': (table([f'{t},{t}' for t in seconds()], above='time,elapsed,a,b\n'), 'which'),
    'backward times': (table(seconds()[::-1], above='time,a,b\n'), 'does not run forward'),
    'uneven times': (table(UNEVEN, above='time [s],a,b\n'), 'not evenly spaced'),
    'two rates': (table(None, above='# sample rate: 250 Hz\n# fs = 500 Hz\na,b\n'), 'two sample'),
    'twice the name': (table(None, above='a,a\n'), 'named twice'),
    'a name that never ends': (table(None, above='a' * 300 + ',b\n'), 'bad name'),
    'escapes': (table(None, above='a\x1b[2J,b\n'), 'not a text file'),
    'right to left': (table(None, above='a\u202eb,b\n'), 'bad name'),
    'binary': (b'\x00\x01\x02\x80' * 100, 'not a text file'),
    'no numbers': ('a,b\nc,d\ne,f\n', 'no row of numbers'),
}  # fmt: skip


@pytest.mark.parametrize('case', ASKED)
def test_what_could_mean_two_things_is_refused_in_one_line(tmp_path, case):
    text, words = ASKED[case]
    path = put(tmp_path, text)
    stated = {} if 'time' in case or 'rate' in case else {'sample_rate_hz': RATE_HZ}
    with pytest.raises(RecordingError, match=words) as caught:
        open_recording(path, **stated)
    assert path.name in str(caught.value) and str(caught.value).isprintable()


def test_a_number_that_is_cut_off_is_not_read(tmp_path):
    text = table([f'{t:.5e}' for t in TIMES_S], above='time,a,b\n').rstrip()
    recording = open_recording(put(tmp_path, text[:-2]))
    assert np.array_equal(gathered(recording), VALUES[:-1])
    assert 'last row left out: it ends in the middle of a number' in recording.notes


def test_a_time_that_begins_anew_is_told(tmp_path):
    rows = table(seconds())
    recording = open_recording(put(tmp_path, f'time [s],a,b\n{rows}{rows}'))
    assert recording.sample_rate_hz == pytest.approx(RATE_HZ)
    assert any('time falls back 1 x' in note for note in recording.notes)


@pytest.mark.parametrize('digits', [3, 4])
def test_times_of_few_digits_do_not_bend_the_rate(tmp_path, digits):
    """Rows 1.9 ms apart in whole milliseconds: two of most steps, and one now and then."""
    times = [f'{n / 520.0:.{digits}f}' for n in range(N_ROWS)]
    recording = open_recording(put(tmp_path, table(times, above='t [s],a,b\n')))
    assert recording.sample_rate_hz == pytest.approx(520.0, rel=2e-4)


def test_units_of_each_column_count_and_rotations_are_left_out_with_a_word(tmp_path):
    above = 't [s],w [deg/s],T [°C],a [g],b [m/s²]\n'
    text = table([f'{t},1.5,20.1' for t in seconds()], above=above)
    recording = open_recording(put(tmp_path, text))
    assert recording.channel_names == ('a', 'b')
    assert np.allclose(gathered(recording), VALUES * (G, 1.0))
    assert [note.split()[0] for note in recording.notes] == ['w', 'T']
    assert all('left out' in note for note in recording.notes)


def test_rotations_take_part_where_columns_are_named(tmp_path):
    text = table(seconds(), above='t [s],w [deg/s],b [m/s²]\n')
    recording = open_recording(put(tmp_path, text), channels=['t [s]', 'w [deg/s]', 'b [m/s^2]'])
    assert recording.channel_names == ('w', 'b') and recording.units == ('rad/s', 'm/s^2')
    assert np.allclose(gathered(recording), VALUES * (np.pi / 180.0, 1.0))


def test_rotations_take_part_where_gyroscopes_are_asked_for(tmp_path):
    recording = open_recording(put(tmp_path, table(seconds(), above='t [s],w [deg/s],b [m/s²]\n')))
    assert recording.channel_names == ('b',)
    recording = recording.with_gyroscopes()
    assert recording.channel_names == ('w', 'b') and recording.units == ('rad/s', 'm/s^2')
    assert not any('left out' in note for note in recording.notes)


@pytest.mark.parametrize(
    ('unit', 'si', 'factor'),
    [
        ('mm/s', 'm/s', 1e-3),
        ('ips', 'm/s', 0.0254),
        ('µm', 'm', 1e-6),
        ('mil', 'm', 2.54e-5),
        ('um/m', 'm/m', 1e-6),
        ('microstrain', 'm/m', 1e-6),
        ('dps', 'rad/s', np.pi / 180.0),
    ],
)
def test_every_column_says_what_it_measures(tmp_path, unit, si, factor):
    named = put(tmp_path, table(seconds(), above=f't [s],a [{unit}],b [{unit}]\n'))
    recording = open_recording(named)
    assert recording.units == (si, si)
    assert np.allclose(gathered(recording), factor * VALUES)
    assert all(unit in note for note in recording.notes) and len(recording.notes) == 2
    bare = put(tmp_path, table(None), 'bare.csv')
    recording = open_recording(bare, sample_rate_hz=RATE_HZ, unit=unit)
    assert recording.units == (si, si) and np.allclose(gathered(recording), factor * VALUES)


def test_names_that_all_end_in_g_are_in_g(tmp_path):
    recording = open_recording(put(tmp_path, table(seconds(), above='t,acc_x_g,acc_y_g\n')))
    assert np.allclose(gathered(recording), G * VALUES)
    assert any('all end in g' in note for note in recording.notes)
    recording = open_recording(put(tmp_path, table(seconds(), above='t,acc_x_g,acc_y\n')))
    assert np.allclose(gathered(recording), VALUES)


def test_velocity_beside_acceleration_is_another_kind(tmp_path):
    text = table(seconds(), above='t [s],v [mm/s],b [g]\n')
    recording = open_recording(put(tmp_path, text))
    assert recording.units == ('m/s', 'm/s^2')
    assert np.allclose(gathered(recording), VALUES * (1e-3, G))


def test_kinds_survive_conversion_to_messages(tmp_path):
    text = table(None, above='v [mm/s],b [g]\n')
    recording = open_recording(put(tmp_path, text), sample_rate_hz=RATE_HZ)
    converted = open_recording(to_mcap(recording, tmp_path / 'converted.mcap'))
    blocks = [part for part in converted.measurements() if isinstance(part, SampleBlock)]
    assert {block.channel_names for block in blocks} == {('v [m/s]', 'b')}
    sent = np.concatenate([block.acceleration for block in blocks])
    assert np.allclose(sent, VALUES * (1e-3, G), rtol=1e-6)
    timed = put(tmp_path, table(seconds(), above='t [s],v [mm/s],b [g]\n'), 'timed.csv')
    with pytest.raises(RecordingError):
        to_mcap(open_recording(timed), tmp_path / 'timed.mcap')


def test_the_question_is_answered_by_names(tmp_path):
    path = put(tmp_path, table([f'{n},{t}' for n, t in zip(COUNT, MS, strict=True)]))
    recording = open_recording(path, channels=['-', 'time [ms]', 'a [mg]', 'b [mg]'])
    assert recording.channel_names == ('a', 'b') and recording.sample_rate_hz == pytest.approx(250)
    assert np.allclose(gathered(recording), 1e-3 * G * VALUES)
    recording = open_recording(path, 250.0, 'g', ['index', 'time [ms]', 'a', 'b'])
    assert 'index left out' in recording.notes[0]
    named = put(tmp_path, table(seconds(), above='time,u [g],v [g]\n'), 'named.csv')
    assert open_recording(named, channels=['a', 'b']).channel_names == ('a', 'b')
    assert np.allclose(gathered(open_recording(named, channels=['a', 'b'])), G * VALUES)


def test_what_is_stated_twice_must_agree(tmp_path):
    path = put(tmp_path, table(seconds(), above='time [s],a [g],b [g]\n'))
    with pytest.raises(RecordingError, match=r'found 250 Hz .* expected 200 Hz'):
        open_recording(path, sample_rate_hz=200.0)
    with pytest.raises(RecordingError, match=r'found 250 Hz .* expected 248 Hz'):
        open_recording(path, sample_rate_hz=248.0)
    with pytest.raises(RecordingError, match=r'found g .* expected m/s\^2'):
        open_recording(path, unit='m/s^2')
    parts = list(open_recording(path, sample_rate_hz=250.0, unit='g').measurements())
    assert all(isinstance(part, SampleBlock) and part.sample_rate_hz == 250.0 for part in parts)
    above = put(tmp_path, table(None, above='# fs: 100 Hz\na,b\n'), 'above.csv')
    with pytest.raises(RecordingError, match='100 Hz above the table, expected 250 Hz'):
        open_recording(above, sample_rate_hz=250.0)


@pytest.mark.parametrize('name, first', [('index', COUNT), ('time', seconds())])
def test_rows_a_counter_or_a_clock_left_out_are_a_gap(tmp_path, name, first):
    rows = table(first).splitlines(keepends=True)
    kept = ''.join(rows[n] for n in range(N_ROWS) if not 100 <= n < 140)
    path = put(tmp_path, f'{name},a,b\n{kept}')
    (topic,) = open_recording(path, sample_rate_hz=RATE_HZ).info().topics
    assert topic.n_gaps == 1 and topic.gaps[0].n_lost == 40


@pytest.mark.parametrize(
    'case', ['tone', 'quiet', 'coarse', 'drifting', 'stuck', 'one', 'hundred']
)
def test_healthy_columns_without_names_are_channels(tmp_path, case):
    rng = np.random.default_rng(SEED)
    t = np.arange(4000) / 500.0
    values = {
        'tone': np.sin(2 * np.pi * 0.5 * t)[:, None] + np.zeros((1, 2)),
        'quiet': 1e-9 * rng.normal(size=(4000, 2)),
        'coarse': np.round(2.0 * rng.normal(size=(4000, 2))),
        'drifting': 9.81 + t[:, None] * 0.1 + 0.01 * rng.normal(size=(4000, 2)),
        'stuck': np.column_stack([rng.normal(size=4000), np.where(t > 4.0, 1.0, 0.0)]),
        'one': rng.normal(size=(4000, 1)),
        'hundred': rng.normal(size=(4000, 100)),
    }[case]
    path = tmp_path / 'healthy.csv'
    np.savetxt(path, values, delimiter=',')
    assert np.array_equal(gathered(open_recording(path, sample_rate_hz=500.0)), values)
    np.save(tmp_path / 'healthy.npy', values)
    found = gathered(open_recording(tmp_path / 'healthy.npy', sample_rate_hz=500.0))
    assert np.array_equal(found, values)


def test_a_time_among_the_columns_of_a_binary_array_is_asked_for(tmp_path):
    path = tmp_path / 'array.npy'
    np.save(path, np.column_stack([TIMES_S, VALUES]))
    with pytest.raises(RecordingError, match='column 1: counts up'):
        open_recording(path, sample_rate_hz=RATE_HZ)
    (tmp_path / 'array.npy.yaml').write_text('channels: ["time [s]", a, b]\nunit: g\n')
    assert open_recording(path).sample_rate_hz == pytest.approx(RATE_HZ)


SCRAPS = (
    b';', b'"', b'\n', b'\0', b'nan', b'1e999', b'9' * 400, b'\t', b'#', b'sep=;\n', b'[g]',
    b'(ms)', b'2024-13-45 25:61:00', b'00:00:00', b'\xff', b'-', b'fs=1e400\n',
    b'sample rate: 0 Hz\n',
)  # fmt: skip


@pytest.mark.filterwarnings('error')
def test_damaged_text_is_read_or_refused_never_more(tmp_path):
    rng = np.random.default_rng(SEED)
    texts = [*READ.values(), *(text for text, _ in ASKED.values())]
    for number in range(400):
        text = texts[rng.integers(len(texts))]
        data = bytearray(text if isinstance(text, bytes) else text.encode())
        for _ in range(rng.choice([1, 3, 30])):
            place = rng.integers(min(len(data), rng.choice([60, 10_000])))
            cut = rng.choice([0, 1, 40])
            data[place : place + cut] = SCRAPS[rng.integers(len(SCRAPS))] if cut < 40 else b''
            data = data or bytearray(b'1')
        path = put(tmp_path, bytes(data))
        try:
            open_recording(path, sample_rate_hz=RATE_HZ if number % 2 else None).info()
        except RecordingError as error:
            line = str(error)
            assert line.isprintable() and len(line) < 3000, f'seed {SEED}, number {number}'


def test_a_line_that_never_ends_and_a_million_columns_are_refused(tmp_path):
    for text, words in (
        (b'1' * 5_000_000, 'line too long'),
        (b'1,' * 300_000 + b'\n' + b'1,' * 300_000 + b'\n', 'too many columns'),
    ):
        with pytest.raises(RecordingError, match=words):
            open_recording(put(tmp_path, text), sample_rate_hz=RATE_HZ)
