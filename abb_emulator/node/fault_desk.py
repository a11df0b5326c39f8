"""The faults of real cells, put in by name and taken out again after their time."""

from collections.abc import Callable
from dataclasses import dataclass

from abb_emulator.controller import Controller
from abb_emulator.egm import LinkFault, LinkFaults
from abb_emulator.sensing import SensorArray
from modal_core.errors import BridgeError

CLEAR = 'clear'
LINK_SIDES = ('robot', 'sensor')


@dataclass(frozen=True, slots=True)
class FaultKind:
    """One fault that can be put in.

    Parameters
    ----------
    name : str
        As asked for.
    text : str
        What happens, and what value means.
    default : float
        Value taken when it is 0.
    highest : float
        Largest value.
    lasting : bool
        Goes on until cleared; the others happen once.
    """

    name: str
    text: str
    default: float = 0.0
    highest: float = 1.0
    lasting: bool = True


KINDS = (
    FaultKind('drop', 'fraction of the packets lost', 0.1),
    FaultKind('duplicate', 'fraction of the packets sent twice', 0.1),
    FaultKind('reorder', 'fraction of the packets overtaken by the next', 0.1),
    FaultKind('delay', 'delay of every packet [s]', 0.05, 10.0),
    FaultKind('clock_skew', "the controller's clock runs fast by this fraction", 0.008, 0.5),
    FaultKind('restart_session', 'the session begins again at seqno 0', lasting=False),
    FaultKind('rapid_undefined', 'the execution state is reported as UNDEFINED'),
    FaultKind('sensor_dropout', 'channels read zero'),
    FaultKind('sensor_clipping', 'channels clip at this reading [m/s²]', 1.0, 1e4),
    FaultKind('sensor_nan', 'fraction of the samples that are not a number', 0.1),
    FaultKind('sensor_flatline', 'channels keep their last reading'),
    FaultKind('sensor_spike', 'size of spikes in one sample of a hundred [m/s²]', 50.0, 1e6),
    FaultKind('block_dropout', 'fraction of the sample blocks lost', 0.1),
    FaultKind('e_stop', 'emergency stop', lasting=False),
    FaultKind('collision_stop', 'motion supervision stops for a collision', lasting=False),
    FaultKind('motors_off', 'motors go off', lasting=False),
)
SHORT = {f'sensor_{name}': name for name in ('clipping', 'nan', 'flatline', 'spike')}
BY_NAME = {kind.name: kind for kind in KINDS} | {
    short: kind for kind in KINDS for name, short in SHORT.items() if kind.name == name
}


def fault_list() -> str:
    """Return all faults and what their value means, as one line."""
    return f'{CLEAR}; ' + '; '.join(f'{kind.name}: {kind.text}' for kind in KINDS)


@dataclass(frozen=True, slots=True)
class Fault:
    """A fault asked for.

    Parameters
    ----------
    name : str
        One of ``KINDS``.
    value : float
        Its size; 0 is the default.
    duration_s : float [s]
        Ends after this time of the controller; 0 is never.
    target : str
        ``robot`` or ``sensor`` (whose packets suffer), or a sensor or channel; empty: all.
    """

    name: str
    value: float = 0.0
    duration_s: float = 0.0
    target: str = ''

    @classmethod
    def from_text(cls, text: str) -> 'Fault':
        """Read ``name[:value[:duration_s[:target]]]``.

        Raises
        ------
        BridgeError
            Numbers are none.
        """
        name, value, duration, target = [*text.split(':', 3), '', '', ''][:4]
        try:
            return cls(name, float(value or 0.0), float(duration or 0.0), target)
        except ValueError as error:
            raise BridgeError('not a number', where='fault', found=text) from error


class FaultDesk:
    """Puts faults into controller, link and sensors.

    Parameters
    ----------
    controller : Controller
        Suffers e-stops, restarts and clock skew.
    link : LinkFaults
        Of the EGM link.
    sensors : SensorArray
        Of the recorder.
    channel_names : tuple of str
        Its columns.
    """

    def __init__(
        self,
        controller: Controller,
        link: LinkFaults,
        sensors: SensorArray,
        channel_names: tuple[str, ...],
    ) -> None:
        self._controller, self._link, self._sensors = controller, link, sensors
        self._names = channel_names
        self._ends: dict[tuple[str, str], tuple[float, Callable[[], None]]] = {}
        self._time_s = 0.0

    def put(self, fault: Fault) -> str:
        """Put a fault in and return what happens now, in words.

        Raises
        ------
        BridgeError
            No such fault, target or value; the message lists the faults.
        """
        if fault.name == CLEAR:
            self.clear()
            return 'all faults ended'
        kind = BY_NAME.get(fault.name)
        if kind is None:
            raise BridgeError('unknown fault', found=fault.name, expected=fault_list())
        value = fault.value or kind.default
        if not 0.0 <= value <= kind.highest or not fault.duration_s >= 0.0:
            raise BridgeError(
                kind.text, where=kind.name, found=f'{fault.value} for {fault.duration_s} s',
                expected=f'0 to {kind.highest:g}, a duration of 0 or more',
            )  # fmt: skip
        end = self._begin(kind, value, fault.target)
        if kind.lasting:
            until_s = self._time_s + fault.duration_s if fault.duration_s > 0.0 else float('inf')
            self._ends[kind.name, fault.target] = (until_s, end)
        self._controller.note(f'fault: {kind.name} {value:g} {fault.target}'.strip())
        return f'{kind.name}: {kind.text}, {value:g}' if kind.default else kind.text

    def tick(self, step_s: float) -> None:
        """Let time pass; faults whose time is over end."""
        self._time_s += step_s
        for key, (until_s, end) in tuple(self._ends.items()):
            if self._time_s >= until_s:
                del self._ends[key]
                end()

    def clear(self) -> None:
        """End all faults that last."""
        for _, end in self._ends.values():
            end()
        self._ends.clear()

    @property
    def active(self) -> tuple[str, ...]:
        """Faults that last at the moment."""
        return tuple(' '.join(key).strip() for key in self._ends)

    def _begin(self, kind: FaultKind, value: float, target: str) -> Callable[[], None]:
        controller = self._controller
        if kind.name in ('drop', 'duplicate', 'reorder', 'delay'):
            return self._spoil_link(kind.name, value, target)
        if kind.name.startswith('sensor_') or kind.name == 'block_dropout':
            return self._spoil_sensors(kind.name, value, target)
        if target:
            raise BridgeError('takes no target', where=kind.name, found=target)
        if kind.name in ('clock_skew', 'rapid_undefined'):
            setattr(controller, kind.name, value if kind.name == 'clock_skew' else True)
            calm = 0.0 if kind.name == 'clock_skew' else False
            return lambda: setattr(controller, kind.name, calm)
        happen: dict[str, Callable[[], None]] = {
            'restart_session': controller.restart_session,
            'e_stop': controller.emergency_stop,
            'collision_stop': controller.collide,
            'motors_off': controller.motors_off,
        }
        happen[kind.name]()
        return lambda: None

    def _spoil_link(self, name: str, value: float, target: str) -> Callable[[], None]:
        if target and target not in LINK_SIDES:
            raise BridgeError(
                'no such side', where=name, found=target, expected=', '.join(LINK_SIDES)
            )
        sides: list[LinkFault] = [
            getattr(self._link, side) for side in LINK_SIDES if target in ('', side)
        ]
        field = 'delay_s' if name == 'delay' else name

        def put(size: float) -> None:
            for side in sides:
                setattr(side, field, size)

        put(value)
        return lambda: put(0.0)

    def _spoil_sensors(self, name: str, value: float, target: str) -> Callable[[], None]:
        if name == 'block_dropout':
            self._sensors.block_dropout = value
            return lambda: setattr(self._sensors, 'block_dropout', 0.0)
        columns = tuple(
            index
            for index, channel in enumerate(self._names)
            if not target or channel == target or channel.split('.')[0] == target
        )
        if not columns:
            raise BridgeError(
                'no such sensor or channel', where=name, found=target,
                expected=', '.join(self._names[:6]) + ' ...',
            )  # fmt: skip
        self._sensors.faults[name] = (value, columns)
        return lambda: self._sensors.forget_fault(name)
