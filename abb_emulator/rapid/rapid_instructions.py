"""The instructions the emulator executes, and what each takes; everything else is refused."""

from dataclasses import dataclass, field
from types import MappingProxyType

from abb_emulator.rapid.rapid_syntax import IDENT, MIN_MAX, NUM, SPEED, STRING, TARGET

SWITCH = 'switch'
# What functions take and give.
FUNCTIONS = MappingProxyType({'abs': ((NUM,), NUM), 'cjointt': ((), TARGET)})
AXES = tuple(f'j{number}' for number in range(1, 7))
WORDS = {
    'fine': ('fine',),
    'ending': ('egm_stop_hold', 'egm_stop_ramp_down'),
}
# Names that the configuration or other modules of the controller must know.
SIGNAL, UNIT = 'signal', 'mechanical unit'
SYSTEM_DATA = ('tooldata', 'wobjdata', 'loaddata')
TOOL, WORK_OBJECT, LOAD = SYSTEM_DATA
CONFIGURED = (SIGNAL, UNIT, *SYSTEM_DATA)


@dataclass(frozen=True, slots=True)
class Signature:
    """Arguments of one instruction.

    Parameters
    ----------
    arguments : tuple of str
        Type of each positional argument, or a key of ``WORDS``.
    options : mapping of str to str
        Type of each optional argument.
    """

    arguments: tuple[str, ...] = ()
    options: MappingProxyType[str, str] = field(default_factory=lambda: MappingProxyType({}))


def _takes(*arguments: str, **options: str) -> Signature:
    return Signature(arguments, MappingProxyType(options))


INSTRUCTIONS = MappingProxyType(
    {
        'moveabsj': _takes(
            TARGET,
            SPEED,
            'fine',
            TOOL,
            noeoffs=SWITCH,
            t=NUM,
            v=NUM,
            wobj=WORK_OBJECT,
            tload=LOAD,
        ),
        'setdo': _takes(SIGNAL, NUM),
        'waittime': _takes(NUM, inpos=SWITCH),
        'accset': _takes(NUM, NUM),
        'velset': _takes(NUM, NUM),
        'motionsup': _takes(on=SWITCH, off=SWITCH, tunevalue=NUM),
        'confj': _takes(on=SWITCH, off=SWITCH),
        'tpwrite': _takes(STRING, num=NUM),
        'tperase': _takes(),
        'stopmove': _takes(),
        'stop': _takes(),
        'exit': _takes(),
        'return': _takes(),
        'retry': _takes(),
        'trynext': _takes(),
        'raise': _takes(),
        'egmreset': _takes(IDENT),
        'egmgetid': _takes(IDENT),
        'egmsetupuc': _takes(UNIT, IDENT, STRING, STRING, joint=SWITCH, commtimeout=NUM),
        'egmstreamstart': _takes(IDENT, samplerate=NUM),
        'egmstreamstop': _takes(IDENT),
        'egmactjoint': _takes(
            IDENT,
            **dict.fromkeys(AXES, MIN_MAX),
            lpfilter=NUM,
            samplerate=NUM,
            maxposdeviation=NUM,
            maxspeeddeviation=NUM,
        ),
        'egmrunjoint': _takes(
            IDENT,
            'ending',
            **dict.fromkeys(AXES, SWITCH),
            condtime=NUM,
            rampintime=NUM,
            rampouttime=NUM,
            poscorrgain=NUM,
        ),
    }
)
