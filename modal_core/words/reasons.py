"""Why something was turned down: what the rooms log at debug level, brought to where a user looks.

The core logs to ``logging`` and knows no terminal and no node: ``ama -v`` and the log level of a
node open the way.
"""

from collections.abc import Callable
import logging

ROOMS = ('oma_identifier', 'model_gap')
"""Rooms whose modules log their reasons."""


class Reasons(logging.Handler):
    """Hands each reason on as one line.

    Parameters
    ----------
    say : callable
        Takes a line, with the module it comes from in front.
    """

    def __init__(self, say: Callable[[str], object]) -> None:
        super().__init__(logging.DEBUG)
        self._say = say

    def emit(self, record: logging.LogRecord) -> None:
        """Say one reason."""
        self._say(f'{record.name}: {record.getMessage()}')


def say_reasons(say: Callable[[str], object]) -> None:
    """Hand all reasons to ``say`` from now on."""
    for room in ROOMS:
        logger = logging.getLogger(room)
        logger.setLevel(logging.DEBUG)
        logger.propagate = False
        logger.addHandler(Reasons(say))
