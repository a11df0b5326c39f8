"""The robot controller, one ``tick`` per 4.032 ms: program, motion, supervision, EGM.

A program is a generator that yields once per cycle while it waits; it asks the controller to move,
to guide or to stop.  Failures the program can handle are thrown into it as :class:`RapidError`.
"""

from collections.abc import Generator
from dataclasses import replace
import math
import time

import numpy as np
from numpy.typing import NDArray

from abb_emulator.controller_settings import ControllerSettings, RapidError
from abb_emulator.drives import JointMove, Motion, MoveLimits, Stop, Supervision
from abb_emulator.egm import EgmSession, GuidanceLaw, GuidanceSettings, Phase, Status, UdpClient
from modal_core.errors import BridgeError
from robot_bridge.egm import RAPID_RUNNING, RAPID_STOPPED, RAPID_UNDEFINED
from structural_model.flexible_joint_model import FlexibleJointModel

Array = NDArray[np.float64]
Program = Generator[None, None, None]
AT_TARGET_DEG = 1e-6
STANDING_DEG = 0.005


class Controller:
    """Controller of one six-axis robot.

    Parameters
    ----------
    model : FlexibleJointModel
        Ranges, speeds and kinematics.
    start_deg : (6,) array [deg]
        Where the axes stand, in controller angles.
    client : UdpClient or None
        Link to the sensor; None has none.
    settings : ControllerSettings
        Figures.
    start_time_s : float [s]
        Of the controller's clock.
    """

    def __init__(
        self,
        model: FlexibleJointModel,
        start_deg: Array,
        client: UdpClient | None,
        settings: ControllerSettings | None = None,
        start_time_s: float | None = None,
    ) -> None:
        self.model, self.client = model, client
        self.settings = settings or ControllerSettings()
        self.planned_deg = np.array(start_deg, float)
        self.planned_speed_deg_s = np.zeros_like(self.planned_deg)
        self.measured_deg = self.planned_deg.copy()
        self.time_s = time.time() if start_time_s is None else start_time_s
        self.motors_on = True
        self.e_stopped = False
        self.automatic = self._key_automatic = True
        self.speed_ratio = 1.0
        self.rapid_undefined = False
        self.clock_skew = 0.0
        self.events: list[str] = []
        self.session: EgmSession | None = None
        self.motion: Motion | None = None
        self._program: Program | None = None
        self._running = False
        self._pending: RapidError | None = None
        self._cycles = 0
        self._supervision = Supervision(
            model,
            self.settings.cycle_s,
            self.settings.speed_slack,
            self.settings.following_error_deg,
        )

    # -- operator ------------------------------------------------------------------------------

    @property
    def running(self) -> bool:
        """The RAPID program is executed."""
        return self._running

    def start(self, program: Program) -> bool:
        """Start a program from its beginning; False when motors are off."""
        if not self.motors_on or self._running:
            return False
        self._program, self._running, self._pending = program, True, None
        return True

    def resume(self) -> bool:
        """Go on with a stopped program; a session set up before runs on."""
        if self._program is None or self._running or not self.motors_on:
            return False
        self._running = True
        return True

    def reset_program(self) -> bool:
        """Forget where the program stood; the next start is from its beginning."""
        if self._running:
            return False
        self._program, self._pending = None, None
        return True

    @property
    def operating_mode(self) -> str:
        """``MANR``, ``AUTO``, or ``AUTO_CH``: automatic, and nobody has confirmed it yet."""
        return 'AUTO' if self.automatic else 'AUTO_CH' if self._key_automatic else 'MANR'

    def set_automatic(self, automatic: bool) -> None:
        """Turn the key: a running program stops; automatic must be confirmed by the operator."""
        if automatic != self._key_automatic and self._running:
            self.stop('operating mode changed')
        self._key_automatic = automatic
        self.automatic = self.automatic and automatic

    def confirm_automatic(self) -> bool:
        """Confirm automatic mode; False when the key is not there."""
        self.automatic = self._key_automatic
        return self.automatic

    def set_speed_ratio(self, ratio: float) -> bool:
        """Set the operator's speed ratio, 0..1, for the moves that begin from now on."""
        if not 0.0 < ratio <= 1.0:
            return False
        self.speed_ratio = ratio
        return True

    def collide(self) -> None:
        """Stop as motion supervision does on a collision; no program resumes by itself."""
        self.note('motion supervision: collision')
        self.stop('collision')
        if self.session is not None:
            self.session.phase = Phase.ERROR

    def restart_session(self) -> None:
        """Begin the session again at seqno 0, as a restarted controller does."""
        if self.session is not None:
            self.session.begin_again()

    def stop(self, reason: str = 'stop') -> None:
        """Stop the program and bring the axes to standstill."""
        self.note(f'program stopped: {reason}')
        self._running = False
        self._halt()
        if self.session is not None and self.session.phase == Phase.RUNNING:
            self.session.phase = Phase.STOPPED

    def emergency_stop(self, reason: str = 'e-stop') -> None:
        """Motors off; only an operator brings them back, and no program resumes by itself."""
        self.e_stopped = True
        self.motors_off(reason)

    def motors_off(self, reason: str = 'motors off') -> None:
        """Switch the motors off; the brakes hold."""
        self.stop(reason)
        # The brakes hold at once; no ramp is left to go on with when the motors come back.
        self.motors_on, self.motion = False, None

    def switch_motors_on(self) -> bool:
        """Switch the motors on; False while the e-stop is latched."""
        if self.e_stopped:
            return False
        self.motors_on = True
        return True

    def release_emergency_stop(self) -> None:
        """Unlatch the e-stop; motors stay off, and a program must be started anew."""
        self.e_stopped = False
        self._program = None

    def note(self, event: str) -> None:
        """Write into the event log."""
        self.events.append(event)
        del self.events[:-200]

    # -- what programs ask for -----------------------------------------------------------------

    @property
    def moving(self) -> bool:
        """The commanded position moves."""
        return self.motion is not None

    @property
    def standing(self) -> bool:
        """The motors are where they are commanded."""
        away = float(np.max(np.abs(self.measured_deg - self.planned_deg)))
        return self.motion is None and away < STANDING_DEG

    def at(self, target_deg: Array) -> bool:
        """Tell whether the commanded position is the target."""
        return bool(np.max(np.abs(self.planned_deg - target_deg)) < AT_TARGET_DEG)

    def move(self, target_deg: Array, limits: MoveLimits) -> None:
        """Begin a move from where the axes are commanded (MoveAbsJ).

        Raises
        ------
        BridgeError
            The target is out of range; nothing moves.
        """
        outside = self._supervision.outside(target_deg)
        if outside:
            raise BridgeError(f'target out of range: {outside}')
        tool_mm_s = limits.tool_speed_mm_s
        if not self.automatic:
            tool_mm_s = min(tool_mm_s, 1e3 * self.settings.manual_speed_m_s)
        limits = replace(limits, tool_speed_mm_s=tool_mm_s, speed_ratio=self.speed_ratio)
        self.motion = JointMove(
            self.model, self.planned_deg, target_deg, limits, self.settings.cycle_s
        )

    def stop_move(self) -> None:
        """Bring the axes to standstill (StopMove)."""
        if not isinstance(self.motion, Stop):
            self._halt()

    def set_up(self, settings: GuidanceSettings) -> EgmSession:
        """Set an EGM session up (EGMSetupUC)."""
        self.session = EgmSession(settings, self.model)
        if self.client is not None:
            self.client.flush()
        return self.session

    def guide(self, settings: GuidanceSettings) -> GuidanceLaw:
        """Begin to follow the sensor (EGMRunJoint)."""
        if self.session is None:
            raise RapidError('ERR_UDPUC_COMM')
        self.session.settings = settings
        self.session.sending, self.session.phase = True, Phase.RUNNING
        self.session.silence_s = 0.0
        law = GuidanceLaw(settings, self.planned_deg, self.settings.cycle_s)
        self.motion = law
        return law

    def reset_session(self) -> None:
        """End the session (EGMReset)."""
        if isinstance(self.motion, GuidanceLaw):
            self._halt()
        self.session = None

    # -- one cycle -----------------------------------------------------------------------------

    def tick(self) -> Array:
        """Advance by one cycle and return the commanded position at its end, (6,) [deg]."""
        self._hear()
        self._run_program()
        self._move()
        self.time_s += self.settings.cycle_s * (1.0 + self.clock_skew)
        self._cycles += 1
        return self.planned_deg

    def report(self) -> None:
        """Send this cycle's message, after the motors have moved."""
        session = self.session
        if session is None or not session.sending or self.client is None:
            return
        if self._cycles % session.settings.sample_cycles == 0:
            self.client.send(session.message(self._status()), self.time_s)

    def _status(self) -> Status:
        rapid = RAPID_RUNNING if self._running else RAPID_STOPPED
        law = self.motion if isinstance(self.motion, GuidanceLaw) else None
        return Status(
            measured_deg=self.measured_deg,
            planned_deg=self.planned_deg,
            time_s=self.time_s,
            motors_on=self.motors_on,
            converged=law.converged if law is not None else False,
            rapid_state=RAPID_UNDEFINED if self.rapid_undefined else rapid,
            utilization=self._utilization(),
        )

    def _utilization(self) -> float:
        """Return the largest part of any axis' speed limit in use [%]."""
        part = np.abs(self.planned_speed_deg_s) / self._supervision.top_speed_deg_s
        return 100.0 * float(np.max(part))

    def _hear(self) -> None:
        session = self.session
        if session is None or not session.sending or self.client is None:
            return
        datagram = self.client.receive(self.time_s)
        command = session.hear(datagram) if datagram is not None else None
        law = self.motion
        if command is not None and isinstance(law, GuidanceLaw):
            law.refer(
                None if command.position_deg is None else np.array(command.position_deg),
                None if command.speed_deg_s is None else np.array(command.speed_deg_s),
            )
        if command is None:
            session.silence_s += self.settings.cycle_s
        if session.phase == Phase.RUNNING and isinstance(law, GuidanceLaw):
            if session.silence_s > session.settings.comm_timeout_s:
                self.note('EGM: no message within CommTimeout')
                self._lose_session('ERR_UDPUC_COMM')
            elif law.finished:
                session.phase = Phase.STOPPED

    def _lose_session(self, code: str) -> None:
        if self.session is not None:
            self.session.phase = Phase.ERROR
        self._halt()
        self._pending = RapidError(code)

    def _run_program(self) -> None:
        if self._program is None or not self._running:
            return
        try:
            if self._pending is not None:
                error, self._pending = self._pending, None
                self._program.throw(error)
            else:
                next(self._program)
        except StopIteration:
            self._program, self._running = None, False
            self.note('program at its end')
        except RapidError as error:
            self._program = None
            self.stop(f'unhandled {error.code}')
        except BridgeError as error:
            self._program = None
            self.stop(str(error))

    def _move(self) -> None:
        cycle_s = self.settings.cycle_s
        source = self.motion
        if source is None or not self.motors_on:
            still = Stop(self.planned_deg, self.planned_speed_deg_s, cycle_s, cycle_s)
            target = still.step()
        else:
            target = source.step()
            if source.finished:
                self.motion = None
        speed = (target - self.planned_deg) / cycle_s
        fault = '' if source is None or isinstance(source, Stop) else self._supervise(target)
        if fault:
            self.note(f'motion supervision: {fault}')
            self.stop(fault)
            if self.session is not None:
                self.session.phase = Phase.ERROR
            target = self.motion.step() if self.motion is not None else self.planned_deg
            speed = (target - self.planned_deg) / cycle_s
        self.planned_deg, self.planned_speed_deg_s = target, speed

    def _halt(self) -> None:
        if np.any(self.planned_speed_deg_s):
            self.motion = Stop(
                self.planned_deg,
                self.planned_speed_deg_s,
                self.settings.stop_s,
                self.settings.cycle_s,
            )
        else:
            self.motion = None

    def _supervise(self, target: Array) -> str:
        """Return what is wrong with the next position; empty when nothing is."""
        tool_m_s = math.inf if self.automatic else self.settings.manual_speed_m_s
        check = self._supervision
        return (
            check.range_fault(self.planned_deg, target)
            or check.speed_fault(self.planned_deg, target, tool_m_s)
            or check.following_fault(target, self.measured_deg)
        )
