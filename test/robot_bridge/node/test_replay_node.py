"""The replay node as a process: rate, loop, offset, remap, pause, step, clock, original stamps."""

import itertools
import time

import numpy as np
import pytest

pytest.importorskip('rclpy')
pytest.importorskip('oma_msgs')

from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import Imu, JointState
from std_srvs.srv import SetBool, Trigger

from modal_core.measurements import SampleBlock
from modal_recordings import RecordingWriter
from modal_recordings.messages import encode
from oma_msgs.msg import AccelerationBlock, BridgeState
from test.support.domains import ros_domain

pytestmark = pytest.mark.node
BEGIN_NS = 1_600_000_000_123_456_789
PERIOD_S, N_BLOCKS, ROWS = 0.05, 40, 50
numbers = itertools.count()
DEEP = QoSProfile(depth=5000, reliability=ReliabilityPolicy.RELIABLE)
LATCHED = QoSProfile(
    depth=1,
    reliability=ReliabilityPolicy.RELIABLE,
    durability=DurabilityPolicy.TRANSIENT_LOCAL,
)


def blocks():
    random = np.random.default_rng(5)
    for index in range(N_BLOCKS):
        yield SampleBlock(
            source='acceleration_block',
            stamp_ns=BEGIN_NS + round(index * PERIOD_S * 1e9),
            first_index=index * ROWS,
            sample_rate_hz=ROWS / PERIOD_S,
            channel_names=('a.x', 'a.y', 'a.z'),
            acceleration=random.standard_normal((ROWS, 3)).astype(np.float32),
        )


@pytest.fixture(scope='module')
def recording(tmp_path_factory):
    path = tmp_path_factory.mktemp('replay') / 'day.mcap'
    with RecordingWriter(path) as writer:
        for block in blocks():
            for raw in encode(block, '/acceleration_block'):
                writer.write(raw.topic, raw.message_type, raw.log_time_ns, raw.data)
    return path


def stamp_ns(message):
    return message.header.stamp.sec * 1_000_000_000 + message.header.stamp.nanosec


class Listener:
    """Everything a replay publishes, with the time it came."""

    def __init__(self, context, topics):
        self.node = Node('listener', context=context)
        self.got, self.clock, self.states = [], [], []
        for topic, kind in topics.items():
            self.node.create_subscription(kind, topic, self._take, DEEP)
        self.node.create_subscription(
            Clock,
            '/clock',
            lambda m: self.clock.append(m.clock.sec * 1_000_000_000 + m.clock.nanosec),
            DEEP,
        )
        self.node.create_subscription(BridgeState, '/replay/state', self.states.append, LATCHED)
        self.executor = SingleThreadedExecutor(context=context)
        self.executor.add_node(self.node)

    def _take(self, message):
        self.got.append((time.monotonic(), message))

    def listen_raw(self, topic, kind):
        self.raw = []
        self.node.create_subscription(kind, topic, self.raw.append, DEEP, raw=True)

    @property
    def messages(self):
        return [message for _, message in self.got]

    def spin(self, condition, patience_s=40.0):
        deadline = time.monotonic() + patience_s
        while not condition():
            assert time.monotonic() < deadline, f'{len(self.got)} messages'
            self.executor.spin_once(timeout_sec=0.05)
        return self

    def call(self, service, kind, **fields):
        client = self.node.create_client(kind, service)
        self.spin(client.service_is_ready)
        future = client.call_async(kind.Request(**fields))
        self.spin(future.done)
        return future.result()

    def close(self):
        self.executor.shutdown()
        self.node.destroy_node()


@pytest.fixture
def own_domain():
    """Return a ROS domain of this test: no answers from the replay of the test before."""
    return ros_domain(3 * next(numbers))


@pytest.fixture
def processes(drivers, own_domain):
    running = []

    def start(name, **parameters):
        running.append(drivers.NodeProcess(name, own_domain, **parameters))
        return running[-1]

    yield start
    for process in running:
        assert 'Traceback' not in process.stop()


@pytest.fixture
def listen(drivers, own_domain):
    context = drivers.context_of(own_domain)
    made = []

    def make(topics=None):
        made.append(Listener(context, topics or {'/acceleration_block': AccelerationBlock}))
        return made[-1]

    yield make
    for item in made:
        item.close()
    context.try_shutdown()


@pytest.mark.smoke
def test_everything_is_played_as_recorded_with_its_own_stamps(recording, processes, listen):
    listener = listen()
    process = processes('replay', recording=str(recording), publish_clock=True)
    listener.spin(lambda: process.process.poll() is not None and len(listener.got) >= N_BLOCKS)
    assert process.process.returncode == 0, process.stop()
    for block, message in zip(blocks(), listener.messages, strict=True):
        assert stamp_ns(message) == block.stamp_ns
        assert message.first_index == block.first_index
        assert np.array_equal(
            np.array(message.acceleration, np.float32).reshape(-1, 3), block.acceleration
        )
    assert listener.clock == sorted(listener.clock)
    assert listener.clock[0] == BEGIN_NS
    assert set(listener.clock) <= {block.stamp_ns for block in blocks()}
    assert len(listener.clock) > 0.9 * N_BLOCKS


def test_a_table_of_an_arm_is_played_with_its_joint_states(tmp_path, processes, listen):
    """Seed 6."""
    random = np.random.default_rng(6)
    angles, responses = random.standard_normal((400, 2)), random.standard_normal((400, 3))
    np.savez(tmp_path / 'arm.npz', q=angles, acc=responses, fs=200.0)
    (tmp_path / 'sensors.yaml').write_text(
        '{sensors: [{name: elbow, frame_id: link_1, position_m: [0, 0, 0.1]}]}\n'
    )
    listener = listen({'/acceleration_block': AccelerationBlock, '/joint_states': JointState})
    process = processes(
        'replay',
        recording=str(tmp_path / 'arm.npz'),
        unit='m/s^2',
        joint_names=['one', 'two'],
        layout_file=str(tmp_path / 'sensors.yaml'),
    )
    listener.spin(lambda: process.process.poll() is not None)
    blocks = [it for it in listener.messages if isinstance(it, AccelerationBlock)]
    joints = [it for it in listener.messages if isinstance(it, JointState)]
    assert process.process.returncode == 0, process.stop()
    assert blocks[0].channel_names == [f'elbow.{axis}' for axis in 'xyz']
    np.testing.assert_array_equal([it.position for it in joints], angles)
    times_s = (np.array([stamp_ns(it) for it in joints]) - stamp_ns(blocks[0])) * 1e-9
    np.testing.assert_allclose(times_s, np.arange(400) / 200.0, atol=1e-8)


def test_rate_and_start_offset(recording, processes, listen):
    listener = listen()
    process = processes('replay', recording=str(recording), rate=4.0, start_offset_s=1.0)
    listener.spin(lambda: process.process.poll() is not None)
    listener.spin(lambda: len(listener.got) >= N_BLOCKS // 2)
    assert [m.first_index for m in listener.messages] == [
        ROWS * index for index in range(N_BLOCKS // 2, N_BLOCKS)
    ]
    # 0.95 s of recording at rate 4 cannot be over sooner; a busy machine may take longer.
    spread_s = listener.got[-1][0] - listener.got[0][0]
    assert spread_s > 0.1


def test_loop_begins_again_and_remap_moves_the_topic(recording, processes, listen):
    listener = listen({'/elsewhere/block': AccelerationBlock})
    process = processes(
        'replay',
        recording=str(recording),
        rate=20.0,
        loop=True,
        remap=['/acceleration_block:=/elsewhere/block'],
    )
    listener.spin(lambda: len(listener.got) >= 2 * N_BLOCKS + 5)
    indices = [m.first_index // ROWS for m in listener.messages]
    assert indices[: 2 * N_BLOCKS + 5] == [i % N_BLOCKS for i in range(2 * N_BLOCKS + 5)]
    assert process.process.poll() is None


def test_pause_and_step(recording, processes, listen):
    listener = listen()
    process = processes('replay', recording=str(recording), start_paused=True, rate=10.0)
    listener.call('/replay/pause', SetBool, data=True)
    for count in (1, 2, 3):
        assert listener.call('/replay/step', Trigger).success
        listener.spin(lambda: len(listener.got) >= count)  # noqa: B023
    deadline = time.monotonic() + 0.5
    listener.spin(lambda: time.monotonic() > deadline)
    assert [m.first_index // ROWS for m in listener.messages] == [0, 1, 2]
    assert listener.call('/replay/pause', SetBool, data=False).success
    listener.spin(lambda: len(listener.got) >= N_BLOCKS)
    listener.spin(lambda: process.process.poll() is not None)
    assert [m.first_index // ROWS for m in listener.messages] == list(range(N_BLOCKS))


def test_step_while_playing_is_refused(recording, processes, listen):
    listener = listen()
    processes('replay', recording=str(recording), rate=0.5, exit_at_end=False)
    listener.spin(lambda: listener.got)
    assert not listener.call('/replay/step', Trigger).success
    listener.spin(lambda: listener.states)
    assert listener.states[-1].backend == 'replay'


def test_a_plain_array_is_played_as_blocks(tmp_path, processes, listen):
    values = np.random.default_rng(6).standard_normal((4000, 2))
    path = tmp_path / 'plain.npy'
    np.save(path, values)
    listener = listen()
    process = processes(
        'replay', recording=str(path), sample_rate_hz=2000.0, unit='m/s^2', rate=10.0
    )
    listener.spin(lambda: process.process.poll() is not None)
    assert process.process.returncode == 0, process.stop()
    total = 0

    def done():
        nonlocal total
        total = sum(m.n_samples for m in listener.messages)
        return total >= len(values)

    listener.spin(done)
    rows = np.concatenate(
        [np.array(m.acceleration).reshape(m.n_samples, -1) for m in listener.messages]
    )
    np.testing.assert_allclose(rows, values.astype(np.float32))


def test_a_ros_1_bag_is_played_as_ros_2_messages(tmp_path, processes, listen):
    from rosbags.rosbag1 import Writer
    from rosbags.typesys import get_typestore, Stores

    store = get_typestore(Stores.ROS1_NOETIC)
    types = store.types
    values = np.random.default_rng(7).standard_normal((30, 3))
    path = tmp_path / 'old.bag'
    with Writer(path) as bag:
        connection = bag.add_connection('/imu/data', 'sensor_msgs/msg/Imu', typestore=store)
        for index, row in enumerate(values):
            at_ns = BEGIN_NS + index * 10_000_000
            header = types['std_msgs/msg/Header'](
                index,
                types['builtin_interfaces/msg/Time'](*divmod(at_ns, 1_000_000_000)),
                'imu_a',
            )
            vector = types['geometry_msgs/msg/Vector3']
            imu = types['sensor_msgs/msg/Imu'](
                header,
                types['geometry_msgs/msg/Quaternion'](0.0, 0.0, 0.0, 1.0),
                np.zeros(9),
                vector(0.0, 0.0, 0.0),
                np.zeros(9),
                vector(*row.tolist()),
                np.zeros(9),
            )
            bag.write(connection, at_ns, store.serialize_ros1(imu, 'sensor_msgs/msg/Imu'))
    listener = listen({'/imu/data': Imu})
    process = processes('replay', recording=str(path), rate=5.0)
    listener.spin(lambda: process.process.poll() is not None)
    assert process.process.returncode == 0, process.stop()
    listener.spin(lambda: len(listener.got) >= len(values))
    found = [
        [m.linear_acceleration.x, m.linear_acceleration.y, m.linear_acceleration.z]
        for m in listener.messages
    ]
    np.testing.assert_allclose(found, values)
    assert [stamp_ns(m) for m in listener.messages] == [
        BEGIN_NS + index * 10_000_000 for index in range(len(values))
    ]


@pytest.mark.parametrize(
    ('parameters', 'words'),
    [
        ({'rate': 0.0}, 'rate'),
        ({'start_offset_s': -1.0}, 'start_offset_s'),
        ({'remap': ['/a']}, 'old:=new'),
        ({'topics': ['/nope']}, '/nope'),
    ],
)
def test_bad_requests_end_in_one_line(recording, processes, parameters, words):
    process = processes('replay', recording=str(recording), **parameters)
    process.process.wait(timeout=60.0)
    said = process.stop()
    assert process.process.returncode == 2, said
    assert words in said and len(said.strip().splitlines()) == 1


N_CHANNELS, FAST_RATE_HZ, FAST_ROWS, N_FAST = 42, 4096.0, 64, 320


def fast_blocks():
    """Yield 5 s of 42 channels at 4096 Hz: 172,032 samples a second; seed 8."""
    random = np.random.default_rng(8)
    names = tuple(f's{index // 3}.{"xyz"[index % 3]}' for index in range(N_CHANNELS))
    for index in range(N_FAST):
        first = index * FAST_ROWS
        yield SampleBlock(
            source='acceleration_block',
            stamp_ns=BEGIN_NS + round(first / FAST_RATE_HZ * 1e9),
            first_index=first,
            sample_rate_hz=FAST_RATE_HZ,
            channel_names=names,
            acceleration=random.standard_normal((FAST_ROWS, N_CHANNELS)).astype(np.float32),
        )


def test_172_000_samples_a_second_arrive_whole_in_the_identifiers_buffer(
    tmp_path, processes, listen
):
    from oma_identifier.intake.sample_buffer import SampleBuffer
    from oma_identifier.intake.topic_intake import TopicIntake
    from oma_identifier.settings import IdentificationSettings

    path, topic = tmp_path / 'fast.mcap', '/acceleration_block'
    with RecordingWriter(path) as writer:
        for block in fast_blocks():
            for raw in encode(block, topic):
                writer.write(raw.topic, raw.message_type, raw.log_time_ns, raw.data)
    listener = listen({'/nothing': AccelerationBlock})
    listener.listen_raw(topic, AccelerationBlock)
    processes('replay', recording=str(path), exit_at_end=False)
    listener.spin(lambda: listener.raw)
    # Whatever the machine does meanwhile, every message comes.
    listener.spin(lambda: len(listener.raw) >= N_FAST, 120.0)
    intake = TopicIntake()
    buffer = SampleBuffer(IdentificationSettings(window_s=4.0))
    found = intake.decode(listener.raw, 'oma_msgs/msg/AccelerationBlock', topic)
    rows = np.concatenate([block.acceleration for block in found])
    wanted = np.concatenate([block.acceleration for block in fast_blocks()])
    assert np.array_equal(rows, wanted)
    for block in found:
        buffer.add(block)
    windows = [*buffer.windows(), *buffer.finish()]
    assert intake.n_refused == {} and buffer.counters.reasons == {}
    assert windows and all(window.quality.identifiable for window in windows)
    assert all(channel.n_lost == 0 for window in windows for channel in window.quality.channels)
