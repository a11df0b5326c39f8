"""Result files: strict JSON with the promised keys, CSV that reads back, nothing half written."""

import csv
from dataclasses import dataclass
import io
import json
import math

import numpy as np
import pytest

from autonomous_modal_analysis.identified.results import (
    csv_text,
    Identification,
    identification_json,
    IdentifiedWindow,
    json_text,
    mode_json,
    write_csv,
    write_json,
)
from modal_core.channel import Channel
from modal_core.mode import Mode, ModeSet
from modal_core.quality import DataQuality
from modal_core.settings.quantity import quantity

PROMISED = {
    'id',
    'frequency_hz',
    'frequency_std_hz',
    'damping_ratio',
    'damping_ratio_std',
    'shape_real',
    'shape_imag',
    'shape_std_real',
    'shape_std_imag',
    'mac_loss',
    'mac_loss_std',
    'mpc',
    'mpd',
    'harmonic',
}
LINE = Mode(24.0, 0.0, np.array([0.3j, 1.0 + 0j]), harmonic=True)


def identification():
    shape, shape_std = np.array([1.0 + 0j, -0.5 + 0.1j]), np.array([0j, 0.02 + 0.03j])
    mode = Mode(12.5, 0.02, shape, frequency_std_hz=math.nan, id=3, shape_std=shape_std)
    modes = ModeSet((mode,), ('a.x', 'b,"x'))
    start = 1_760_000_000_000_000_000
    lines = ModeSet((LINE,), ('a.x', 'b,"x'))
    window = IdentifiedWindow(0, start, start + 20_000_000_000, modes, harmonics=lines)
    return Identification(
        modes,
        (window, IdentifiedWindow(1, start, start + 1, ModeSet((), ('a.x', 'b,"x')))),
        (Channel('a.x'), Channel('b,"x')),
        DataQuality(),
        {'window_s': math.inf, 'band_hz': np.array([1.0, math.nan])},
        harmonics=lines,
    )


def test_json_has_the_promised_keys_and_no_nan():
    found = identification_json(identification())
    expected = {
        'modes', 'harmonics', 'shape_channels', 'band', 'tracks', 'windows', 'channels',
        'data_quality', 'remarks', 'settings',
    }  # fmt: skip
    assert set(found) == expected
    for part in (found, found['windows'][0]):
        assert not any(mode['harmonic'] for mode in part['modes'])
        assert [line['frequency_hz'] for line in part['harmonics']] == [24.0]
        assert part['harmonics'][0]['harmonic'] is True
    assert set(found['harmonics'][0]) >= PROMISED
    assert set(found['modes'][0]) >= PROMISED
    assert found['windows'][0]['end_time_s'] - found['windows'][0]['start_time_s'] == 20.0
    assert found['windows'][0]['modes'] == found['modes']

    def refuse(constant):
        raise AssertionError(f'{constant} is not JSON')

    back = json.loads(json_text(found), parse_constant=refuse)
    assert back['modes'][0]['frequency_std_hz'] is None
    assert back['modes'][0]['shape_imag'] == [0.0, 0.1]
    assert back['modes'][0]['shape_std_imag'] == [0.0, 0.03]
    assert back['harmonics'][0]['shape_std_real'] is None
    assert back['settings'] == {'window_s': None, 'band_hz': [1.0, None]}


def test_csv_reads_back():
    rows = list(csv.DictReader(io.StringIO(csv_text(identification()))))
    assert len(rows) == 2
    assert [row['harmonic'] for row in rows] == ['False', 'True']
    assert float(rows[1]['shape_imag.a.x']) == 0.3
    assert float(rows[0]['frequency_hz']) == 12.5
    assert rows[0]['frequency_std_hz'] == ''
    assert float(rows[0]['shape_real.b,"x']) == -0.5


def test_failed_write_leaves_the_old_file(tmp_path, monkeypatch):
    path = tmp_path / 'modes.json'
    write_json(path, identification())
    before = path.read_bytes()

    def fail(*_):
        raise OSError('disk full')

    monkeypatch.setattr('os.replace', fail)
    with pytest.raises(OSError, match='disk full'):
        write_csv(path, identification())
    assert path.read_bytes() == before
    assert list(tmp_path.iterdir()) == [path]


def test_a_new_field_of_a_mode_is_in_the_files_and_the_old_ones_keep_their_order():
    @dataclass(frozen=True)
    class Wider(Mode):
        new_hz: float = quantity('new', 'Hz', default=1.0)

    keys = list(mode_json(Wider(1.0, 0.01, np.ones(2))))
    assert keys == [
        'id', 'frequency_hz', 'frequency_std_hz', 'damping_ratio', 'damping_ratio_std',
        'shape_real', 'shape_imag', 'shape_std_real', 'shape_std_imag', 'mac_loss',
        'mac_loss_std', 'mpc', 'mpd', 'harmonic', 'known_motion', 'new_hz',
    ]  # fmt: skip
