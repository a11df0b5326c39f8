"""Measurement files of LabVIEW, as its Write To Measurement File makes them."""

import numpy as np
import pytest

from modal_core.errors import RecordingError
from modal_recordings import open_recording
from modal_recordings.force_column import open_with_force

SEED, N_ROWS, RATE_HZ, G = 4, 500, 512.0, 9.80665
VALUES = np.round(np.random.default_rng(SEED).normal(size=(N_ROWS, 2)), 4)


def lvm(kind='One', mark='\t', decimal='.', n_said=N_ROWS, dimension='Time', last='Comment'):
    """Return the text of a file with the columns of times that ``kind`` says."""
    word = {'\t': 'Tab', ',': 'Comma'}[mark]
    step = f'{1.0 / RATE_HZ:.9f}'
    lines = [
        ['LabVIEW Measurement', ''], ['Writer_Version', '2'], ['Separator', word],
        ['Decimal_Separator', decimal], ['Multi_Headings', 'No'], ['X_Columns', kind],
        ['Time_Pref', 'Relative'], ['Date', '2026/03/04'], ['***End_of_Header***', ''], [],
        ['Channels', '2', ''], ['Samples', str(n_said), str(n_said)], ['Y_Unit_Label', 'g', 'g'],
        ['X_Dimension', dimension, dimension], ['X0', '0', '0'], ['Delta_X', step, step],
        ['***End_of_Header***', '', ''],
        ['X_Value', 'a', *(['X_Value'] if kind == 'Multi' else []), 'b', last],
    ]  # fmt: skip
    for n, (one, two) in enumerate(VALUES):
        x = '' if kind == 'No' else f'{n / RATE_HZ:.6f}'
        more = [x] if kind == 'Multi' else []
        remark = ['begin, says Ann'] if n == 0 and mark == '\t' else []
        lines.append([x, f'{one:.4f}', *more, f'{two:.4f}', *remark])
    text = '\r\n'.join(mark.join(line) for line in lines) + '\r\n'
    rows = text.index('X_Dimension')
    return text[:rows] + text[rows:].replace('.', decimal) if decimal == ',' else text


def put(folder, text, name='a.lvm'):
    (folder / name).write_text(text, encoding='cp1252', newline='')
    return folder / name


@pytest.mark.parametrize('kind', ['One', 'Multi', 'No'])
@pytest.mark.parametrize(('mark', 'decimal'), [('\t', '.'), ('\t', ','), (',', '.')])
@pytest.mark.parametrize('name', ['a.lvm', 'a.txt'])
def test_what_is_read_is_what_was_written(tmp_path, kind, mark, decimal, name):
    recording = open_recording(put(tmp_path, lvm(kind, mark, decimal), name))
    values = np.concatenate([part.acceleration for part in recording.measurements()])
    assert recording.channel_names == ('a', 'b') and recording.units == ('m/s^2', 'm/s^2')
    assert recording.sample_rate_hz == pytest.approx(RATE_HZ, rel=1e-6)
    assert np.allclose(values, G * VALUES, rtol=1e-12)


@pytest.mark.parametrize(
    ('text', 'words'),
    [
        (''.join(lvm().splitlines(True)[:-3]), r'truncated .found 497 rows, expected 500'),
        (lvm()[:-4], r'truncated .found a last line without an end'),
        (lvm().replace('\t0.', '\t0,', 60), 'not a row of numbers'),
        (lvm()[:150], 'truncated'),
        (lvm()[:60] + '\n', 'its header does not end'),
        (lvm(n_said=400), r'truncated .found 500 rows, expected 400'),
        (lvm(n_said=0), 'different lengths'),
        (lvm(dimension='Frequency'), r'no record over time .found Frequency'),
        (lvm() + lvm()[lvm().index('Channels') :], r'several segments.*one segment a file'),
        (lvm().replace('0.001953125\t0.00', '0.001953125\t0.01'), 'channels of different rates'),
        (lvm().replace('Samples\t500\t500', 'Samples\t500\t50'), 'different lengths'),
        ('time,a\n1,2\n', 'not a LabVIEW measurement file'),
    ],
)
def test_what_is_not_whole_is_refused_in_one_line(tmp_path, text, words):
    with pytest.raises(RecordingError, match=words) as caught:
        open_recording(put(tmp_path, text))
    assert str(caught.value).isprintable()


def test_packets_under_one_header_are_one_recording(tmp_path):
    recording = open_recording(put(tmp_path, lvm(n_said=100)))
    assert len(np.concatenate([each.acceleration for each in recording.measurements()])) == N_ROWS


def test_damaged_files_are_read_or_refused_in_one_line(tmp_path):
    """Seed 4: bytes and pieces of the header changed."""
    rng, whole = np.random.default_rng(SEED), lvm('Multi').encode()
    for number in range(300):
        data = bytearray(whole)
        place = int(rng.integers(700 if number % 3 else len(data)))
        data[place : place + int(rng.choice([0, 1, 8, 60]))] = (b'', b'\t', b'x', b'\n')[
            number % 4
        ]
        path = tmp_path / 'a.lvm'
        path.write_bytes(data)
        try:
            open_recording(path).info()
        except RecordingError as error:
            assert str(error).isprintable(), f'number {number}'


@pytest.mark.parametrize('name', ['a.lvm', 'a.txt'])
def test_a_hammer_beside_a_response_is_found_however_the_file_is_called(tmp_path, name):
    text = lvm().replace('Y_Unit_Label\tg\tg', 'Y_Unit_Label\tN\tg')
    recording = open_with_force(put(tmp_path, text, name))
    assert recording.name == 'a' and recording.responses.channel_names == ('b',)
    assert np.allclose(recording.force_n, VALUES[:, 0], rtol=1e-12)


def test_a_dot_in_a_channels_name_is_part_of_it(tmp_path):
    """Points with their direction had all been called by their direction, and refused."""
    text = lvm().replace('X_Value\ta\tb', 'X_Value\telbow.x\twrist.x')
    file = put(tmp_path, text)
    assert open_recording(file).channel_names == ('elbow.x', 'wrist.x')
    assert '\telbow.x' in text
