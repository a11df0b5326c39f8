"""Keys of a real pseudo-terminal: when they count as pressed, and what becomes of the terminal."""

import os
import pty
import termios

import pytest

from autonomous_modal_analysis.operating.holding import KeyHolding
from autonomous_modal_analysis.operating.keyboard import Keyboard
from modal_core.errors import SettingsError


@pytest.fixture
def terminal():
    mine, theirs = pty.openpty()
    yield mine, theirs
    os.close(mine)
    os.close(theirs)


def test_a_pipe_has_no_key_to_hold():
    read, write = os.pipe()
    with pytest.raises(SettingsError, match='no terminal'):
        Keyboard(read)
    os.close(read)
    os.close(write)


def test_keys_come_at_once_and_the_terminal_is_given_back(terminal):
    mine, theirs = terminal
    before = termios.tcgetattr(theirs)
    os.write(mine, b'typed before\n')
    with Keyboard(theirs) as keyboard:
        keyboard.begin(1.0)
        assert keyboard.look(1.1) == ((), 1.1)
        os.write(mine, b' x')
        keys, _ = keyboard.look(1.2)
        assert keys == (' ', 'x')
    assert termios.tcgetattr(theirs) == before


def test_keys_that_piled_up_count_as_pressed_when_the_queue_was_last_seen_empty(terminal):
    """A process that stood still for two seconds must not take old repeats for fresh ones."""
    mine, theirs = terminal
    with Keyboard(theirs) as keyboard:
        holding, hold = KeyHolding(keyboard), None
        hold = holding.begin(0.0)
        for number in range(1, 60):
            os.write(mine, b' ')
            holding.look(hold, 0.03 * number)
        assert hold.begun and not hold.over
        last_s = 0.03 * 59
        os.write(mine, b'          ')
        holding.look(hold, last_s + 2.0)
        assert hold.over


def test_any_other_key_lets_go(terminal):
    mine, theirs = terminal
    with Keyboard(theirs) as keyboard:
        holding = KeyHolding(keyboard)
        hold = holding.begin(0.0)
        for number in range(1, 60):
            os.write(mine, b' ')
            holding.look(hold, 0.03 * number)
        assert hold.begun
        os.write(mine, b' q')
        holding.look(hold, 1.8)
        assert hold.over
