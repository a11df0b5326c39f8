"""Executes a RAPID module on the controller, one ``next`` per controller cycle."""

from collections.abc import Callable, Generator

import numpy as np

from abb_emulator.controller import Controller
from abb_emulator.controller_settings import RapidError
from abb_emulator.egm import GuidanceSettings
from abb_emulator.rapid.rapid_egm import EgmInstructions
from abb_emulator.rapid.rapid_memory import RapidMemory
from abb_emulator.rapid.rapid_motion import Action, MotionInstructions, Steps
from abb_emulator.rapid.rapid_syntax import (
    Assignment,
    Branch,
    Call,
    Loop,
    Module,
    Statement,
)


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
    memory : RapidMemory
        What its data hold.
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
        self._module, self._controller = module, controller
        self.memory = self._memory = RapidMemory(module, controller)
        self._handler: tuple[Statement, ...] = ()
        self._actions: dict[str, Action] = {
            **MotionInstructions(controller, self._memory, random).actions,
            **EgmInstructions(controller, self._memory, base).actions,
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
                if self._memory.value(statement.condition):
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
                    if self._memory.error is not None or not self._handler:
                        raise
                    if not (yield from self._handle(error)):
                        break

    def _handle(self, error: RapidError) -> Generator[None, None, bool]:
        """Run the ERROR handler; True is RETRY, False is TRYNEXT."""
        self._memory.error = error
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
            self._memory.error = None
        raise ProgramEndError

    def _loop(self, loop: Loop) -> Steps:
        first, last = (int(self._memory.number(value)) for value in (loop.first, loop.last))
        step = 1 if last >= first else -1
        for value in range(first, last + step, step):
            self._memory.set_number(loop.variable, float(value))
            yield from self._statements(loop.body)

    def _execute(self, statement: Statement) -> Steps:
        self._memory.line = statement.line
        if isinstance(statement, Assignment):
            self._memory.assign(statement)
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
