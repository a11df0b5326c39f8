"""Following a program of the controller by its position stream, without moving anything.

The stream begins when the program has reached the start pose and ends with the program, so silence
is no fault before it and after it.
"""

from collections.abc import Callable
import math
import threading

import numpy as np

from robot_bridge.egm import Judgement, RobotFeedback, Verdict
from robot_bridge.operator.flow_settings import FlowSettings, FlowState
from robot_bridge.operator.operator_flow import OperatorFlow
from robot_bridge.player import Reference

LONGEST_WAIT_S = 120.0
LONGEST_STOP_S = 10.0
PENDANT = 'use the pendant: the bridge has no way to stop the program'
# Moves of a real controller are not exactly as long as planned.
SHORTEST_PART = 0.9
# A fine point is reached but for the digits of the module.
END_DEG = 0.01


class StreamFlow(OperatorFlow):
    """The operator flow of a program that runs in the controller.

    Parameters
    ----------
    settings : FlowSettings
        Limits.
    """

    def __init__(self, settings: FlowSettings) -> None:
        super().__init__(settings)
        self.stop_program: Callable[[], None] | None = None
        self._began_s = math.inf
        self._wait_until_s = math.inf
        self._streamed_s = 0.0
        self._stopping: threading.Thread | None = None

    def start(self, now_s: float, token: str) -> None:
        """Expect the armed plan's program to run.

        Raises
        ------
        BridgeError
            Not armed, not the token of the release, or no heartbeat.
        """
        with self._lock:
            self._check_released(now_s, token)
            self._began_s, self._streamed_s = math.inf, 0.0
            self._wait_until_s = now_s + LONGEST_WAIT_S
            by_hand = self.stop_program is None
            who = 'start it at the pendant' if by_hand else 'it is being started'
            self._enter(FlowState.RUNNING, f'waiting for the program: {who}')

    def abort(self, reason: str) -> None:
        """Latch, and have the program stopped; where there is no way to, tell who can.

        Asked again while a program still runs, it is stopped again.
        """
        with self._lock:
            heard = self.feedback is not None and self.feedback.rapid_running
            may_run = self.state == FlowState.RUNNING or heard
            if may_run and self.stop_program is None:
                reason = f'{reason}; {PENDANT}'
                if self.state == FlowState.ABORTED:
                    self.note(PENDANT)
            super().abort(reason)
            if self.stop_program is None:
                return
            if may_run and not self.stopping:
                # The network must not hold up the thread that listens.
                self._stopping = threading.Thread(
                    target=self.stop_program, name='stop_program', daemon=True
                )
                self._stopping.start()

    @property
    def stopping(self) -> bool:
        """Whether the controller is being asked to stop its program and has not answered."""
        return self._stopping is not None and self._stopping.is_alive()

    def settle(self) -> None:
        """Wait until the controller has answered a stop it is being asked for."""
        stopping = self._stopping
        if stopping is not None:
            stopping.join(LONGEST_STOP_S)

    def on_feedback(
        self, feedback: RobotFeedback, judgement: Judgement, now_s: float
    ) -> Reference | None:
        """Take one packet of the stream; the reply is always None."""
        with self._lock:
            self._watch(now_s)
            self.feedback, self._heard_s = feedback, now_s
            self._hold = np.array(feedback.planned_deg)
            if self.state == FlowState.DISCONNECTED:
                self._enter(FlowState.IDLE, 'the stream is heard')
            if self.state == FlowState.RUNNING:
                self._follow(feedback, judgement, now_s)
            return None

    @property
    def progress(self) -> float:
        """Fraction of the plan's duration streamed."""
        if self.state == FlowState.HOLDING:
            return 1.0
        duration_s = self.path.duration_s if self.path is not None else math.inf
        return min(self._streamed_s / duration_s, 1.0)

    def _follow(self, feedback: RobotFeedback, judgement: Judgement, now_s: float) -> None:
        path = self.path
        begins = self._began_s == math.inf
        if path is None or (begins and not feedback.rapid_running):
            return
        if begins:
            distance = np.abs(np.array(feedback.joints_deg) - path.start_deg)
            if distance.max() > self.settings.start_tolerance_deg:
                axis = int(np.argmax(distance)) + 1
                self.abort(f'the program began with axis {axis} away from the start of the plan')
                return
            self._began_s = now_s
            self._follow_plan(path, np.array(feedback.planned_deg), feedback)
            self._enter(FlowState.RUNNING, 'the program is running')
        elif judgement.verdict == Verdict.NEW_SESSION:
            self.abort(f'the session began anew: {judgement.reason}')
        elif not feedback.motors_on:
            self.abort('motors are off')
        elif not feedback.rapid_running:
            self._end('the program has stopped')
        else:
            planned_deg = np.array(feedback.planned_deg)
            self._watch_following(planned_deg, feedback, judgement.n_steps)
        self._streamed_s = now_s - self._began_s

    def _watch(self, now_s: float) -> None:
        silence_s = now_s - self._heard_s
        silent = self._heard_s > -math.inf and silence_s > self.settings.link_timeout_s
        if silent:
            self._heard_s, self.feedback = -math.inf, None
            if self.state == FlowState.RUNNING and self._began_s < math.inf:
                self._end(f'link lost: no feedback for {1e3 * silence_s:.0f} ms')
            elif self.state in (FlowState.IDLE, FlowState.HOLDING):
                self._enter(FlowState.DISCONNECTED, 'no stream: none is sent before the program')
        if self.state == FlowState.ARMED and self.release.over(now_s):
            self._enter(FlowState.DISCONNECTED, 'the release timed out')
        if self.state == FlowState.RUNNING and self._heartbeat_lost(now_s):
            self.abort('the operator heartbeat is lost')
        if self.state == FlowState.RUNNING and self._began_s == math.inf:
            if now_s > self._wait_until_s:
                self.abort('the program was not started in time')

    def _end(self, reason: str) -> None:
        """Take the stream's end for the program's end when it is about time, and at its end."""
        if self.progress >= SHORTEST_PART and self._at_the_end():
            self._enter(FlowState.HOLDING, 'the program is at its end')
        else:
            self.abort(reason)

    def _at_the_end(self) -> bool:
        """Tell whether the controller holds where the plan ends."""
        path, hold = self.path, self._hold
        if path is None or hold is None:
            return False
        return bool(np.abs(hold - path.position(path.duration_s)).max() <= END_DEG)

    def _may_arm(self) -> bool:
        return super()._may_arm() or self.state == FlowState.DISCONNECTED
