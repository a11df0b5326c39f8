"""Robot Web Services 1.0: load a program into the controller, start it, stop it.

References
----------
ABB Robot Web Services 1.0 for RobotWare 6 (IRC5): HTTP with digest authentication and cookies.
"""

from http.client import HTTPException, HTTPMessage
from http.cookiejar import CookieJar
import json
import re
from typing import IO, Protocol
from urllib.error import HTTPError
from urllib.parse import quote, urlencode
from urllib.request import (
    build_opener,
    HTTPCookieProcessor,
    HTTPDigestAuthHandler,
    HTTPPasswordMgrWithDefaultRealm,
    HTTPRedirectHandler,
    ProxyHandler,
    Request,
)

from modal_core.errors import BridgeError

LARGEST_ANSWER_BYTES = 1_000_000
START = {
    'regain': 'continue',
    'execmode': 'continue',
    'cycle': 'once',
    'condition': 'none',
    'stopatbp': 'disabled',
    'alltaskbytsp': 'false',
}
STOP = {'stopmode': 'stop', 'usetsp': 'normal'}
HOST = re.compile(r'[A-Za-z0-9._-]+(:[0-9]{1,5})?')
UNAUTHORISED = 401
NOT_TWO = (
    'Robot Web Services 2.0 of RobotWare 7 are not supported: leave rws_address empty, and load'
    ' and start the module at the pendant'
)


class ProgramControl(Protocol):
    """Runs a program in the controller; every method raises BridgeError when it cannot."""

    def check_automatic(self) -> None:
        """Refuse any mode but automatic."""

    def load(self, name: str, module: str) -> None:
        """Load a module of this name and go to its beginning; nothing runs yet."""

    def run(self) -> None:
        """Run what was loaded."""

    def stop(self) -> None:
        """Stop the program."""


class RwsClient:
    """One controller's web services.

    Parameters
    ----------
    address : str
        Host, or host:port.
    user, password : str
        Account on the controller.
    timeout_s : float [s]
        Longest wait for an answer.
    """

    def __init__(self, address: str, user: str, password: str, timeout_s: float = 3.0) -> None:
        host = address.removeprefix('http://').rstrip('/')
        if not HOST.fullmatch(host):
            advice = NOT_TWO if address.startswith('https') else ''
            raise BridgeError(
                'not an address of Robot Web Services 1.0',
                where='rws_address',
                found=address,
                expected='host or host:port',
                advice=advice,
            )
        self._base, self._timeout_s = f'http://{host}', timeout_s
        passwords = HTTPPasswordMgrWithDefaultRealm()
        passwords.add_password(None, self._base, user, password)
        # No proxy: a controller is on the machine's own network.
        self._opener = build_opener(
            ProxyHandler({}),
            HTTPCookieProcessor(CookieJar()),
            HTTPDigestAuthHandler(passwords),
            _NoRedirection(),
        )

    def check_automatic(self) -> None:
        """Refuse any mode but automatic.

        Raises
        ------
        BridgeError
            Another mode, or the controller cannot be reached.
        """
        self._expect('/rw/panel/opmode', 'opmode', 'AUTO')

    def load(self, name: str, module: str) -> None:
        """Load a module and go to its beginning; nothing runs yet.

        Raises
        ------
        BridgeError
            Not in automatic mode, motors off, a program running, or the controller refuses.
        """
        self.check_automatic()
        self._expect('/rw/panel/ctrlstate', 'ctrlstate', 'motoron')
        self._expect('/rw/rapid/execution', 'ctrlexecstate', 'stopped')
        file = quote(f'{name}.mod')
        self._ask('PUT', f'/fileservice/$HOME/{file}', module.encode())
        self._post('/rw/rapid/tasks/T_ROB1?action=loadmod', {
            'modulepath': f'$HOME/{name}.mod', 'replace': 'true',
        })  # fmt: skip
        self._post('/rw/rapid/execution?action=resetpp', {})

    def run(self) -> None:
        """Run what was loaded, once, from its beginning.

        Raises
        ------
        BridgeError
            The controller refuses or cannot be reached.
        """
        self._post('/rw/rapid/execution?action=start', START)

    def stop(self) -> None:
        """Stop the program.

        Raises
        ------
        BridgeError
            The controller refuses or cannot be reached.
        """
        self._post('/rw/rapid/execution?action=stop', STOP)

    def value(self, path: str, field: str) -> str:
        """Return one field of a resource.

        Raises
        ------
        BridgeError
            No such field, or the controller cannot be reached.
        """
        answer = self._ask('GET', f'{path}?json=1')
        try:
            return str(json.loads(answer)['_embedded']['_state'][0][field])
        except (ValueError, LookupError, TypeError) as error:
            raise BridgeError('unexpected answer of the controller', where=path) from error

    def _expect(self, path: str, field: str, expected: str) -> None:
        found = self.value(path, field)
        if found != expected:
            raise BridgeError(
                'the controller is not ready', where=field, found=found, expected=expected
            )

    def _post(self, path: str, form: dict[str, str]) -> None:
        self._ask('POST', path, urlencode(form).encode())

    def _ask(self, method: str, path: str, data: bytes | None = None) -> bytes:
        request = Request(self._base + path, data=data, method=method)  # noqa: S310
        kind = 'text/plain' if method == 'PUT' else 'application/x-www-form-urlencoded'
        request.add_header('Content-Type', kind)
        try:
            with self._opener.open(request, timeout=self._timeout_s) as answer:
                return bytes(answer.read(LARGEST_ANSWER_BYTES))
        except HTTPError as error:
            detail = error.read(2000).decode(errors='replace')
            asks_for = error.headers.get('WWW-Authenticate', '').lower()
            if 300 <= error.code < 400 or asks_for.startswith('basic'):
                raise BridgeError(
                    'no Robot Web Services 1.0 here', where=self._base, advice=NOT_TWO
                ) from error
            if error.code == UNAUTHORISED:
                raise BridgeError(
                    'the controller refuses user or password',
                    where=self._base,
                    advice='set rws_user, and rws_password_file or AMA_RWS_PASSWORD',
                ) from error
            raise BridgeError(
                f'the controller refuses {method} {path.split("?")[0]}',
                where=self._base,
                found=f'{error.code} {detail}'.strip(),
            ) from error
        except (OSError, HTTPException, ValueError) as error:
            reason = getattr(error, 'reason', None) or error
            raise BridgeError(
                f'the controller cannot be reached: {reason}', where=self._base
            ) from error


class _NoRedirection(HTTPRedirectHandler):
    """A controller that sends us elsewhere is not the one we were told of."""

    def redirect_request(
        self,
        req: Request,
        fp: IO[bytes],
        code: int,
        msg: str,
        headers: HTTPMessage,
        newurl: str,
    ) -> None:
        """Follow nothing: it becomes an error."""
