"""A recording opened in Python is the one the command line sees."""

import json

import numpy as np
import pytest

import autonomous_modal_analysis as ama
from modal_core.errors import RecordingError
from modal_core.measurements import SampleBlock
from modal_recordings import RecordingWriter
from modal_recordings.messages import encode
from test.support.frame import FLOORS

START_NS, ROWS = 1_700_000_000_000_000_000, 20


def write_mcap(path, values, rate_hz, without=()):
    writer = RecordingWriter(path)
    for first in range(0, len(values), ROWS):
        if first in without:
            continue
        block = SampleBlock(
            '/acceleration',
            START_NS + round(first * 1e9 / rate_hz),
            first,
            rate_hz,
            FLOORS,
            values[first : first + ROWS].astype(np.float32),
        )
        for raw in encode(block, block.source):
            writer.write(raw.topic, raw.message_type, raw.log_time_ns, raw.data)
    return writer.close()


@pytest.fixture(scope='module')
def mcap(frame, tmp_path_factory):
    place = tmp_path_factory.mktemp('recording') / 'frame.mcap'
    return write_mcap(place, frame.acceleration, frame.sample_rate_hz)


def test_a_recording_says_what_it_holds(mcap, frame):
    recording = ama.open(mcap)
    assert recording.channel_names == FLOORS
    assert recording.duration_s == pytest.approx(300.0, abs=0.02)
    assert recording.sample_rates_hz == {'/acceleration': pytest.approx(100.0)}
    text = repr(recording)
    assert 'frame.mcap' in text and '100' in text and 'roof.x' in text and len(text) < 500
    assert '<table>' in recording._repr_html_()


def test_its_samples_are_one_array(mcap, frame):
    recording = ama.open(mcap)
    assert recording.sample_rate_hz == 100.0
    found = recording.to_array()
    assert found.shape == frame.acceleration.shape
    assert found == pytest.approx(frame.acceleration, rel=1e-6, abs=1e-6)
    found[:] = 0.0
    assert recording.to_array().any(), 'a copy is handed out'


def test_its_array_gives_its_modes(mcap):
    recording = ama.open(mcap)
    of_array = ama.identify(
        recording.to_array(), recording.sample_rate_hz, channel_names=recording.channel_names
    )
    of_file = recording.identify()
    assert of_array.frequencies_hz == pytest.approx(of_file.frequencies_hz, rel=1e-9)


def test_samples_with_a_gap_are_not_one_array(frame, tmp_path):
    lost = set(range(10_000, 12_000, ROWS))
    path = write_mcap(tmp_path / 'gap.mcap', frame.acceleration, 100.0, without=lost)
    with pytest.raises(RecordingError, match='one uninterrupted stretch') as caught:
        ama.open(path).to_array()
    assert 'gap' in str(caught.value)
    assert len(ama.open(path).identify()) == 3


def test_a_flat_channel_is_no_number(frame, tmp_path):
    values = frame.acceleration.copy()
    values[:, 1] = 0.5
    recording = ama.open(write_mcap(tmp_path / 'flat.mcap', values, 100.0))
    found = recording.to_array()
    assert found.shape == values.shape
    assert np.isnan(found[:, 1]).all() and np.isfinite(found[:, [0, 2]]).all()


def test_the_samples_are_a_table(mcap, frame):
    pytest.importorskip('pandas')
    table = ama.open(mcap).to_dataframe()
    assert tuple(table.columns) == FLOORS
    assert table.index.name == 'time_s' and table.index[1] == pytest.approx(0.01)


def test_info_is_what_the_command_prints(mcap, ama_command):
    assert ama.open(mcap, to_look=True).to_dict() == json.loads(
        ama_command('info', mcap, '--json')
    )


def test_results_are_what_the_command_prints_and_writes(mcap, ama_command, tmp_path):
    printed = ama_command('identify', mcap, '--json', '--out', tmp_path / 'command')
    result = ama.open(mcap).identify()
    assert result.to_dict() == json.loads(printed)
    result.save(tmp_path / 'api')
    assert (tmp_path / 'api' / 'modes.csv').read_bytes() == (
        tmp_path / 'command' / 'modes.csv'
    ).read_bytes()
    for folder in ('api', 'command'):
        kept = json.loads((tmp_path / folder / 'modes.json').read_text())
        assert kept.pop('file')['recording'] == mcap.name
        spectrum = kept.pop('spectrum')  # for comparisons; not printed
        assert all(len(each) == len(spectrum['frequency_hz']) for each in spectrum.values())
        assert kept == json.loads(result.to_json())
    assert (tmp_path / 'api' / 'report.html').stat().st_size > 10_000


@pytest.mark.slow
def test_an_array_gives_what_its_file_gives(frame, ama_command, tmp_path):
    np.save(tmp_path / 'frame.npy', frame.acceleration)
    options = ('--sample-rate-hz', 100, '--channels', ','.join(FLOORS), '--window-s', 40)
    of_file = json.loads(ama_command('identify', tmp_path / 'frame.npy', *options, '--json'))
    of_array = ama.identify(frame.acceleration, 100, channel_names=FLOORS, window_s=40).to_dict()
    assert of_array == of_file


def test_what_cannot_be_opened_is_one_line(tmp_path):
    (tmp_path / 'no.mcap').write_bytes(b'nothing of the kind')
    for path in (tmp_path / 'none.mcap', tmp_path / 'no.mcap', tmp_path):
        with pytest.raises(ama.ModalAnalysisError) as caught:
            ama.open(path)
        assert '\n' not in str(caught.value) and str(path) in str(caught.value)


def test_a_recording_of_numbers_becomes_messages(frame, tmp_path):
    np.save(tmp_path / 'frame.npy', frame.acceleration[:2000])
    recording = ama.open(tmp_path / 'frame.npy', sample_rate_hz=frame.sample_rate_hz)
    messages = ama.open(recording.to_mcap(tmp_path / 'frame.mcap'))
    np.testing.assert_allclose(messages.to_array(), recording.to_array(), rtol=1e-6)
    with pytest.raises(ama.ModalAnalysisError, match='mcap'):
        recording.to_mcap(tmp_path / 'frame.bag')
