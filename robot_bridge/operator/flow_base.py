"""What every flow has: its state, who holds, and what ends a motion whatever else happens."""

from collections.abc import Callable
import math
import threading

import numpy as np
from numpy.typing import NDArray

from modal_core.errors import BridgeError
from robot_bridge.egm import RobotFeedback
from robot_bridge.operator.flow_settings import check_fraction, FlowSettings, FlowState
from robot_bridge.operator.release import Release
from robot_bridge.player import PlanPath, PlanPlayer

Array = NDArray[np.float64]
AWAY = 'away from the start of the plan'
"""Begins what a bridge says of an arm that stands elsewhere."""


class FlowBase:
    """The state and its ends; nothing here begins a motion.

    Parameters
    ----------
    settings : FlowSettings
        Limits.

    Attributes
    ----------
    hear : callable
        Takes the beats that have come and tells them to :meth:`heartbeat`; called with the lock,
        so that they come in their order.
    on_change : callable
        Told every state that is entered and why; called in the thread that enters it.
    """

    def __init__(self, settings: FlowSettings) -> None:
        self.settings = settings
        self.state = FlowState.DISCONNECTED
        self.reason = 'no feedback yet'
        self.path: PlanPath | None = None
        self.feedback: RobotFeedback | None = None
        self.active, self.muted = True, False
        self.clash = ''
        self.release = Release()
        self.hear: Callable[[], None] = lambda: None
        self.on_change: Callable[[FlowState, str], None] = lambda *_: None
        self._lock = threading.RLock()
        self._player: PlanPlayer | None = None
        self._hold: Array | None = None
        self._override = 1.0
        self._heard_s = -math.inf

    def abort(self, reason: str) -> None:
        """Slow down to standstill, hold, and latch; harmless at standstill."""
        with self._lock:
            if self.state != FlowState.ABORTED:
                if self._player is not None:
                    self._player.stop()
                self._enter(FlowState.ABORTED, reason)

    def note(self, text: str) -> None:
        """Add to the reason of the state what the operator must know, once."""
        with self._lock:
            if text not in self.reason:
                self._enter(self.state, f'{self.reason}; {text}')

    def activate(self) -> None:
        """Let plans be released and packets be answered."""
        with self._lock:
            self.active, self.muted = True, False

    def mute(self) -> None:
        """Answer no more packets; only for an arm at rest."""
        with self._lock:
            self.muted = True

    def deactivate(self) -> None:
        """Stop what moves and release nothing more; still to be muted once the arm is at rest."""
        with self._lock:
            if self.state == FlowState.RUNNING:
                self.abort('the bridge is being deactivated')
            elif self.state == FlowState.ARMED:
                self._enter(FlowState.IDLE, 'the bridge is being deactivated')
            self.active = False

    def settle(self) -> None:
        """Wait until an abort has done everything it does beside the cycle."""

    def listen(self) -> None:
        """Take the beats that have come."""
        with self._lock:
            self.hear()

    def heartbeat(self, now_s: float, token: str, number: int | None = None) -> None:
        """Note that the operator who has this token holds to run; see :meth:`Release.beat`."""
        with self._lock:
            timeout_s = self.settings.heartbeat_timeout_s
            one = self.release.beat(token, number, now_s, timeout_s)
            if not one and self.state == FlowState.RUNNING:
                self.abort('a second operator holds to run')

    def meet(self, clash: str) -> None:
        """Take who else offers this bridge's names: nothing is released meanwhile; '' is nobody.

        Requests and beats reach both, so what is released ends in the latched abort.
        """
        with self._lock:
            new, self.clash = bool(clash) and not self.clash, clash
            if new and self.active:
                self.abort(f'name clash: {clash}')

    def set_speed_override(self, fraction: float) -> None:
        """Scale amplitude, speed and acceleration of the motion; followed by a slow ramp.

        Raises
        ------
        BridgeError
            Not within 0..1.
        """
        check_fraction(fraction)
        with self._lock:
            self._override = fraction
            if self._player is not None:
                self._player.override_target = fraction

    @property
    def connected(self) -> bool:
        """The controller is heard."""
        return self.feedback is not None and self._heard_s > -math.inf

    @property
    def away(self) -> str:
        """Why the plan in hand could not begin where the arm stands; empty when it could."""
        path, feedback = self.path, self.feedback
        if path is None or feedback is None or self.busy:
            return ''
        distance = np.abs(np.array(feedback.joints_deg) - path.start_deg)
        axis, allowed_deg = int(np.argmax(distance)), self.settings.start_tolerance_deg
        if distance[axis] <= allowed_deg:
            return ''
        return f'{AWAY}: axis {axis + 1} by {distance[axis]:.2f} deg, {allowed_deg:g} allowed'

    @property
    def moving(self) -> bool:
        """A plan is played or the motion is slowing down."""
        player = self._player
        return player is not None and not player.at_rest

    @property
    def busy(self) -> bool:
        """No other plan can be taken: one is played, or slowing down."""
        return self.state in (FlowState.RUNNING, FlowState.STOPPING) or self.moving

    @property
    def playing(self) -> bool:
        """A plan is in the player: moving, or brought to rest in it."""
        return self._player is not None

    @property
    def progress(self) -> float:
        """Fraction of the plan played."""
        player = self._player
        if player is not None:
            return player.progress
        return 1.0 if self.state == FlowState.HOLDING else 0.0

    @property
    def speed_override(self) -> float:
        """Fraction set by the operator."""
        return self._override

    @property
    def reference_deg(self) -> Array | None:
        """Axis angles wanted now, (6,) [deg]."""
        player = self._player
        return player.position_deg if player is not None else self._hold

    def _check_alone(self) -> None:
        if self.clash:
            raise BridgeError(
                'name clash',
                found=self.clash,
                advice='stop the other, or give each robot a namespace of its own',
            )

    def _enter(self, state: FlowState, reason: str) -> None:
        if state not in (FlowState.ARMED, FlowState.RUNNING):
            self.release.end()
        self.state, self.reason = state, reason
        self.on_change(state, reason)
