"""Joint states of a robot as feedback, and what its controller should be doing meanwhile."""

from collections import Counter, deque
from collections.abc import Callable, Sequence
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
    ReplyLatency,
    RobotFeedback,
    Verdict,
)
from robot_bridge.player import PlanPath
from structural_model.flexible_joint_model import FlexibleJointModel

MICROSECOND_NS, MILLISECOND_NS = 1000, 1_000_000
UINT32 = 1 << 32
POLL_S = 0.01
RATE_OF = 50


class SessionCounts:
    """What has been found wrong with the joint states, by code."""

    def __init__(self) -> None:
        self.counts: Counter[str] = Counter()


class JointLink:
    """Turns joint states into feedback; beside it, time passes for the watchdogs.

    Parameters
    ----------
    model : FlexibleJointModel
        Whose joints are looked for, by name.
    cycle_s : float [s]
        Period that steps are counted in.
    answer : callable
        ``(feedback, judgement, now_s, receipt_ns)``; nothing is replied.
    idle : callable
        Called with the time [s] every ``POLL_S``, for watchdogs.
    """

    def __init__(
        self,
        model: FlexibleJointModel,
        cycle_s: float,
        answer: Answer,
        idle: Callable[[float], None],
    ) -> None:
        self._model, self._cycle_s, self._answer, self._idle = model, cycle_s, answer, idle
        self.check, self.latency = SessionCounts(), ReplyLatency()
        self.n_received = self.n_sent = 0
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
        steps = [after - before for before, after in pairwise(self._stamps)]
        return (
            NANOSECONDS_PER_SECOND / statistics.median(steps) if len(steps) > RATE_OF // 2 else 0.0
        )

    def take(
        self, stamp_ns: int, names: Sequence[str], position: Sequence[float], receipt_ns: int
    ) -> None:
        """Take one message of joint states."""
        judgement = self._judge(stamp_ns, names, position)
        if self._closing.is_set() or judgement.verdict == Verdict.IGNORE:
            return
        self.refusal = ''
        self._stamps.append(stamp_ns)
        angles = dict(zip(names, position, strict=False))
        serial = np.array([angles[name] for name in self._model.joint_names])
        joints_deg = tuple(np.degrees(self._model.to_controller(serial)).tolist())
        playing = self._playing
        runs = playing is not None and stamp_ns >= playing[1]
        planned_deg, self._held_deg = self._held_deg or joints_deg, None
        if playing is not None and runs:
            elapsed_s = (stamp_ns - playing[1]) / NANOSECONDS_PER_SECOND
            planned_deg = tuple(playing[0].position(elapsed_s).tolist())
        self.n_received += 1
        self.feedback = RobotFeedback(
            seqno=self.n_received % UINT32,
            tm_ms=stamp_ns // MILLISECOND_NS % UINT32,
            joints_deg=joints_deg,
            planned_deg=planned_deg,
            time_us=stamp_ns // MICROSECOND_NS,
            # Not told by joint states: a controller with its motors off refuses the trajectory.
            motors_on=True,
            mci_state=MCI_RUNNING if runs else MCI_STOPPED,
            rapid_running=runs,
            converged=False,
        )
        self._answer(self.feedback, judgement, time.monotonic(), receipt_ns)

    def _judge(self, stamp_ns: int, names: Sequence[str], position: Sequence[float]) -> Judgement:
        """Tell what to do with a message."""
        missing = [name for name in self._model.joint_names if name not in names]
        if missing or len(position) != len(names):
            # Other joints of the cell have messages of their own.
            if len(missing) < len(self._model.joint_names):
                self._refuse(f'joint states without {", ".join(missing) or "positions"}')
            return self._ignore('other_joints')
        if not all(map(math.isfinite, position)) or stamp_ns <= 0:
            self._refuse('joint states without a stamp, or not finite')
            return self._ignore('rejected')
        last_ns = self._stamps[-1] if self._stamps else None
        if last_ns is None:
            return Judgement(Verdict.NEW_SESSION, 'first')
        if stamp_ns < last_ns - NANOSECONDS_PER_SECOND:
            self._stamps.clear()
            return Judgement(Verdict.NEW_SESSION, 'the clock of the joint states went back')
        if stamp_ns <= last_ns:
            return self._ignore('old')
        n_steps = max(1, round((stamp_ns - last_ns) / NANOSECONDS_PER_SECOND / self._cycle_s))
        return Judgement(Verdict.ACCEPT, n_steps=n_steps)

    def _refuse(self, reason: str) -> None:
        self.refusal = self.last_refusal = reason

    def _ignore(self, code: str) -> Judgement:
        self.check.counts[code] += 1
        return Judgement(Verdict.IGNORE, code)

    def _run(self) -> None:
        while not self._closing.wait(POLL_S):
            self._idle(time.monotonic())
