"""Where a cell stands, and the next step of whoever is at the robot; no ROS."""

from dataclasses import dataclass
from enum import Enum

from robot_bridge.operator import AWAY, FlowState

RUNNING = 'running'
EMULATOR = 'emulator'
SILENT, NOT_YET = 'no feedback', 'no feedback yet'
"""Reasons of a bridge that guides: the session has ended, or none has been."""
STATES_S = 3.0
"""A bridge tells its state ten times a second; silent for so long it is gone."""


@dataclass(frozen=True, slots=True)
class Situation:
    """What the bridge said last.

    Parameters
    ----------
    state : FlowState
        Of the bridge.
    reason : str
        Why it is in it.
    backend, controller : str
        How an arm is moved, and which.
    dry_run, connected, motors_on : bool
        Nothing is sent; the controller is heard; its motors are on.
    controller_state : str
        Of its session.
    plan_hash : str
        Plan in hand; empty for none.
    progress : float
        0..1 of the plan.
    heard_s : float [s]
        When it was heard, monotonic clock.
    """

    state: FlowState
    reason: str
    backend: str
    controller: str
    dry_run: bool
    connected: bool
    motors_on: bool
    controller_state: str
    plan_hash: str
    progress: float
    heard_s: float

    @property
    def emulated(self) -> bool:
        """No real arm can move."""
        return self.backend == EMULATOR

    @property
    def ready(self) -> bool:
        """The controller would follow."""
        return self.motors_on and self.controller_state == RUNNING


class Act(Enum):
    """What the tool can do about it when it is told to."""

    WAIT = 'wait'
    RELEASE = 'release'
    RESET = 'reset'
    MOTORS = 'motors'
    PROGRAM = 'program'
    WAY_BACK = 'way back'


@dataclass(frozen=True, slots=True)
class Step:
    """The next step.

    Parameters
    ----------
    act : Act
        What may be done.
    words : str
        What is the matter and what to do.
    """

    act: Act
    words: str


def next_step(situation: Situation | None, now_s: float) -> Step:
    """Return the next step towards a motion."""
    if situation is None or now_s - situation.heard_s > STATES_S:
        return Step(Act.WAIT, 'no bridge is heard; next: start one, for example by ama up')
    state, reason = situation.state, situation.reason
    if state == FlowState.ABORTED:
        return Step(
            Act.RESET, f'stopped and latched: {reason}; next: reset it, which moves nothing'
        )
    if state in (FlowState.RUNNING, FlowState.STOPPING):
        return Step(Act.WAIT, f'the arm is moving: {reason}; next: wait for its end')
    if not situation.plan_hash:
        return Step(
            Act.WAIT,
            'no plan in hand; next: wait for the planner; /diagnostics says PLAN_REFUSED and why'
            ' when the bridge did not take it',
        )
    if reason.startswith(SILENT) and not reason.startswith(NOT_YET):
        return Step(
            Act.PROGRAM,
            f'the controller is silent ({reason}); next: start the guidance program'
            f' {_where(situation)}',
        )
    if situation.dry_run or not situation.connected:
        # A program is not heard before it runs: the bridge says whether it may be released.
        return Step(Act.RELEASE, reason)
    if not situation.motors_on:
        return Step(Act.MOTORS, f'motors are off; next: switch them on {_where(situation)}')
    if not situation.ready and situation.backend != 'abb_rapid':
        return Step(
            Act.PROGRAM,
            f'the EGM session is {situation.controller_state}; next: start the guidance program'
            f' {_where(situation)}',
        )
    if AWAY in reason:
        return Step(
            Act.WAY_BACK,
            f'{reason}; next: the slow way back as a plan of its own, to be released like any',
        )
    return Step(Act.RELEASE, reason)


def _where(situation: Situation) -> str:
    return 'of the emulated controller' if situation.emulated else 'at the controller'
