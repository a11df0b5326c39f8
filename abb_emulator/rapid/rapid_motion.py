"""RAPID instructions that move the axes, wait, and write to the pendant."""

from collections.abc import Callable, Generator

import numpy as np
from numpy.typing import NDArray

from abb_emulator.controller import Controller
from abb_emulator.controller_settings import NOT_CONNECTED
from abb_emulator.drives import MoveLimits
from abb_emulator.rapid.rapid_memory import numbers_of, RapidMemory, rows_of
from abb_emulator.rapid.rapid_syntax import Call
from modal_core.errors import BridgeError

Array = NDArray[np.float64]
Steps = Generator[None, None, None]
Action = Callable[[Call], Steps | None]
LEAST_ACCELERATION, LEAST_RAMP, LARGEST_PERCENT = 20.0, 10.0, 100.0
STANDING_EXTERNAL = 1e-3
CYCLES_STANDING = 2
"""In a row, that are standstill: one alone may be the turning point of a motion."""


class MotionInstructions:
    """The instructions by name, and the acceleration and speed that are set.

    Parameters
    ----------
    controller : Controller
        Moves the axes.
    memory : RapidMemory
        Of the program.
    random : numpy.random.Generator
        Program latency at fine points.
    """

    def __init__(
        self, controller: Controller, memory: RapidMemory, random: np.random.Generator
    ) -> None:
        self._controller, self._memory, self._random = controller, memory, random
        self._acceleration = self._ramp = 1.0
        self._override, self._fastest_mm_s = 1.0, 5000.0
        self.actions: dict[str, Action] = {
            'moveabsj': self._move,
            'waittime': self._wait,
            'accset': self._set_acceleration,
            'velset': self._set_speed,
            'tpwrite': self._write,
            'stopmove': self._stop_move,
            'setdo': self._set_output,
        }

    def _move(self, call: Call) -> Steps:
        robot, external = rows_of(self._memory.value(call.arguments[0]))
        target = np.array(numbers_of(robot))
        self._check_external(np.array(numbers_of(external)))
        limits = self._limits(call)
        # A stopped move goes on from where the axes stand when the program is started again.
        while not self._controller.axes.at(target):
            self._controller.move(target, limits)
            while self._controller.axes.moving:
                yield
        yield from self._stand_still()

    def _check_external(self, target: Array) -> None:
        """Refuse a target without a place for an axis that is there, or with another place."""
        places = np.array(self._controller.external)
        there = places != NOT_CONNECTED
        if np.any(target[there] == NOT_CONNECTED):
            raise BridgeError('no value for an external axis in the target')
        if np.any(np.abs(target - places)[there] > STANDING_EXTERNAL):
            raise BridgeError('external axes do not move in the emulator')

    def _limits(self, call: Call) -> MoveLimits:
        duration_s = self._memory.option(call, 't', 0.0)
        if duration_s > 0.0:
            # VelSet's largest speed does not count for a move whose time is given.
            return MoveLimits(
                acceleration=self._acceleration, ramp=self._ramp, duration_s=duration_s
            )
        speed = numbers_of(self._memory.value(call.arguments[1]))
        tool_mm_s = self._memory.option(call, 'v', speed[0]) * self._override
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
            standing = standing + 1 if self._controller.axes.standing else 0
            yield
        low, high = self._controller.settings.fine_latency_s
        yield from self._pause(self._random.uniform(low, high))

    def _pause(self, time_s: float) -> Steps:
        for _ in range(round(time_s / self._controller.settings.cycle_s)):
            yield

    def _wait(self, call: Call) -> Steps:
        return self._pause(max(self._memory.number(call.arguments[0]), 0.0))

    def _set_acceleration(self, call: Call) -> None:
        acceleration, ramp = (self._memory.number(value) for value in call.arguments)
        self._acceleration = float(np.clip(acceleration, LEAST_ACCELERATION, 100.0)) / 100.0
        self._ramp = float(np.clip(ramp, LEAST_RAMP, LARGEST_PERCENT)) / 100.0

    def _set_speed(self, call: Call) -> None:
        override, fastest = (self._memory.number(value) for value in call.arguments)
        self._override = float(np.clip(override, 0.0, LARGEST_PERCENT)) / 100.0
        self._fastest_mm_s = max(fastest, 1e-3)

    def _write(self, call: Call) -> None:
        text = str(self._memory.value(call.arguments[0]))
        if 'num' in call.options:
            text += f'{self._memory.option(call, "num", 0.0):g}'
        self._controller.note(f'TPWrite: {text}')

    def _set_output(self, call: Call) -> None:
        signal = getattr(call.arguments[0], 'name', '')
        names = {name.lower(): name for name in self._controller.signals}
        value = 1.0 if self._memory.number(call.arguments[1]) else 0.0
        self._controller.signals[names[signal]] = value

    def _stop_move(self, _: Call) -> None:
        self._controller.stop_move()
