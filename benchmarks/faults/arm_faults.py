"""Faults of link, controller and operator while an arm is guided: does it stay where it may be?

Bridge and emulated controller speak over real UDP at the controller's pace.  The arm's own motion
is watched, not what anybody says of it.
"""

from collections.abc import Callable
from dataclasses import replace
import socket
import time

import numpy as np
from numpy.typing import NDArray

from benchmarks.faults.guided_arm import COASTS_S, CYCLE_S, GuidedArm
from excitation_planner.motion.trajectory import Trajectory
from modal_core.errors import BridgeError
from robot_bridge.egm import EgmRobot, SessionLimits
from robot_bridge.operator import FlowSettings, FlowState
from robot_bridge.player import PlanPath

BEAT_CYCLES = 12
LINK_S = 0.1
RUN_S, FAULT_S, STOPPED_S = 3.0, 1.2, 1.0
"""Length of a run, when the fault comes, and how long after it everything must stand."""
STILL_DEG = 2e-3
"""Range of an axis that counts as standstill: servo noise and rounding."""
BEYOND_DEG = 0.05
"""How far an axis may leave the plan's range: what the servo overshoots (measured: 0.01)."""


class ArmRun(GuidedArm):
    """One run of a short plan.

    Attributes
    ----------
    measured : list of (6,) array [deg]
        Where the axes were, cycle by cycle.
    states : list of FlowState
        Of the bridge.
    """

    def __init__(self, rng: np.random.Generator) -> None:
        # Python paces the controller here: on a busy machine a cycle may be late.
        super().__init__(
            rng,
            FlowSettings(dry_run=False, link_timeout_s=LINK_S),
            SessionLimits(controller_address='127.0.0.1'),
        )
        self.rng = rng
        self.beats, self.beat_token = True, ''
        self.measured: list[NDArray[np.float64]] = []
        self.states: list[FlowState] = []
        self.path = self._plan()

    def _plan(self) -> PlanPath:
        time_s = np.arange(0.0, RUN_S, 0.004)
        fade = np.clip(np.minimum(time_s, time_s[-1] - time_s) / 0.5, 0.0, 1.0)
        hz, amplitude = self.rng.uniform(2.0, 15.0, 6), self.rng.uniform(0.01, 0.06, 6)
        speed = np.radians(amplitude) * 2 * np.pi * hz * np.cos(2 * np.pi * np.outer(time_s, hz))
        trajectory = Trajectory.from_velocity(self.model.pose('P1'), speed * fade[:, None], 0.004)
        return PlanPath.from_trajectory('random', trajectory, self.model.to_controller)

    def run(self, duration_s: float) -> None:
        """Let the controller go through its cycles at its own pace."""
        begin = time.monotonic()
        for cycle in range(round(duration_s / CYCLE_S)):
            if self.beats and cycle % BEAT_CYCLES == 0:
                self.flow.heartbeat(time.monotonic(), self.beat_token)
            self.motors.cycle()
            self.measured.append(self.controller.measured_deg.copy())
            self.states.append(self.flow.state)
            time.sleep(max(0.0, begin + (cycle + 1) * CYCLE_S - time.monotonic()))

    def go(self) -> None:
        """Release and start the plan."""
        self.flow.offer(self.path)
        self.beat_token = self.flow.arm(self.path.plan_hash, 30.0, time.monotonic())
        self.flow.heartbeat(time.monotonic(), self.beat_token)
        self.flow.start(time.monotonic(), self.beat_token)


Fault = Callable[[ArmRun], None]


def heartbeat_lost(run: ArmRun) -> None:
    """The operator lets go."""
    run.beats = False


def heartbeat_of_another(run: ArmRun) -> None:
    """The operator lets go while somebody else holds."""
    run.beat_token = 'somebody-else'


def emergency_stop(run: ArmRun) -> None:
    """Somebody presses the button."""
    run.controller.emergency_stop()


def motors_off(run: ArmRun) -> None:
    """The motors go off."""
    run.controller.motors_off()


def collision(run: ArmRun) -> None:
    """Motion supervision stops the arm."""
    run.controller.collide()


def session_restarts(run: ArmRun) -> None:
    """The session begins anew."""
    run.controller.restart_session()


def feedback_frozen(run: ArmRun) -> None:
    """The joints in the packets stand still, everything else goes on."""
    held: list[EgmRobot] = []

    def freeze(data: bytes) -> list[bytes]:
        message = EgmRobot.FromString(data)
        held.append(message)
        frozen = EgmRobot.FromString(data)
        frozen.feedBack.joints.CopyFrom(held[0].feedBack.joints)
        del held[1:]
        return [frozen.SerializeToString()]

    run.client.spoil = freeze


def link_cut(run: ArmRun) -> None:
    """No packet arrives any more."""
    run.client.spoil = lambda _: []


def replayed(run: ArmRun) -> None:
    """Packets of a while ago arrive instead."""
    old = [packet.data for packet in run.packets if not packet.sent][:200]
    run.client.spoil = lambda _: [old[int(run.rng.integers(len(old)))]]


def second_sender(run: ArmRun) -> None:
    """Another port of the controller's host sends packets as well."""
    other = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)

    def both(data: bytes) -> list[bytes]:
        other.sendto(data, run.link.address)
        return [data]

    run.client.spoil = both


def bytes_changed(run: ArmRun) -> None:
    """Every fifth packet has bits changed."""

    def change(data: bytes) -> list[bytes]:
        if run.rng.random() < 0.2:
            spoiled = bytearray(data)
            for place in run.rng.integers(0, len(data), 3):
                spoiled[place] ^= 1 << int(run.rng.integers(8))
            return [bytes(spoiled)]
        return [data]

    run.client.spoil = change


def link_loses(run: ArmRun) -> None:
    """Packets are lost, sent twice or overtaken, both ways."""
    for side in (run.faults.robot, run.faults.sensor):
        side.drop, side.duplicate, side.reorder = run.rng.uniform(0.0, 0.3, 3)


def link_delays(run: ArmRun) -> None:
    """Packets are late."""
    side = [run.faults.robot, run.faults.sensor][run.rng.integers(2)]
    side.delay_s = float(run.rng.uniform(0.005, 0.3))


def unreleased_plan(run: ArmRun) -> None:
    """Another plan arrives, and somebody tries to start it."""
    for attempt in (
        lambda: run.flow.offer(replace(run.path, plan_hash='another')),
        lambda: run.flow.arm('another', 30.0, time.monotonic()),
        lambda: run.flow.start(time.monotonic(), 'guessed'),
    ):
        try:
            attempt()
        except BridgeError:
            continue


STOPS: tuple[Fault, ...] = (
    heartbeat_lost,
    heartbeat_of_another,
    emergency_stop,
    motors_off,
    collision,
    session_restarts,
    feedback_frozen,
    link_cut,
    replayed,
    second_sender,
)
"""What must end the motion."""
MAY_GO_ON: tuple[Fault, ...] = (bytes_changed, link_loses, link_delays, unreleased_plan)
ARM_FAULTS = STOPS + MAY_GO_ON


def arm_run(rng: np.random.Generator, fault: Fault) -> tuple[str, list[str]]:
    """Run a plan into a fault.

    Returns
    -------
    tuple of str and list of str
        Last state of the bridge and why; what went wrong, one statement each.
    """
    run = ArmRun(rng)
    try:
        run.run(0.3)
        resting = len(run.measured)
        try:
            run.go()
        except BridgeError as error:
            return f'not started: {error}', []
        run.run(FAULT_S)
        fault(run)
        at = len(run.measured)
        run.run(STOPPED_S)
        stopped = len(run.measured)
        run.beats = run.beats and fault in MAY_GO_ON
        run.run(0.5)
        wrong = _wrong(run, fault, resting, at, stopped)
    finally:
        run.close()
    return f'{run.flow.state.name}: {run.flow.reason}', wrong


def _wrong(run: ArmRun, fault: Fault, resting: int, at: int, stopped: int) -> list[str]:
    measured = np.array(run.measured)
    wrong = []
    if np.ptp(measured[:resting], axis=0).max() > STILL_DEG:
        wrong.append('moved before it was released')
    reach = np.array(
        [run.path.position(time_s) for time_s in np.arange(0.0, run.path.duration_s, 0.004)]
    )
    speed = np.abs(np.diff(reach, axis=0)).max(axis=0) / 0.004
    may = BEYOND_DEG + COASTS_S * speed
    beyond = max(
        float((reach.min(axis=0) - measured.min(axis=0) - may).max()),
        float((measured.max(axis=0) - reach.max(axis=0) - may).max()),
    )
    if beyond > 0.0:
        wrong.append(f'left the range of the plan by {beyond:.3f} deg more than it may coast')
    if fault not in STOPS:
        return wrong
    if run.flow.state == FlowState.RUNNING:
        wrong.append('the bridge goes on')
    moved = float(np.ptp(measured[stopped:], axis=0).max())
    if moved > STILL_DEG:
        wrong.append(f'still moves {STOPPED_S:g} s after the fault, by {moved:.4f} deg')
    return wrong
