"""Guide as abb_libegm (C++) does, after its behaviour; the library itself cannot be had here.

From its public source (src/egm_base_interface.cpp, src/egm_controller_interface.cpp): a message
counts when all its parts are there; number 0 begins a session, and is answered with number 0 and
the feedback itself; every message is answered at once, with joints and the pose and, beside
them, joint and Cartesian speeds; the time in the header is always 0; the outer loop is asked only
while motors, program and EGM run, and has 24 ms to answer; connected is what counts on by number
and time.
"""

import math
import socket
import sys

from test.support.strict_peer import EgmRobot, EgmSensor, RUNNING

CORRECTION, DATA = 3, 2
RAMP_S, HZ = 1.0, 0.5


def complete(message):
    """All that the library parses is there."""
    header, parts = message.header, (message.feedBack, message.planned)
    return (
        all(header.HasField(name) for name in ('seqno', 'tm', 'mtype'))
        and header.mtype == DATA
        and all(
            message.HasField(name)
            for name in ('motorState', 'mciState', 'mciConvergenceMet', 'rapidExecState')
        )
        and all(
            len(part.joints.joints) == 6
            and part.cartesian.HasField('pos')
            and part.cartesian.HasField('orient')
            and part.HasField('time')
            for part in parts
        )
    )


def running(message):
    """Ask the outer loop: motors on, program and EGM running."""
    states = message.motorState.state, message.mciState.state, message.rapidExecState.state
    return states == (RUNNING['motors'], RUNNING['mci'], RUNNING['rapid'])


class LikeLibEgm:
    """One interface of the library with its demo's outer loop: a slow sine on one axis."""

    def __init__(self, by_deg):
        self.by_deg = by_deg
        self.seqno, self.initial, self.began_s = 0, None, None
        self.joints, self.speeds = None, [0.0] * 6
        self.n_sessions = self.n_incomplete = 0
        self.last = None

    def answer(self, data):
        """Return the reply to one datagram; None when a part is missing."""
        message = EgmRobot.FromString(data)
        if not complete(message):
            self.n_incomplete += 1
            return None
        first = self.last is None or message.header.seqno == 0
        self.seqno = 0 if first else self.seqno + 1
        if first:
            self.n_sessions += 1
            self.initial = self.joints = list(message.feedBack.joints.joints)
            self.speeds, self.began_s = [0.0] * 6, None
        elif running(message):
            self._outer_loop(message)
        self.last = message
        return self._reply(message.feedBack.cartesian)

    @property
    def away_deg(self):
        """How far the controller's own aim is from what it was asked for."""
        planned = self.last.planned.joints.joints
        return max(abs(a - b) for a, b in zip(self.joints, planned, strict=True))

    def _outer_loop(self, message):
        now_s = message.feedBack.time.sec + 1e-6 * message.feedBack.time.usec
        if self.began_s is None:
            self.began_s = now_s
        t = now_s - self.began_s
        grown = min(t / RAMP_S, 1.0) * self.by_deg
        angle = 2.0 * math.pi * HZ * t
        self.joints = list(self.initial)
        self.joints[4] += grown * math.sin(angle)
        self.speeds = [0.0] * 6
        self.speeds[4] = 2.0 * math.pi * HZ * grown * math.cos(angle)
        if t < RAMP_S:
            self.speeds[4] += self.by_deg / RAMP_S * math.sin(angle)

    def _reply(self, pose):
        reply = EgmSensor()
        reply.header.seqno, reply.header.tm, reply.header.mtype = self.seqno, 0, CORRECTION
        reply.planned.joints.joints.extend(self.joints)
        reply.planned.cartesian.CopyFrom(pose)
        reply.speedRef.joints.joints.extend(self.speeds)
        reply.speedRef.cartesians.value.extend([0.0] * 6)
        return reply.SerializeToString()


def main(port, most, by_deg):
    """Answer so many packets; print what the others print, then sessions and incomplete ones."""
    link = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    link.bind(('', port))
    link.settimeout(5.0)
    client, heard, asked, farthest = LikeLibEgm(by_deg), 0, 0, 0.0
    while heard < most:
        try:
            data, address = link.recvfrom(65536)
        except TimeoutError:
            break
        heard += 1
        reply = client.answer(data)
        if reply is not None:
            asked += link.sendto(reply, address) > 0
            farthest = max(farthest, client.away_deg)
    print(heard, asked, farthest, client.n_sessions, client.n_incomplete)


if __name__ == '__main__':
    main(int(sys.argv[1]), int(sys.argv[2]), float(sys.argv[3]))
