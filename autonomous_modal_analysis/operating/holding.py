"""Where signs of holding come from: the space bar of a terminal, or a button of a joystick."""

from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager, nullcontext
from typing import Protocol

from autonomous_modal_analysis.operating.hold import BUTTON_SIGNS, GAP_S, Hold, KEY_SIGNS
from autonomous_modal_analysis.operating.keyboard import Keyboard

SPACE = ' '
Buttons = Callable[[], Sequence[tuple[bool, float]]]
"""Returns what came since it was asked last: pressed or not, and when [s]."""


class Holding(Protocol):
    """Looks what is held, and feeds a hold with it."""

    @property
    def words(self) -> str:
        """What a person does to run and to stop."""

    def begin(self, now_s: float) -> Hold:
        """Return a new hold; what was pressed before does not count."""

    def look(self, hold: Hold, now_s: float) -> None:
        """Tell the hold what came since the last look."""


class KeyHolding:
    """The space bar; any other key lets go at once."""

    words = 'hold the SPACE bar down to run; let go, or press any other key, to stop'

    def __init__(self, keyboard: Keyboard) -> None:
        self._keyboard = keyboard

    def begin(self, now_s: float) -> Hold:
        """Return a new hold."""
        self._keyboard.begin(now_s)
        return Hold(KEY_SIGNS)

    def look(self, hold: Hold, now_s: float) -> None:
        """Take the keys."""
        keys, since_s = self._keyboard.look(now_s)
        if any(key != SPACE for key in keys):
            hold.let_go()
        elif keys:
            hold.sign(since_s)
        hold.look(now_s)


class ButtonHolding:
    """A button, which tells when it is let go; it must have been seen up first."""

    def __init__(self, look: Buttons, number: int) -> None:
        self._look, self._number = look, number
        self._seen = self._up = False

    @property
    def words(self) -> str:
        """What to do with it, as far as it was heard."""
        if not self._seen:
            return f'no word of button {self._number} yet: is the joystick on, joy_node running?'
        if not self._up:
            return f'button {self._number} is down already: let it go first'
        return f'hold button {self._number} down to run; let go to stop'

    def begin(self, now_s: float) -> Hold:
        """Return a new hold."""
        self._look()
        self._seen = self._up = False
        return Hold(BUTTON_SIGNS, GAP_S)

    def look(self, hold: Hold, now_s: float) -> None:
        """Take the button's states."""
        for pressed, at_s in self._look():
            self._seen = True
            if not pressed:
                self._up = True
                hold.let_go()
            elif self._up:
                hold.sign(at_s)
        hold.look(now_s)


@contextmanager
def space_bar() -> Iterator[KeyHolding]:
    """Yield the space bar of this terminal, its other keys taken too."""
    with Keyboard() as keyboard:
        yield KeyHolding(keyboard)


def kept(holding: Holding) -> Callable[[], AbstractContextManager[Holding]]:
    """Return a function that yields the same every time."""
    return lambda: nullcontext(holding)
