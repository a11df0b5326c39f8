"""The wire to Robot Web Services 1.0: HTTP with digest authentication and cookies.

References
----------
ABB Robot Web Services 1.0 for RobotWare 6 (IRC5).
"""

from http.client import HTTPException, HTTPMessage, HTTPResponse
from http.cookiejar import CookieJar
import json
import re
import time
from typing import IO
from urllib.error import HTTPError
from urllib.parse import urlencode
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

LARGEST_ANSWER_BYTES, PIECE_BYTES, MOST_DETAIL_BYTES = 10_000_000, 65_536, 2000
HOST = re.compile(r'[A-Za-z0-9._-]+(:[0-9]{1,5})?')
UNAUTHORISED = 401
# What reading states out of anything at all may end in; brackets without end in the last.
UNEXPECTED = (ValueError, LookupError, TypeError, AttributeError, RecursionError)
NOT_TWO = (
    'Robot Web Services 2.0 of RobotWare 7 are not supported: leave rws_address empty, and load'
    ' and start the module at the pendant'
)


class WebServices:
    """One controller's web services; everything raises BridgeError where it cannot be had.

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

    def value(self, path: str, field: str) -> str:
        """Return one field of a resource.

        Raises
        ------
        BridgeError
            No such field, or the controller cannot be reached.
        """
        try:
            return str(self.states(path)[0][field])
        except LookupError as error:
            raise BridgeError('unexpected answer of the controller', where=path) from error

    def states(self, path: str, **query: str) -> list[dict[str, str]]:
        """Return the states of a resource, every field as text."""
        answer = self.ask('GET', f'{path}?{urlencode({**query, "json": 1})}')
        try:
            states = json.loads(answer)['_embedded']['_state']
            return [{str(key): str(item) for key, item in state.items()} for state in states]
        except UNEXPECTED as error:
            raise BridgeError('unexpected answer of the controller', where=path) from error

    def expect(self, path: str, field: str, expected: str) -> None:
        """Refuse another value of a field of a resource."""
        found = self.value(path, field)
        if found != expected:
            raise BridgeError(
                'the controller is not ready', where=field, found=found, expected=expected
            )

    def post(self, path: str, form: dict[str, str]) -> None:
        """Ask for an action."""
        self.ask('POST', path, urlencode(form).encode())

    def ask(self, method: str, path: str, data: bytes | None = None) -> bytes:
        """Return the answer to one request."""
        request = Request(self._base + path, data=data, method=method)  # noqa: S310
        kind = 'text/plain' if method == 'PUT' else 'application/x-www-form-urlencoded'
        request.add_header('Content-Type', kind)
        try:
            until_s = time.monotonic() + self._timeout_s
            with self._opener.open(request, timeout=self._timeout_s) as answer:
                return _content(answer, until_s)
        except HTTPError as error:
            detail = _detail(error)
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
        except (OSError, HTTPException, ValueError, LookupError) as error:
            reason = getattr(error, 'reason', None) or error
            raise BridgeError(
                f'the controller cannot be reached: {reason}', where=self._base
            ) from error


def _detail(error: HTTPError) -> str:
    """Return what a refusal says, as far as it comes at once."""
    try:
        return bytes(error.read1(MOST_DETAIL_BYTES)).decode(errors='replace')
    except (OSError, HTTPException, ValueError):
        return ''


def _content(answer: HTTPResponse, until_s: float) -> bytes:
    """Return what comes until a time: the time-out of a socket is that of each piece alone."""
    content = bytearray()
    while piece := answer.read1(PIECE_BYTES):
        content += piece
        if time.monotonic() > until_s:
            raise TimeoutError('timed out')
        if len(content) > LARGEST_ANSWER_BYTES:
            raise OSError(f'an answer of more than {LARGEST_ANSWER_BYTES} bytes')
    return bytes(content)


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
