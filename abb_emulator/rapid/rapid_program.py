"""Executes a RAPID module on the controller, one ``next`` per controller cycle."""

from collections.abc import Callable, Generator, Mapping
from dataclasses import replace
import math
import operator

import numpy as np

from abb_emulator.controller import Controller, RapidError
from abb_emulator.drives import MoveLimits
from abb_emulator.egm import GuidanceSettings
from abb_emulator.rapid.guidance_program import guide
from abb_emulator.rapid.rapid_instructions import AXES
from abb_emulator.rapid.rapid_syntax import (
    Assignment,
    Branch,
    Call,
    Constant,
    Function,
    Literal,
    Loop,
    Module,
    Operation,
    SPEED_FIELDS,
    SPEED_NAMES,
    Statement,
    Value,
)
from abb_emulator.rapid.rapid_tokens import refuse

Steps = Generator[None, None, None]
SAMPLE_MS = 4.0
LEAST_ACCELERATION, LEAST_RAMP, LARGEST_PERCENT = 20.0, 10.0, 100.0
CYCLES_STANDING = 2
CONVERGED_DEG = (-0.5, 0.5)
NOT_CONNECTED = 9e9
RECORDS = (SPEED_FIELDS, ('robax', 'extax'), tuple(f'rax_{axis}' for axis in range(1, 7)))
OPERATORS: Mapping[str, Callable[[float, float], float | bool]] = {
    '+': operator.add, '-': operator.sub, '<': operator.lt, '<=': operator.le,
    '>': operator.gt, '>=': operator.ge, '=': operator.eq, '<>': operator.ne,
}  # fmt: skip


class ProgramEndError(Exception):
    """EXIT: the program ends here, whatever the run mode."""


class ReturnError(Exception):
    """RETURN: the procedure ends here."""


class RapidProgram:
    """One run of a module from ``main``.

    Parameters
    ----------
    module : Module
        Read and checked.
    controller : Controller
        Moves the axes.
    base : GuidanceSettings
        What the configuration sets: the gain k, and the defaults.
    random : numpy.random.Generator
        Program latency at fine points.
    again : callable
        Tells whether ``main`` begins anew at its end: run mode continuous.

    Attributes
    ----------
    exited : bool
        EXIT took the program pointer away: only a pointer moved to main starts it again.
    """

    def __init__(
        self,
        module: Module,
        controller: Controller,
        base: GuidanceSettings,
        random: np.random.Generator,
        again: Callable[[], bool] = lambda: False,
    ) -> None:
        self.exited, self._again = False, again
        self._module, self._controller, self._random = module, controller, random
        self._base = base
        self._settings = base
        self._values = {name: datum.value for name, datum in module.data.items()}
        self._handler: tuple[Statement, ...] = ()
        self._error: RapidError | None = None
        self._acceleration = self._ramp = 1.0
        self._override, self._fastest_mm_s = 1.0, 5000.0
        self.line = 0
        self._actions: dict[str, Callable[[Call], Steps | None]] = {
            'moveabsj': self._move,
            'waittime': self._wait,
            'accset': self._set_acceleration,
            'velset': self._set_speed,
            'tpwrite': self._write,
            'stopmove': self._stop_move,
            'egmreset': self._reset,
            'egmsetupuc': self._set_up,
            'egmstreamstart': self._stream,
            'egmstreamstop': self._stop_stream,
            'egmactjoint': self._activate,
            'egmrunjoint': self._guide,
        }

    def run(self) -> Steps:
        """Execute ``main``; yields once per cycle as long as something takes time."""
        self._handler = self._module.procedures['main'].handler
        try:
            while True:
                yield from self._procedure('main')
                if not self._again():
                    return
                yield
        except ProgramEndError:
            self.exited = True

    # -- control flow --------------------------------------------------------------------------

    def _procedure(self, name: str) -> Steps:
        try:
            yield from self._statements(self._module.procedures[name].body)
        except ReturnError:
            pass

    def _statements(self, statements: tuple[Statement, ...]) -> Steps:
        for statement in statements:
            if isinstance(statement, Loop):
                yield from self._loop(statement)
                continue
            if isinstance(statement, Branch):
                if self._value(statement.condition):
                    yield from self._statements(statement.body)
                continue
            if isinstance(statement, Call) and statement.name in self._module.procedures:
                yield from self._procedure(statement.name)
                continue
            while True:
                try:
                    yield from self._execute(statement)
                    break
                except RapidError as error:
                    if self._error is not None or not self._handler:
                        raise
                    if not (yield from self._handle(error)):
                        break

    def _handle(self, error: RapidError) -> Generator[None, None, bool]:
        """Run the ERROR handler; True is RETRY, False is TRYNEXT."""
        self._error = error
        try:
            for statement in self._handler:
                name = statement.name if isinstance(statement, Call) else ''
                if name in ('retry', 'trynext'):
                    yield
                    return name == 'retry'
                if name == 'raise':
                    raise error
                yield from self._statements((statement,))
        finally:
            self._error = None
        raise ProgramEndError

    def _loop(self, loop: Loop) -> Steps:
        first, last = (int(self._number(value)) for value in (loop.first, loop.last))
        step = 1 if last >= first else -1
        for value in range(first, last + step, step):
            self._values[loop.variable] = float(value)
            yield from self._statements(loop.body)

    def _execute(self, statement: Statement) -> Steps:
        self.line = statement.line
        if isinstance(statement, Assignment):
            self._assign(statement)
        elif isinstance(statement, Call):
            if statement.name == 'return':
                raise ReturnError
            if statement.name == 'exit':
                self._controller.note(f'program: EXIT, line {statement.line}')
                raise ProgramEndError
            if statement.name == 'stop':
                self._controller.stop(f'Stop, line {statement.line}')
                yield
            action = self._actions.get(statement.name)
            steps = action(statement) if action is not None else None
            if steps is not None:
                yield from steps

    # -- values --------------------------------------------------------------------------------

    def _value(self, value: Value) -> Literal:
        if isinstance(value, Constant):
            return value.value
        if isinstance(value, Operation):
            return self._operation(value)
        if isinstance(value, Function):
            return self._function(value)
        if value.name == 'errno':
            return self._error.number if self._error is not None else 0.0
        if value.name in SPEED_NAMES and value.name not in self._values:
            return SPEED_NAMES[value.name]
        held = self._values[value.name]
        if value.index is not None:
            index = int(self._number(value.index))
            rows = held if isinstance(held, tuple) else ()
            if not 1 <= index <= len(rows):
                raise RapidError('ERR_OUTOFBND')
            held = rows[index - 1]
        for field in value.fields:
            held = _rows(held)[_place(field)]
        return held

    def _operation(self, value: Operation) -> Literal:
        if value.sign == 'or':
            return bool(self._value(value.left) or self._value(value.right))
        if value.sign == 'and':
            return bool(self._value(value.left) and self._value(value.right))
        return OPERATORS[value.sign](self._number(value.left), self._number(value.right))

    def _function(self, value: Function) -> Literal:
        if value.name == 'abs':
            return abs(self._number(value.arguments[0]))
        angles = tuple(self._controller.measured_deg.tolist())
        return (angles, (NOT_CONNECTED,) * len(angles))

    def _number(self, value: Value) -> float:
        found = self._value(value)
        if not isinstance(found, float) or not math.isfinite(found):
            raise refuse('not a number', self.line, found)
        return found

    def _option(self, call: Call, name: str, default: float) -> float:
        value = call.options.get(name)
        return default if value is None else self._number(value)

    def _assign(self, item: Assignment) -> None:
        value = self._value(item.value)
        if item.field:
            held = self._values[item.name]
            parts = list(_rows(held))
            parts[_place(item.field)] = value
            value = tuple(parts)
        self._values[item.name] = value

    # -- motion --------------------------------------------------------------------------------

    def _move(self, call: Call) -> Steps:
        target = np.array(_numbers(_rows(self._value(call.arguments[0]))[0]))
        limits = self._limits(call)
        # A stopped move goes on from where the axes stand when the program is started again.
        while not self._controller.at(target):
            self._controller.move(target, limits)
            while self._controller.moving:
                yield
        yield from self._stand_still()

    def _limits(self, call: Call) -> MoveLimits:
        duration_s = self._option(call, 't', 0.0)
        if duration_s > 0.0:
            # VelSet's largest speed does not count for a move whose time is given.
            return MoveLimits(
                acceleration=self._acceleration, ramp=self._ramp, duration_s=duration_s
            )
        speed = _numbers(self._value(call.arguments[1]))
        tool_mm_s = self._option(call, 'v', speed[0]) * self._override
        return MoveLimits(
            tool_speed_mm_s=max(min(tool_mm_s, self._fastest_mm_s), 1e-3),
            turning_deg_s=max(speed[1] * self._override, 1e-3),
            acceleration=self._acceleration,
            ramp=self._ramp,
        )

    def _stand_still(self) -> Steps:
        """Wait for the motors at a fine point, then for the program to go on."""
        standing = 0
        while standing < CYCLES_STANDING:
            standing = standing + 1 if self._controller.standing else 0
            yield
        low, high = self._controller.settings.fine_latency_s
        yield from self._pause(self._random.uniform(low, high))

    def _pause(self, time_s: float) -> Steps:
        for _ in range(round(time_s / self._controller.settings.cycle_s)):
            yield

    def _wait(self, call: Call) -> Steps:
        return self._pause(max(self._number(call.arguments[0]), 0.0))

    def _set_acceleration(self, call: Call) -> None:
        acceleration, ramp = (self._number(value) for value in call.arguments)
        self._acceleration = float(np.clip(acceleration, LEAST_ACCELERATION, 100.0)) / 100.0
        self._ramp = float(np.clip(ramp, LEAST_RAMP, LARGEST_PERCENT)) / 100.0

    def _set_speed(self, call: Call) -> None:
        override, fastest = (self._number(value) for value in call.arguments)
        self._override = float(np.clip(override, 0.0, LARGEST_PERCENT)) / 100.0
        self._fastest_mm_s = max(fastest, 1e-3)

    def _write(self, call: Call) -> None:
        text = str(self._value(call.arguments[0]))
        if 'num' in call.options:
            text += f'{self._option(call, "num", 0.0):g}'
        self._controller.note(f'TPWrite: {text}')

    def _stop_move(self, _: Call) -> None:
        self._controller.stop_move()

    # -- EGM -----------------------------------------------------------------------------------

    def _reset(self, _: Call) -> None:
        self._controller.reset_session()

    def _set_up(self, call: Call) -> None:
        timeout_s = self._option(call, 'commtimeout', GuidanceSettings().comm_timeout_s)
        defaults = GuidanceSettings(gain_1_s=self._base.gain_1_s, comm_timeout_s=timeout_s)
        self._settings = defaults
        self._controller.set_up(defaults)

    def _stream(self, call: Call) -> None:
        self._sample(call)
        self._begin_sending()

    def _stop_stream(self, _: Call) -> None:
        if self._controller.session is not None:
            self._controller.session.sending = False

    def _activate(self, call: Call) -> None:
        self._sample(call)
        windows = [self._window(call.options.get(axis)) for axis in AXES]
        self._settings = replace(
            self._settings,
            low_pass_hz=float(np.clip(self._option(call, 'lpfilter', 20.0), 0.0, 100.0)),
            max_position_deviation_deg=self._option(call, 'maxposdeviation', 1000.0),
            max_speed_deviation_deg_s=self._option(call, 'maxspeeddeviation', 1.0),
            window_low_deg=tuple(window[0] for window in windows),
            window_high_deg=tuple(window[1] for window in windows),
        )
        self._begin_sending()

    def _guide(self, call: Call) -> Steps:
        chosen = tuple(axis in call.options for axis in AXES)
        mode = call.arguments[1]
        self._settings = replace(
            self._settings,
            selected=chosen if any(chosen) else (True,) * len(AXES),
            condition_time_s=self._option(call, 'condtime', 1.0),
            ramp_in_s=float(np.clip(self._option(call, 'rampintime', 0.5), 0.005, 10.0)),
            ramp_out_s=float(np.clip(self._option(call, 'rampouttime', 0.5), 0.005, 10.0)),
            position_gain=float(np.clip(self._option(call, 'poscorrgain', 1.0), 0.0, 1.0)),
            stop_ramp_down=getattr(mode, 'name', '') == 'egm_stop_ramp_down',
        )
        return guide(self._controller, self._settings)

    def _window(self, value: Value | None) -> tuple[float, ...]:
        return CONVERGED_DEG if value is None else _numbers(self._value(value))

    def _sample(self, call: Call) -> None:
        sample_ms = self._option(call, 'samplerate', SAMPLE_MS)
        if sample_ms < SAMPLE_MS or sample_ms % SAMPLE_MS:
            raise RapidError('ERR_ARGVALERR')
        self._settings = replace(self._settings, sample_cycles=int(sample_ms / SAMPLE_MS))

    def _begin_sending(self) -> None:
        session = self._controller.session
        if session is None:
            raise RapidError('ERR_UDPUC_COMM')
        session.settings, session.sending = self._settings, True


def _place(field: str) -> int:
    """Return where a component stands in its record."""
    return next(names.index(field) for names in RECORDS if field in names)


def _rows(value: Literal) -> tuple[Literal, ...]:
    if not isinstance(value, tuple):
        raise RapidError('ERR_ARGVALERR')
    return value


def _numbers(value: Literal) -> tuple[float, ...]:
    return tuple(item for item in _rows(value) if isinstance(item, float))
