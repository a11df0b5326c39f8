"""An emulated controller on real UDP and a sensor that answers it, cycle by cycle: no clock."""

import select
import socket

import numpy as np

from abb_emulator.cell import CellSettings, MotorSide
from abb_emulator.egm.guidance_law import GuidanceSettings
from abb_emulator.egm.link_faults import LinkFaults
from abb_emulator.egm.udp_client import UdpClient
from abb_emulator.rapid.program_task import ProgramTask

SEED = 11


class LockstepSensor:
    """Controller with a module, and the socket its messages come to."""

    def __init__(self, model, start_deg, peers, text, settings=None):
        self.peers, self.model = peers, model
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.socket.bind(('127.0.0.1', 0))
        self.socket.setblocking(False)
        self.faults = LinkFaults(np.random.default_rng(SEED))
        self.client = UdpClient(self.socket.getsockname(), self.faults, '127.0.0.1')
        self.motors = MotorSide(
            model, start_deg, self.client, settings or CellSettings(seed=SEED), 100.0
        )
        self.controller = self.motors.controller
        self.task = ProgramTask(self.controller, GuidanceSettings(), np.random.default_rng(SEED))
        self.task.load(text)
        self.task.start()
        self.seqno = 0
        self.heard, self.planned, self.measured = [], [], []

    def cycle(self, position_deg=None, speed_deg_s=None):
        """Run one cycle; answer its message with references, or not at all."""
        self.motors.cycle()
        self.planned.append(self.controller.axes.planned_deg.copy())
        self.measured.append(self.controller.axes.measured_deg.copy())
        session = self.controller.session
        if session is None or not session.sending:
            return None
        if not select.select([self.socket], [], [], 0.0)[0]:
            return None
        data, address = self.socket.recvfrom(4096)
        message = self.peers.EgmRobot.FromString(data)
        self.heard.append(message)
        if position_deg is not None:
            reply = self.peers.EgmSensor()
            reply.header.seqno, reply.header.tm, reply.header.mtype = self.seqno, 0, 3
            self.seqno += 1
            reply.planned.joints.joints.extend(np.asarray(position_deg, float).tolist())
            if speed_deg_s is not None:
                reply.speedRef.joints.joints.extend(np.asarray(speed_deg_s, float).tolist())
            self.socket.sendto(reply.SerializeToString(), address)
            # Loopback hands a datagram over before sendto returns.
        return message

    def until(self, condition, position_deg=None, most=20_000):
        """Answer with a constant position until something holds."""
        for _ in range(most):
            if condition():
                return self
            self.cycle(position_deg)
        raise AssertionError('never came')

    def guided(self):
        session = self.controller.session
        return session is not None and session.phase.name == 'RUNNING'

    def close(self):
        self.client.close()
        self.socket.close()
