"""Bridge and emulated controller over real UDP, cycle by cycle: no clock decides the outcome."""

import time

import numpy as np

from benchmarks.faults.guided_arm import GUIDANCE, GuidedArm
from excitation_planner.motion.trajectory import Trajectory
from robot_bridge.egm.session_check import SessionLimits
from robot_bridge.operator import FlowSettings
from robot_bridge.player.plan_path import PlanPath


class Loop(GuidedArm):
    """An emulated controller and a bridge on loopback, in lockstep."""

    def __init__(self, guidance=GUIDANCE, **flow):
        asked = {'dry_run': False, 'link_timeout_s': 1.0, 'heartbeat_timeout_s': 0.0, **flow}
        super().__init__(
            np.random.default_rng(3),
            FlowSettings(**asked),
            SessionLimits(controller_address='127.0.0.1', silence_s=5.0),
            guidance,
        )
        self.planned, self.measured = [], []

    def run(self, cycles, wait=True):
        for _ in range(cycles):
            before = self.link.n_received + self.link.check.counts['rejected']
            self.motors.cycle()
            self.planned.append(self.controller.axes.planned_deg.copy())
            self.measured.append(self.controller.axes.measured_deg.copy())
            session = self.controller.session
            deadline = time.monotonic() + 2.0
            while wait and session is not None and session.sending:
                if self.link.n_received + self.link.check.counts['rejected'] > before:
                    break
                assert time.monotonic() < deadline, 'no answer from the bridge'
                time.sleep(1e-5)
            if wait:
                time.sleep(2e-4)  # the reply leaves after the count
        return self

    def go(self, path):
        self.flow.offer(path)
        token = self.flow.arm(path.plan_hash, 30.0, time.monotonic())
        self.flow.start(time.monotonic(), token)
        return self


def sine(loop, hz, amplitude_deg=0.05, duration_s=4.0):
    t = np.arange(0.0, duration_s, 0.004)
    speed = np.radians(amplitude_deg) * 2 * np.pi * hz * np.cos(2 * np.pi * hz * t)
    speed *= np.clip(np.minimum(t, t[-1] - t) / 0.5, 0.0, 1.0)
    velocity = np.zeros((len(t), 6))
    velocity[:, 0] = speed
    start = loop.model.pose('P1')
    trajectory = Trajectory.from_velocity(start, velocity, 0.004)
    return PlanPath.from_trajectory('sine', trajectory, loop.model.to_controller)
