"""The task T_ROB1: which program is loaded, and where its pointer stands."""

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np

from abb_emulator.controller import Controller, Program
from abb_emulator.egm import GuidanceSettings
from abb_emulator.rapid.guidance_program import guidance_program
from abb_emulator.rapid.rapid_check import check_configuration
from abb_emulator.rapid.rapid_declarations import value_from
from abb_emulator.rapid.rapid_memory import rapid_text
from abb_emulator.rapid.rapid_parser import parse_module
from abb_emulator.rapid.rapid_program import RapidProgram
from abb_emulator.rapid.rapid_syntax import Datum, Module
from modal_core.errors import BridgeError

LARGEST_BYTES = 8_000_000
# Run modes: single cycle, and continuous.
CYCLES = ('once', 'forever')


class ProgramTask:
    """Loads, starts, stops and resets one program.

    Parameters
    ----------
    controller : Controller
        Executes it.
    guidance : GuidanceSettings
        Of the built-in program that is run while no module is loaded.
    random : numpy.random.Generator
        Program latency.

    Attributes
    ----------
    cycle : str
        Run mode: at its end ``main`` is over (``once``) or begins anew (``forever``).
    """

    def __init__(
        self, controller: Controller, guidance: GuidanceSettings, random: np.random.Generator
    ) -> None:
        self._controller, self._guidance, self._random = controller, guidance, random
        self.module: Module | None = None
        self.texts: dict[str, str] = {}
        self._beside: list[str] = []
        self.cycle = CYCLES[0]
        self._made: RapidProgram | None = None

    @property
    def running(self) -> bool:
        """The program is executed."""
        return self._controller.running

    def load(self, text: str, beside: bool = False) -> Module:
        """Load a module in place of those before; the program pointer goes to main.

        Loaded beside others, as web services do, it leaves those that were loaded so; every
        module here has a ``main``, and a task with two of them has no program to run.

        Raises
        ------
        BridgeError
            It is running, or the module has something that is not executed, by line.
        """
        if self.running:
            raise BridgeError('a program is running', where='T_ROB1', advice='stop it first')
        module = parse_module(text)
        check_configuration(module, self._controller.settings)
        self.module = module
        name = self.module.name
        kept = [other for other in self._beside if other.casefold() != name.casefold()]
        self._beside = [*kept, name] if beside else []
        self.texts = {other: self.texts[other] for other in kept if beside} | {name: text}
        self.reset()
        self._controller.note(f'module {self.module.name} loaded')
        return self.module

    def unload(self, name: str) -> None:
        """Take a module out of the task.

        Raises
        ------
        BridgeError
            It is running, or there is no such module.
        """
        if self.running or name not in self.texts:
            raise BridgeError('cannot be unloaded', where='T_ROB1', found=name[:40])
        del self.texts[name]
        self._beside = [other for other in self._beside if other != name]
        self.module = parse_module(next(iter(self.texts.values()))) if self.texts else None
        self.reset()

    def load_file(self, path: Path) -> Module:
        """Load a .mod file.

        Raises
        ------
        BridgeError
            It cannot be read, or not be executed.
        """
        try:
            if path.stat().st_size > LARGEST_BYTES:
                raise BridgeError('module too large', where=path, expected=f'{LARGEST_BYTES} B')
            text = path.read_text('utf-8-sig')
        except (OSError, UnicodeDecodeError) as error:
            raise BridgeError('cannot be read', where=path, found=error) from error
        try:
            return self.load(text)
        except BridgeError as error:
            raise BridgeError(
                error.what, where=f'{path.name}, {error.where}', found=error.found,
                expected=error.expected, advice=error.advice,
            ) from error  # fmt: skip

    def start(self, wait_for_sensor: bool = True) -> bool:
        """Go on from the program pointer; False when there is none, motors off, or it runs."""
        if self.module is not None and self._controller.resume():
            return True
        if self.module is not None and self.pointer is None:
            return False
        return self._controller.start(self._new(wait_for_sensor))

    @property
    def pointer(self) -> tuple[str, str] | None:
        """Module and routine of the program pointer; None after EXIT, or where is no one main."""
        lost = self._made is not None and self._made.exited
        if self.module is None or lost or len(self.texts) != 1:
            return None
        return self.module.name, 'main'

    # -- data ----------------------------------------------------------------------------------

    @property
    def data(self) -> Mapping[str, Datum]:
        """Every datum of the loaded module by its name in lower case."""
        return self.module.data if self.module is not None else {}

    def data_text(self, name: str) -> str | None:
        """Return what a datum holds as RAPID writes it; None when there is none."""
        datum = self.data.get(name.lower())
        if datum is None:
            return None
        made = self._made
        return rapid_text(made.memory.held(name.lower()) if made is not None else datum.value)

    def set_data(self, name: str, text: str) -> None:
        """Set a variable or persistent of the loaded module.

        Raises
        ------
        BridgeError
            A constant, or a value of another type.
        """
        datum = self.data[name.lower()]
        if datum.constant:
            raise BridgeError('is a constant', found=name)
        value = value_from(text, datum)
        if self._made is not None:
            self._made.memory.set_held(name.lower(), value)
        if self.module is not None and (self._made is None or datum.storage == 'pers'):
            data = {**self.module.data, name.lower(): replace(datum, value=value)}
            self.module = replace(self.module, data=data)

    def stop(self, reason: str = 'operator') -> None:
        """Stop the program; it can be started again."""
        self._controller.stop(reason)

    def reset(self) -> bool:
        """Move the program pointer to main; False while the program runs."""
        if not self._controller.reset_program():
            return False
        self._made = None
        return True

    def _new(self, wait_for_sensor: bool) -> Program:
        if self.module is None:
            return guidance_program(self._controller, self._guidance, wait_for_sensor)
        self._made = RapidProgram(
            self.module, self._controller, self._guidance, self._random,
            lambda: self.cycle == 'forever',
        )  # fmt: skip
        return self._made.run()
