"""Modal parameters as they come over a topic, for people and for programs."""

import numpy as np
from rich.markup import escape

from autonomous_modal_analysis.console.terminal import OUTPUT
from autonomous_modal_analysis.identified.results import plain
from modal_core.measurements import NANOSECONDS_PER_SECOND
from modal_core.mode import MODE_FIELDS
from modal_reports import FREQUENCY
from oma_msgs.msg import ModalParameters
from oma_msgs.msg import Mode as ModeMessage


class WindowView:
    """Shows windows as they come, or keeps them for one JSON object.

    Parameters
    ----------
    json : bool
        Keep them and print nothing.
    """

    def __init__(self, json: bool) -> None:
        self.windows: list[object] = []
        self.n_skipped = 0
        self._json = json

    def take(self, message: ModalParameters) -> None:
        """Take the next window."""
        self.windows.append(window_json(message))
        self.n_skipped = message.data_quality.n_windows_skipped
        if not self._json:
            OUTPUT.print(escape(window_line(message)), soft_wrap=True)


def window_line(message: ModalParameters) -> str:
    """Return one line of a window: its time and its natural frequencies."""
    start_s = message.window_start.sec + message.window_start.nanosec / NANOSECONDS_PER_SECOND
    heading = f'window {message.window_index} from {start_s:.3f} s'
    if not message.data_quality.identifiable:
        return f'{heading}: not identifiable, {message.data_quality.reason}'
    modes = ', '.join(
        f'#{mode.id} {FREQUENCY.text(mode.frequency_hz, mode.frequency_std_hz)}'
        for mode in message.modes
        if not mode.harmonic
    )
    return f'{heading}: {modes or "no modes"}'


def window_json(message: ModalParameters) -> object:
    """Return a window as plain values, with the keys of the identification's windows."""
    start_ns = message.window_start.sec * NANOSECONDS_PER_SECOND + message.window_start.nanosec
    length_ns = message.window_length.sec * NANOSECONDS_PER_SECOND + message.window_length.nanosec
    modes = [message_mode_json(mode) for mode in message.modes]
    return {
        'index': message.window_index,
        'start_time_s': start_ns / NANOSECONDS_PER_SECOND,
        'end_time_s': (start_ns + length_ns) / NANOSECONDS_PER_SECOND,
        'modes': [mode for mode in modes if not mode['harmonic']],
        'harmonics': [mode for mode in modes if mode['harmonic']],
        'channels': list(message.channel_names),
        'data_quality': {
            'identifiable': message.data_quality.identifiable,
            'reason': message.data_quality.reason,
            'flags': list(message.data_quality.flags),
            'n_windows_skipped': message.data_quality.n_windows_skipped,
        },
    }


def message_mode_json(message: ModeMessage) -> dict[str, object]:
    """Return a mode with the keys of the files; empty deviations are not known."""
    found: dict[str, object] = {}
    for item in MODE_FIELDS:
        for key in item.keys:
            value = plain(np.asarray(getattr(message, key)).tolist())
            found[key] = value if value != [] or item.default is not None else None
    return found
