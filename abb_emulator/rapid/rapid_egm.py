"""RAPID instructions of Externally Guided Motion."""

from collections.abc import Callable, Generator
from dataclasses import replace

import numpy as np

from abb_emulator.controller import Controller
from abb_emulator.controller_settings import RapidError
from abb_emulator.egm import GuidanceSettings
from abb_emulator.rapid.guidance_program import guide
from abb_emulator.rapid.rapid_instructions import AXES
from abb_emulator.rapid.rapid_memory import numbers_of, RapidMemory
from abb_emulator.rapid.rapid_syntax import Call, Value

Steps = Generator[None, None, None]
Action = Callable[[Call], Steps | None]
SAMPLE_MS = 4.0
"""What SampleRate is a multiple of."""
CONVERGED_DEG = (-0.5, 0.5)


class EgmInstructions:
    """The instructions by name, and what they have set of the session.

    Parameters
    ----------
    controller : Controller
        Has the session.
    memory : RapidMemory
        Of the program.
    base : GuidanceSettings
        What the configuration sets: the gain k, and the defaults.
    """

    def __init__(
        self, controller: Controller, memory: RapidMemory, base: GuidanceSettings
    ) -> None:
        self._controller, self._memory, self._base = controller, memory, base
        self._settings = base
        self.actions: dict[str, Action] = {
            'egmreset': self._reset,
            'egmsetupuc': self._set_up,
            'egmstreamstart': self._stream,
            'egmstreamstop': self._stop_stream,
            'egmactjoint': self._activate,
            'egmrunjoint': self._guide,
        }

    def _reset(self, _: Call) -> None:
        self._controller.reset_session()

    def _set_up(self, call: Call) -> None:
        device = str(self._memory.value(call.arguments[3]))
        if device != self._controller.settings.device:
            raise RapidError('ERR_UDPUC_COMM')
        timeout_s = self._memory.option(call, 'commtimeout', GuidanceSettings().comm_timeout_s)
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
            low_pass_hz=float(np.clip(self._memory.option(call, 'lpfilter', 20.0), 0.0, 100.0)),
            max_position_deviation_deg=self._memory.option(call, 'maxposdeviation', 1000.0),
            max_speed_deviation_deg_s=self._memory.option(call, 'maxspeeddeviation', 1.0),
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
            condition_time_s=self._memory.option(call, 'condtime', 1.0),
            ramp_in_s=float(np.clip(self._memory.option(call, 'rampintime', 0.5), 0.005, 10.0)),
            ramp_out_s=float(np.clip(self._memory.option(call, 'rampouttime', 0.5), 0.005, 10.0)),
            position_gain=float(np.clip(self._memory.option(call, 'poscorrgain', 1.0), 0.0, 1.0)),
            stop_ramp_down=getattr(mode, 'name', '') == 'egm_stop_ramp_down',
        )
        return guide(self._controller, self._settings)

    def _window(self, value: Value | None) -> tuple[float, ...]:
        return CONVERGED_DEG if value is None else numbers_of(self._memory.value(value))

    def _sample(self, call: Call) -> None:
        sample_ms = self._memory.option(call, 'samplerate', SAMPLE_MS)
        if sample_ms < SAMPLE_MS or sample_ms % SAMPLE_MS:
            raise RapidError('ERR_ARGVALERR')
        self._settings = replace(self._settings, sample_cycles=int(sample_ms / SAMPLE_MS))

    def _begin_sending(self) -> None:
        session = self._controller.session
        if session is None:
            raise RapidError('ERR_UDPUC_COMM')
        session.settings, session.sending = self._settings, True
