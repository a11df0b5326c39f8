"""Robot Web Services: load a program into the controller, start it, stop it."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Protocol

from robot_bridge.rws.released_program import ReleasedProgram
from robot_bridge.rws.rws_checks import (
    check_automatic,
    check_loaded,
    check_once,
    check_place,
    check_ready,
    names_like,
)
from robot_bridge.rws.web_services import RwsAccess, WebServices

# Once, and without a way back to a path that was left before.
START = {
    'regain': 'clear',
    'execmode': 'continue',
    'cycle': 'once',
    'condition': 'none',
    'stopatbp': 'disabled',
    'alltaskbytsp': 'false',
}
STOP = {'stopmode': 'stop', 'usetsp': 'normal'}


class ProgramControl(Protocol):
    """Runs a program in the controller; every method raises BridgeError when it cannot."""

    def check_automatic(self) -> None:
        """Refuse any mode but automatic."""

    def check(self, program: ReleasedProgram) -> None:
        """Refuse a controller that is not ready, or an arm that is not at the program's start."""

    def load(self, program: ReleasedProgram) -> None:
        """Load a program and go to its beginning; nothing runs yet."""

    def run(self, program: ReleasedProgram, check_wanted: Callable[[], None]) -> None:
        """Run what was loaded, once, if it is this and the arm stands at its start."""

    def stop(self) -> None:
        """Stop the program."""


class RwsClient:
    """One controller's web services.

    Parameters
    ----------
    access : RwsAccess
        Where they are, and who asks.
    """

    def __init__(self, access: RwsAccess) -> None:
        self._web = WebServices(access)

    def check_automatic(self) -> None:
        """Refuse any mode but automatic.

        Raises
        ------
        BridgeError
            Another mode, or the controller cannot be reached.
        """
        check_automatic(self._web)

    def check(self, program: ReleasedProgram) -> None:
        """Refuse a controller that is not ready, or an arm that is not at the program's start.

        Raises
        ------
        BridgeError
            Not in automatic mode, motors off, a program running, another task that would be
            started too, an axis away from the start, or no answer.
        """
        check_ready(self._web)
        check_place(self._web, program)

    def load(self, program: ReleasedProgram) -> None:
        """Load a program and go to its beginning; nothing runs yet.

        Raises
        ------
        BridgeError
            See :meth:`check`, or the controller refuses.
        """
        self.check(program)
        path = f'$HOME/{program.name}.mod'
        with self._mastership():
            self._web.put_file(path, program.text.encode())
            for older in names_like(self._web, program.name):
                self._web.post('unload', {'module': older})
            self._web.post('load', {'modulepath': path, 'replace': 'true'})
            self._web.post('reset')

    def run(
        self, program: ReleasedProgram, check_wanted: Callable[[], None] = lambda: None
    ) -> None:
        """Run what was loaded, once, if it is this and the arm stands at its start.

        Parameters
        ----------
        program : ReleasedProgram
            What must be loaded.
        check_wanted : callable
            Raises when it is not wanted any more; asked last, since every answer may be slow.

        Raises
        ------
        BridgeError
            Anything is not as it was released, or the controller refuses or cannot be reached.
        """
        with self._mastership():
            check_ready(self._web)
            check_loaded(self._web, program)
            check_place(self._web, program)
            if self._web.words.starts_as_master:
                check_wanted()
                self._web.post('start', START)
        if not self._web.words.starts_as_master:
            check_wanted()
            self._web.post('start', START)
        check_once(self._web)

    def stop(self) -> None:
        """Stop the program.

        Raises
        ------
        BridgeError
            The controller refuses or cannot be reached.
        """
        self._web.post('stop', STOP)

    @contextmanager
    def _mastership(self) -> Iterator[None]:
        """Let nobody else change the program meanwhile."""
        self._web.post('request')
        try:
            yield
        finally:
            self._web.post('release')
