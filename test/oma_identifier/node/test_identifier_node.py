"""The identifier node over real Fast DDS: right modes, bad messages, parameters, replay."""

from pathlib import Path
import subprocess
import sys
import time

import numpy as np
import pytest

pytest.importorskip('rclpy')
pytest.importorskip('oma_msgs')

from rcl_interfaces.srv import SetParameters
import rclpy
from rclpy.parameter import Parameter
from rclpy.qos import ReliabilityPolicy

from modal_core.channel import Channel
from modal_core.errors import SettingsError
from modal_core.measurements import JointSamples, SampleBlock, StampedSamples
from modal_core.samples import Samples
from modal_recordings import open_recording, to_mcap
from modal_recordings.messages import BLOCK, encode
from oma_identifier.identify import identify_samples
from oma_identifier.node.identifier_node import IdentifierNode
from oma_identifier.node.ros_messages import MESSAGE_CLASSES
from oma_identifier.pipeline import IdentificationPipeline
from oma_identifier.settings import IdentificationSettings
from oma_identifier.tracking.checkpoint_file import CheckpointFile
from oma_msgs.msg import ModalParameters
from test.support.node_driver import NodeDriver, three_modes

pytestmark = pytest.mark.node
START = 1_700_000_000_000_000_000
SEED = 7


@pytest.fixture
def driver(ros_context):
    drivers = []

    def start(**parameters):
        drivers.append(NodeDriver(ros_context, **parameters))
        return drivers[-1]

    yield start
    for each in drivers:
        each.close()


def block_messages(data, rate_hz, names, rows=32):
    for first in range(0, len(data) - rows + 1, rows):
        yield from encode(
            SampleBlock(
                source='/acceleration_block',
                stamp_ns=START + round(first * 1e9 / rate_hz),
                first_index=first,
                sample_rate_hz=rate_hz,
                channel_names=names,
                acceleration=data[first : first + rows].astype(np.float32),
            ),
            '/acceleration_block',
        )


def check_frequencies(message, expected):
    found = [mode.frequency_hz for mode in message.modes if not mode.harmonic]
    assert len(found) == len(expected), f'found {found}, seed {SEED}'
    for mode, truth in zip(message.modes, expected, strict=True):
        # A window of some tens of seconds scatters by the law of Au: 0.3 to 0.5 % here.
        limit = max(0.01 * truth, 3.0 * mode.frequency_std_hz)
        assert abs(mode.frequency_hz - truth) < limit, f'seed {SEED}'
        assert mode.frequency_std_hz < 0.02 * truth, f'seed {SEED}'


@pytest.mark.smoke
def test_blocks_to_modes(driver):
    node = driver(window_s=40.0, hop_s=20.0, max_frequency_hz=30.0)
    data, truth = three_modes(80.0, 200.0, 6, SEED)
    node.send(block_messages(data, 200.0, tuple(f'c{i}' for i in range(6))))
    node.wait_received(len(data) // 32)
    node.finish()
    assert [message.window_index for message in node.results][:3] == [0, 1, 2]
    for message in node.results[:3]:
        assert message.data_quality.identifiable, message.data_quality.reason
        check_frequencies(message, truth)
    assert node.results[0].window_start.sec == START // 10**9


def test_single_messages_to_modes_with_pose(driver):
    node = driver(window_s=30.0, hop_s=30.0, max_frequency_hz=30.0)
    data, truth = three_modes(30.5, 200.0, 6, SEED)
    rng = np.random.default_rng(SEED)
    stamps = START + np.round(np.arange(len(data)) * 5e6).astype(np.int64)
    messages = []
    for number in range(2):
        part = data[:, 3 * number : 3 * number + 3]
        samples = StampedSamples('', f'link_{number}', stamps, part, np.zeros_like(part))
        messages += encode(samples, f'/imu/sensor_{number}')
    position = np.full((305, 2), 0.5) + rng.uniform(-0.01, 0.01, (305, 2))
    joints = JointSamples(
        START + np.arange(305, dtype=np.int64) * 10**8, ('j1', 'j2'), position, position * 0
    )
    messages += encode(joints, '/joint_states')
    node.send(sorted(messages, key=lambda message: message.log_time_ns))
    node.wait_received(len(messages))
    node.finish()
    message = node.results[0]
    check_frequencies(message, truth)
    assert list(message.joint_names) == ['j1', 'j2']
    assert message.joint_positions == pytest.approx(position[:300].mean(axis=0), abs=1e-4)
    assert [c.n_lost for c in message.data_quality.channels] == [0] * 6


def test_malformed_messages_are_counted_and_survived(driver):
    node = driver(window_s=20.0, hop_s=20.0, max_frequency_hz=30.0)
    data, truth = three_modes(20.5, 200.0, 4, SEED)
    messages = list(block_messages(data, 200.0, tuple('abcd')))
    good = messages[0].data
    bad = [
        good[:40],
        good[:-4],
        b'\x00\x01\x00\x00' + b'\xff' * 60,
        good.replace(np.float64(200.0).tobytes(), np.float64(np.nan).tobytes()),
        good.replace(b'\x02\x00\x00\x00b\x00', b'\x02\x00\x00\x00a\x00'),
    ]
    publisher = node.publisher('/acceleration_block', BLOCK)
    for raw in bad:
        publisher.publish(raw)
    node.send(messages)
    node.wait_received(len(messages) + len(bad))
    node.finish()
    assert node.node.intake.n_refused['/acceleration_block'] == len(bad)
    codes = [code for code, _ in node.node.findings()]
    assert 'MESSAGE_REFUSED' in codes
    check_frequencies(node.results[0], truth)


def test_parameters_out_of_range_are_rejected_with_the_range(driver):
    node = driver()
    client = node.peer.create_client(SetParameters, '/oma_identifier/set_parameters')
    assert client.wait_for_service(10.0)

    def set_one(name, value):
        request = SetParameters.Request(
            parameters=[Parameter(name, value=value).to_parameter_msg()]
        )
        future = client.call_async(request)
        node.peer_executor.spin_until_future_complete(future, timeout_sec=20.0)
        return future.result().results[0]

    for name, value, words in (
        ('window_s', 0.5, '86400'),
        ('max_order', 1000, '100'),
        ('hop_s', 90.0, '0.01 to 60'),
        ('method', 'magic', 'ssi_cov'),
    ):
        before = node.node.get_parameter(name).value
        answer = set_one(name, value)
        assert not answer.successful
        assert words in answer.reason and name in answer.reason
        assert node.node.get_parameter(name).value == before
    assert set_one('window_s', 30.0).successful
    assert node.node.pipeline.settings.window_s == 30.0


def test_checkpoint_keeps_ids_over_a_restart(driver, tmp_path):
    file = str(tmp_path / 'tracks.json')
    data, _ = three_modes(20.5, 200.0, 4, SEED)
    ids = []
    for _ in range(2):
        node = driver(
            window_s=20.0,
            hop_s=20.0,
            max_frequency_hz=30.0,
            min_frequency_hz=5.0,
            checkpoint_file=file,
        )
        messages = list(block_messages(data, 200.0, tuple('abcd')))
        node.send(messages)
        node.wait_received(len(messages))
        node.finish()
        # A restarted node first serves what the one before it found last.
        found = node.results[-1]
        ids.append([mode.id for mode in found.modes])
        if len(ids) == 2:
            assert node.results[0].window_start == node.results[-1].window_start
            assert len(node.results) == 2
            # Numbers run on, and the first window says why there is a break before it.
            assert node.results[1].window_index == node.results[0].window_index + 1
            assert [list(r.data_quality.flags).count('restarted') for r in node.results] == [0, 1]
        node.close()
        node.close = lambda: None
    assert ids[0] and ids[0] == ids[1]


def test_a_checkpoint_is_written_by_one_identifier_only(driver, tmp_path):
    file = str(tmp_path / 'tracks.json')
    node = driver(checkpoint_file=file)
    line = [sys.executable, '-P', '-m', 'oma_identifier.node.identifier_node', '--ros-args']
    other = [*line, '-p', f'checkpoint_file:={file}']
    refused = subprocess.run(other, capture_output=True, text=True, timeout=60, check=False)
    assert refused.returncode == 2 and refused.stderr.count('\n') == 1
    assert 'used by another identifier' in refused.stderr and file in refused.stderr
    node.close()
    node.close = lambda: None
    holder = 'import time, pathlib; from oma_identifier.tracking import CheckpointFile; '
    holder += (
        f'kept = CheckpointFile(pathlib.Path({file!r})); print(1, flush=True); time.sleep(60)'
    )
    killed = subprocess.Popen([sys.executable, '-c', holder], stdout=subprocess.PIPE)
    killed.stdout.readline()
    with pytest.raises(SettingsError, match='another identifier'):
        CheckpointFile(Path(file))
    killed.kill()
    killed.wait()
    CheckpointFile(Path(file)).close()


def test_a_window_that_is_done_after_the_stop_is_kept(tmp_path):
    context, file = rclpy.Context(), tmp_path / 'tracks.json'
    rclpy.init(context=context)
    parameters = [Parameter('checkpoint_file', value=str(file))]
    node = IdentifierNode(context=context, parameter_overrides=parameters)
    data, _ = three_modes(20.0, 200.0, 4, SEED)
    channels = tuple(Channel(name) for name in 'abcd')
    result = identify_samples(Samples(data, 200.0, channels, START))
    rclpy.shutdown(context=context)
    node.publish_result(result)
    assert file.exists() and file.with_name('tracks.json.last').exists()
    node.destroy_node()


@pytest.mark.parametrize('content', [b'', b'\x00\x01\x00\x00' + b'\xff' * 100, b'junk'])
def test_a_broken_last_result_is_named_and_survived(driver, tmp_path, content):
    (tmp_path / 'tracks.json.last').write_bytes(content)
    node = driver(checkpoint_file=str(tmp_path / 'tracks.json'))
    assert 'tracks.json.last' in node.node.problems['CHECKPOINT']
    node.collect()
    assert node.results == []


def test_a_best_effort_publisher_is_heard(driver):
    node = driver(window_s=20.0, hop_s=20.0, max_frequency_hz=30.0)
    data, truth = three_modes(20.5, 200.0, 4, SEED)
    messages = list(block_messages(data, 200.0, tuple('abcd')))
    node.publisher('/acceleration_block', BLOCK, reliability=ReliabilityPolicy.BEST_EFFORT)
    node.send(messages, pause_every=5)
    node.wait_received(len(messages), timeout_s=5.0)
    node.finish()
    assert node.n_received() > 0.9 * len(messages)
    check_frequencies(node.results[0], truth)


def offline_windows(path, settings):
    pipeline = IdentificationPipeline(settings)
    results = []
    for measurement in open_recording(path).measurements():
        pipeline.add(measurement)
        results += [pipeline.identify(window) for window in pipeline.windows()]
    return results + [pipeline.identify(window) for window in pipeline.finish()]


@pytest.mark.slow
@pytest.mark.parametrize('name', ['palisaden', 'cessipy'])
def test_live_replay_gives_the_same_modes_as_offline(driver, data_path, tmp_path, name):
    if name == 'palisaden':
        source = open_recording(
            data_path('palisaden_clt_building', 'Palisaden_dataset.npy'), sample_rate_hz=100.0
        )
        settings = IdentificationSettings(window_s=1200.0, hop_s=1200.0, max_frequency_hz=5.0)
    else:
        source = open_recording(
            data_path('cessipy_slab_smartphone', 'Example02_Smartphone_Data.csv')
        )
        settings = IdentificationSettings(window_s=25.0, hop_s=12.5, max_frequency_hz=40.0)
    path = to_mcap(source, tmp_path / f'{name}.mcap')
    offline = offline_windows(path, settings)
    node = driver(
        window_s=settings.window_s,
        hop_s=settings.hop,
        max_frequency_hz=settings.max_frequency_hz,
    )
    messages = list(open_recording(path).messages())
    node.send(messages)
    node.wait_received(len(messages))
    assert node.n_received() == len(messages)
    node.finish()
    assert len(node.results) == len(offline)
    assert sum(len(result.modes) for result in offline) > 0
    for live, file in zip(node.results, offline, strict=True):
        found = [mode.frequency_hz for mode in live.modes if not mode.harmonic]
        assert found == [mode.frequency_hz for mode in file.modes]


def test_sensors_of_another_cell_are_not_ours(driver, ros_context):
    other = rclpy.create_node('emulator', namespace='/hall/cell_2', context=ros_context)
    other.create_publisher(ModalParameters, '~/true_modes', 1)
    theirs = other.create_publisher(MESSAGE_CLASSES[BLOCK], 'acceleration_block', 1)
    node = driver()
    # Of a hall with a cell in it, what is not of that cell is heard.
    node.publisher('/hall/acceleration_block', BLOCK)
    time.sleep(1.0)
    assert theirs.get_subscription_count() == 0
    other.destroy_node()
