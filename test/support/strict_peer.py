"""A controller that trusts nothing: sends one packet a cycle and finds fault with every reply.

It shares no code with the bridge: its messages come from egm.proto in this folder.
"""

import math
from pathlib import Path
import socket
import threading
import time

from test.support import proto_text

CLASSES = proto_text.classes(Path(__file__).with_name('egm.proto').read_text())
EgmRobot, EgmSensor = CLASSES['EgmRobot'], CLASSES['EgmSensor']
CYCLE_S = 0.004032
SAFETY_JOINT_STEP_DEG = 0.6  # 130 deg/s in one cycle
RUNNING = {'motors': 1, 'mci': 3, 'rapid': 2}


def faults_of(data, seqno, tm_ms):
    """Return what is wrong with a reply, and the reply; seqno is the one it must have."""
    try:
        reply = EgmSensor.FromString(data)
    except Exception as error:  # noqa: BLE001 any error at all is the sender's fault
        return [f'cannot be parsed: {error}'], None
    faults = [
        *missing_fields(reply),
        *header_faults(reply.header, seqno, tm_ms),
        *joint_faults(reply),
    ]
    if reply.SerializeToString(deterministic=True) != data:
        faults.append('not the canonical proto2 bytes (packed, unknown or repeated fields)')
    return faults, reply


def missing_fields(reply):
    for name in ('header', 'planned', 'speedRef'):
        if not reply.HasField(name):
            yield f'{name} missing'
    for name in ('seqno', 'tm', 'mtype'):
        if not reply.header.HasField(name):
            yield f'header.{name} missing'


def header_faults(header, seqno, tm_ms):
    if header.seqno != seqno:
        yield f'seqno {header.seqno}, not {seqno}'
    if header.mtype != 3:
        yield f'mtype {header.mtype}, not CORRECTION'
    if tm_ms is not None and header.tm < tm_ms:
        yield f'tm ran back from {tm_ms} to {header.tm}'


def joint_faults(reply):
    for name, values in (
        ('planned', reply.planned.joints.joints),
        ('speedRef', reply.speedRef.joints.joints),
    ):
        if len(values) != 6 or not all(math.isfinite(value) for value in values):
            yield f'{name}: {list(values)}'
    for name in ('cartesian', 'externalJoints'):
        if reply.planned.HasField(name):
            yield f'planned.{name} must stay empty in joint guidance'


class StrictPeer:
    """Guides an ideal arm by what the bridge answers, in lockstep with it.

    Each cycle waits for its reply, so that a busy machine slows the cycle and breaks nothing. A
    reply that comes after its cycle gave up is judged and followed like any other; what no
    lateness excuses is one more reply than packets.
    """

    def __init__(self, start_deg, bridge, address='127.0.0.1', patience_s=2.0):
        self.joints_deg = list(start_deg)
        self.state = dict(RUNNING)
        self.bridge, self.patience_s = bridge, patience_s
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.socket.bind((address, 0))
        self.seqno, self.reply_seqno, self.reply_tm = 0, 0, None
        self.faults, self.replies, self.history = [], [], []
        self.expect_reply = True
        self.n_sent = self.n_silent = 0
        self._closing = threading.Event()
        self._thread = None

    def packet(self, **changes):
        """Return the bytes of this cycle's message; changes set single fields."""
        message = EgmRobot()
        message.header.seqno = changes.get('seqno', self.seqno)
        message.header.tm = changes.get('tm', round(self.seqno * CYCLE_S * 1000.0))
        message.header.mtype = 2
        joints = changes.get('joints', self.joints_deg)
        for part in (message.feedBack, message.planned):
            part.joints.joints.extend(joints)
            part.cartesian.pos.x, part.cartesian.pos.y, part.cartesian.pos.z = 1626.0, 0.0, 1740.0
            orient = part.cartesian.orient
            orient.u0, orient.u1, orient.u2, orient.u3 = 1.0, 0.0, 0.0, 0.0
            microseconds = round(self.seqno * CYCLE_S * 1e6)
            part.time.sec, part.time.usec = divmod(microseconds, 1_000_000)
        message.motorState.state = self.state['motors']
        message.mciState.state = self.state['mci']
        message.rapidExecState.state = self.state['rapid']
        message.mciConvergenceMet = False
        message.utilizationRate = 0.0
        return message.SerializeToString()

    def cycle(self):
        """Send one packet and take its one reply, and before it any that came late."""
        self.socket.setblocking(False)
        while (late := self._receive()) is not None:
            self._judge(late)
        self.socket.settimeout(self.patience_s if self.expect_reply else 0.02)
        self.socket.sendto(self.packet(), self.bridge)
        self.seqno += 1
        self.n_sent += 1
        data, speed = self._receive(), None
        if data is None:
            self.n_silent += 1
        elif (reply := self._judge(data)) is not None:
            speed = tuple(reply.speedRef.joints.joints)
        self.history.append((time.monotonic(), tuple(self.joints_deg), speed))

    def _receive(self):
        try:
            data, address = self.socket.recvfrom(4096)
        except (TimeoutError, BlockingIOError):
            return None
        if address != self.bridge:
            self.faults.append(f'reply from {address}')
        return data

    def _judge(self, data):
        """Find fault with the next reply, whenever it came, and do as it says."""
        if self.reply_seqno >= self.n_sent:
            self.faults.append(f'a second reply: {data!r}')
        faults, reply = faults_of(data, self.reply_seqno, self.reply_tm)
        self.faults += [f'reply {self.reply_seqno}: {fault}' for fault in faults]
        self.reply_seqno += 1
        if reply is not None:
            self.reply_tm = reply.header.tm
            self.replies.append(reply)
            self._follow(list(reply.planned.joints.joints), list(reply.speedRef.joints.joints))
        return reply

    def _follow(self, position, speed):
        if self.state != RUNNING:
            return
        for axis, (wanted, rate) in enumerate(zip(position, speed, strict=True)):
            target = wanted + rate * CYCLE_S
            if abs(target - self.joints_deg[axis]) > SAFETY_JOINT_STEP_DEG:
                self.faults.append(f'axis {axis + 1} asked to jump by {target - wanted:.3f} deg')
                continue
            self.joints_deg[axis] = target

    def run(self, cycles):
        """Run some cycles, none faster than the controller's own."""
        for _ in range(cycles):
            begin_s = time.monotonic()
            self.cycle()
            time.sleep(max(0.0, CYCLE_S - (time.monotonic() - begin_s)))
        return self

    @property
    def running(self):
        return self._thread is not None

    def start(self):
        """Run in a thread of its own until closed."""
        self._thread = threading.Thread(target=self._loop, daemon=True)
        self._thread.start()
        return self

    def _loop(self):
        while not self._closing.is_set():
            self.run(1)

    def pause(self):
        """Stop the thread; the socket stays."""
        self._closing.set()
        if self._thread is not None:
            self._thread.join()
        self._closing.clear()
        self._thread = None
        return self

    def close(self):
        self.pause()
        self.socket.close()
