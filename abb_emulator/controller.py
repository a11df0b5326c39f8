"""The robot controller, one ``tick`` per 4.032 ms: program, motion, supervision, EGM.

A program is a generator that yields once per cycle while it waits; it asks the controller to move,
to guide or to stop.  Failures the program can handle are thrown into it as :class:`RapidError`.
"""

from collections.abc import Generator
from dataclasses import replace
import time

import numpy as np
from numpy.typing import NDArray

from abb_emulator.commanded_axes import CommandedAxes
from abb_emulator.controller_settings import ControllerSettings, names_in, RapidError
from abb_emulator.drives import CommandedMotion, MoveLimits, Stop
from abb_emulator.egm import EgmSession, GuidanceLaw, GuidanceSettings, Phase, Status, UdpClient
from abb_emulator.event_log import (
    AUTOMATIC,
    EMERGENCY_STOP,
    ERROR,
    EventLog,
    INFORMATION,
    MANUAL,
    MOTORS_OFF,
    MOTORS_ON,
    POINTER_RESET,
    PROGRAM_STARTED,
    PROGRAM_STOPPED,
    USER_EVENT,
)
from modal_core.errors import BridgeError
from robot_bridge.egm import RAPID_RUNNING, RAPID_STOPPED, RAPID_UNDEFINED
from structural_model.flexible_joint_model import FlexibleJointModel

Array = NDArray[np.float64]
Program = Generator[None, None, None]


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
        self.axes = CommandedAxes(model, start_deg, self.settings)
        self.time_s = time.time() if start_time_s is None else start_time_s
        self.motors_on = True
        self.e_stopped = False
        self.automatic = self._key_automatic = True
        self.speed_ratio = 1.0
        self.rapid_undefined = False
        self.clock_skew = 0.0
        self.log = EventLog()
        self.external = self.settings.external
        self.signals = dict.fromkeys(names_in(self.settings.signals), 0.0)
        self.session: EgmSession | None = None
        self._program: Program | None = None
        self._running = False
        self._pending: RapidError | None = None
        self._cycles = 0

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
        self.note('program started', PROGRAM_STARTED)
        return True

    def resume(self) -> bool:
        """Go on with a stopped program; a session set up before runs on."""
        if self._program is None or self._running or not self.motors_on:
            return False
        self._running = True
        self.note('program started again', PROGRAM_STARTED)
        return True

    def reset_program(self) -> bool:
        """Forget where the program stood; the next start is from its beginning."""
        if self._running:
            return False
        self._program, self._pending = None, None
        self.note('program pointer reset', POINTER_RESET)
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
        if not automatic:
            self.note('manual mode', MANUAL)

    def confirm_automatic(self) -> bool:
        """Confirm automatic mode; False when the key is not there."""
        if self._key_automatic and not self.automatic:
            self.note('automatic mode', AUTOMATIC)
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
        self.note('motion supervision: collision', kind=ERROR)
        self.stop('collision')
        if self.session is not None:
            self.session.phase = Phase.ERROR

    def restart_session(self) -> None:
        """Begin the session again at seqno 0, as a restarted controller does."""
        if self.session is not None:
            self.session.begin_again()

    def stop(self, reason: str = 'stop') -> None:
        """Stop the program and bring the axes to standstill."""
        self.note(f'program stopped: {reason}', PROGRAM_STOPPED)
        self._running = False
        self.axes.halt()
        if self.session is not None and self.session.phase == Phase.RUNNING:
            self.session.phase = Phase.STOPPED

    def emergency_stop(self, reason: str = 'e-stop') -> None:
        """Motors off; only an operator brings them back, and no program resumes by itself."""
        self.e_stopped = True
        self.note('emergency stop', EMERGENCY_STOP, ERROR)
        self.motors_off(reason)

    def motors_off(self, reason: str = 'motors off') -> None:
        """Switch the motors off; the brakes hold."""
        self.stop(reason)
        # The brakes hold at once; no ramp is left to go on with when the motors come back.
        self.motors_on, self.axes.motion = False, None
        self.note('motors off', MOTORS_OFF)

    def switch_motors_on(self) -> bool:
        """Switch the motors on; False while the e-stop is latched."""
        if self.e_stopped:
            return False
        self.motors_on = True
        self.note('motors on', MOTORS_ON)
        return True

    def release_emergency_stop(self) -> None:
        """Unlatch the e-stop; motors stay off, and a program must be started anew."""
        self.e_stopped = False
        self._program = None

    def note(self, event: str, code: int = USER_EVENT, kind: int = INFORMATION) -> None:
        """Write into the event log."""
        self.log.add(self.time_s, event, code, kind)

    @property
    def events(self) -> list[str]:
        """What stands in the event log, oldest first."""
        return self.log.titles

    # -- what programs ask for -----------------------------------------------------------------

    @property
    def measured_deg(self) -> Array:
        """Where the motors are, (6,) array [deg]."""
        return self.axes.measured_deg

    @property
    def motion(self) -> CommandedMotion | None:
        """What moves the axes; one that is set begins where they are commanded."""
        return self.axes.motion

    @motion.setter
    def motion(self, motion: CommandedMotion | None) -> None:
        self.axes.motion = motion

    def move(self, target_deg: Array, limits: MoveLimits) -> None:
        """Begin a move from where the axes are commanded (MoveAbsJ).

        Raises
        ------
        BridgeError
            The target is out of range; nothing moves.
        """
        limits = replace(limits, speed_ratio=self.speed_ratio)
        self.axes.move(target_deg, limits, self.automatic)

    def stop_move(self) -> None:
        """Bring the axes to standstill (StopMove)."""
        if not isinstance(self.axes.motion, Stop):
            self.axes.halt()

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
        law = GuidanceLaw(settings, self.axes.planned_deg, self.settings.cycle_s)
        self.axes.motion = law
        return law

    def reset_session(self) -> None:
        """End the session (EGMReset)."""
        if isinstance(self.axes.motion, GuidanceLaw):
            self.axes.halt()
        self.session = None

    # -- one cycle -----------------------------------------------------------------------------

    def tick(self) -> Array:
        """Advance by one cycle and return the commanded position at its end, (6,) [deg]."""
        self._hear()
        self._run_program()
        self._move()
        self.time_s += self.settings.cycle_s * (1.0 + self.clock_skew)
        self._cycles += 1
        return self.axes.planned_deg

    def report(self) -> None:
        """Send this cycle's message, after the motors have moved."""
        session = self.session
        if session is None or not session.sending or self.client is None:
            return
        if self._cycles % session.settings.sample_cycles == 0:
            self.client.send(session.message(self._status()), self.time_s)

    def _status(self) -> Status:
        rapid = RAPID_RUNNING if self._running else RAPID_STOPPED
        law = self.axes.motion if isinstance(self.axes.motion, GuidanceLaw) else None
        return Status(
            measured_deg=self.axes.measured_deg,
            planned_deg=self.axes.planned_deg,
            time_s=self.time_s,
            motors_on=self.motors_on,
            converged=law.converged if law is not None else False,
            rapid_state=RAPID_UNDEFINED if self.rapid_undefined else rapid,
            utilization=self.axes.utilization,
        )

    def _hear(self) -> None:
        session = self.session
        if session is None or not session.sending or self.client is None:
            return
        datagram = self.client.receive(self.time_s)
        command = session.hear(datagram) if datagram is not None else None
        law = self.axes.motion
        if command is not None and isinstance(law, GuidanceLaw):
            law.refer(
                None if command.position_deg is None else np.array(command.position_deg),
                None if command.speed_deg_s is None else np.array(command.speed_deg_s),
            )
        if command is None:
            session.silence_s += self.settings.cycle_s
        if session.phase == Phase.RUNNING and isinstance(law, GuidanceLaw):
            if session.silence_s > session.settings.comm_timeout_s:
                self.note('EGM: no message within CommTimeout', kind=ERROR)
                self._lose_session('ERR_UDPUC_COMM')
            elif law.finished:
                session.phase = Phase.STOPPED

    def _lose_session(self, code: str) -> None:
        if self.session is not None:
            self.session.phase = Phase.ERROR
        self.axes.halt()
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
        fault = self.axes.step(self.motors_on, self.automatic)
        if fault:
            self.note(f'motion supervision: {fault}', kind=ERROR)
            self.stop(fault)
            if self.session is not None:
                self.session.phase = Phase.ERROR
            self.axes.give_way()
