"""Joint states of a robot as feedback, and what its controller should be doing meanwhile."""

from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import replace
from itertools import pairwise
import math
import statistics
import threading
import time

import numpy as np

from modal_core.measurements import NANOSECONDS_PER_SECOND
from robot_bridge.egm import (
    Answer,
    Judgement,
    MCI_RUNNING,
    MCI_STOPPED,
    MICROSECONDS,
    ReplyLatency,
    RobotFeedback,
    SessionLimits,
    Verdict,
)
from robot_bridge.player import PlanPath
from robot_bridge.trajectory.states_check import StatesCheck
from structural_model.flexible_joint_model import FlexibleJointModel

MICROSECOND_NS, MILLISECOND_NS = 1000, 1_000_000
UINT32 = 1 << 32
POLL_S = 0.01
RATE_OF = 50
PEER = ('joint_states', 0)
WORDS = {
    'duplicate': 'come from two publishers',
    'out_of_order': 'come from two publishers',
    'time_runs_back': 'run back in time',
    'joint_jump': 'jump farther than the arm moves',
}
WHO = 'ros2 topic info -v joint_states tells who publishes them'


class JointLink:
    """Turns joint states into feedback; beside it, time passes for the watchdogs.

    Parameters
    ----------
    model : FlexibleJointModel
        Whose joints are looked for, by name.
    limits : SessionLimits
        What is believed; steps are counted in its period.
    answer : callable
        ``(feedback, judgement, now_s, receipt_ns)``; nothing is replied.
    alarm : callable
        Told why when joint states contradict each other.
    idle : callable
        Called with the time [s] every ``POLL_S``, for watchdogs.
    """

    def __init__(
        self,
        model: FlexibleJointModel,
        limits: SessionLimits,
        answer: Answer,
        alarm: Callable[[str], None],
        idle: Callable[[float], None],
    ) -> None:
        self._model, self._answer, self._alarm, self._idle = model, answer, alarm, idle
        self.check, self.latency = StatesCheck(limits), ReplyLatency()
        self.n_received = self.n_sent = self._n_whole = 0
        self.failure = self.last_refusal = self.refusal = ''
        self.real_time = False
        self.feedback: RobotFeedback | None = None
        self._playing: tuple[PlanPath, int] | None = None
        self._held_deg: tuple[float, ...] | None = None
        self._stamps: deque[int] = deque(maxlen=RATE_OF)
        self._closing = threading.Event()
        self._thread = threading.Thread(target=self._run, name='joint_link', daemon=True)

    def start(self) -> None:
        """Begin to watch the time."""
        self._thread.start()

    def close(self) -> None:
        """Watch no more, and take no more joint states."""
        self._closing.set()
        if self._thread.is_alive():
            self._thread.join(timeout=1.0)

    def begin(self, path: PlanPath, start_ns: int) -> None:
        """Expect the joints on a path that begins at a time of their stamps [ns]."""
        self._playing = (path, start_ns)

    def end(self, at_its_end: bool) -> None:
        """Expect nothing any more; at its end the controller holds where the path ends."""
        playing, self._playing = self._playing, None
        if playing is not None and at_its_end:
            self._held_deg = tuple(playing[0].position(playing[0].duration_s).tolist())

    @property
    def update_rate_hz(self) -> float:
        """Rate of the joint states [Hz]; 0 before there are some."""
        # Copied at once: joint states come on a thread of their own.
        stamps = tuple(self._stamps)
        steps = [after - before for before, after in pairwise(stamps)]
        return (
            NANOSECONDS_PER_SECOND / statistics.median(steps) if len(steps) > RATE_OF // 2 else 0.0
        )

    def take(
        self,
        stamp_ns: int,
        names: Sequence[str],
        position: Sequence[float],
        receipt_ns: int,
        number: int | None = None,
    ) -> None:
        """Take one message of joint states.

        Parameters
        ----------
        stamp_ns, receipt_ns : int [ns]
            Of its header; when it came.
        names, position : sequence of str, of float [rad]
            As in the message.
        number : int or None
            Which one of its publisher's messages it is; None where the middleware does not tell.
        """
        if self._closing.is_set() or not self._is_whole(stamp_ns, names, position):
            return
        self._n_whole += 1
        feedback = self._feedback(stamp_ns, names, position, number)
        now_s, before = time.monotonic(), self.feedback
        judgement = self.check.feedback(feedback, PEER, now_s)
        if judgement.verdict in (Verdict.ALARM, Verdict.IGNORE):
            self._set_aside(judgement)
            return
        self.refusal = ''
        if judgement.verdict == Verdict.NEW_SESSION:
            self._stamps.clear()
        elif before is not None:
            passed_s = (feedback.time_us - before.time_us) / MICROSECONDS
            n_steps = max(1, round(passed_s / self.check.limits.cycle_s))
            judgement = replace(judgement, n_steps=n_steps)
        self._stamps.append(stamp_ns)
        self.n_received += 1
        self.feedback = self._beside_the_plan(feedback, stamp_ns)
        self._answer(self.feedback, judgement, now_s, receipt_ns)

    def _feedback(
        self, stamp_ns: int, names: Sequence[str], position: Sequence[float], number: int | None
    ) -> RobotFeedback:
        angles = dict(zip(names, position, strict=False))
        serial = np.array([angles[name] for name in self._model.joint_names])
        joints_deg = tuple(np.degrees(self._model.to_controller(serial)).tolist())
        return RobotFeedback(
            seqno=(self._n_whole if number is None else number) % UINT32,
            tm_ms=stamp_ns // MILLISECOND_NS % UINT32,
            joints_deg=joints_deg,
            planned_deg=joints_deg,
            time_us=stamp_ns // MICROSECOND_NS,
            # Not told by joint states: a controller with its motors off refuses the trajectory.
            motors_on=True,
            mci_state=MCI_STOPPED,
            rapid_running=False,
            converged=False,
        )

    def _beside_the_plan(self, feedback: RobotFeedback, stamp_ns: int) -> RobotFeedback:
        """Return feedback with what its controller should be doing at that time."""
        held_deg, self._held_deg = self._held_deg, None
        playing = self._playing
        if playing is None or stamp_ns < playing[1]:
            return feedback if held_deg is None else replace(feedback, planned_deg=held_deg)
        elapsed_s = (stamp_ns - playing[1]) / NANOSECONDS_PER_SECOND
        planned_deg = tuple(playing[0].position(elapsed_s).tolist())
        return replace(
            feedback, planned_deg=planned_deg, mci_state=MCI_RUNNING, rapid_running=True
        )

    def _is_whole(self, stamp_ns: int, names: Sequence[str], position: Sequence[float]) -> bool:
        """Tell whether a message has all that is needed of these joints."""
        missing = [name for name in self._model.joint_names if name not in names]
        if missing or len(position) != len(names):
            # Other joints of the cell have messages of their own.
            if len(missing) < len(self._model.joint_names):
                self._refuse(f'joint states without {", ".join(missing) or "positions"}')
            self.check.counts['other_joints'] += 1
            return False
        if not all(map(math.isfinite, position)) or stamp_ns <= 0:
            self._refuse('joint states without a stamp, or not finite')
            self.check.refuse_content()
            return False
        return True

    def _set_aside(self, judgement: Judgement) -> None:
        """Take nothing of a message; one that contradicts others is told."""
        if judgement.verdict == Verdict.ALARM:
            self._refuse(f'joint states {WORDS[judgement.reason]}')
            self._alarm(f'{self.refusal}; {WHO}')

    def _refuse(self, reason: str) -> None:
        self.refusal = self.last_refusal = reason

    def _run(self) -> None:
        while not self._closing.wait(POLL_S):
            self._idle(time.monotonic())
