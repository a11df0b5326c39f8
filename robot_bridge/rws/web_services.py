"""A controller's web services, in the version that answers.

Before the password is told, the controller is asked who it is: HTTP that asks for digest
authentication is version 1.0; HTTP that sends elsewhere, asks for the password itself or is not
there leads to HTTPS, which is version 2.0 and goes on only with the right certificate.
"""

from dataclasses import dataclass
import re
from urllib.error import HTTPError
from urllib.parse import quote, urlencode
from urllib.request import Request

from modal_core.errors import BridgeError
from robot_bridge.rws.certificate import Trust
from robot_bridge.rws.web_wire import (
    certificate_error,
    FAILURES,
    opener,
    UNAUTHORISED,
    unreachable,
    WebWire,
)
from robot_bridge.rws.wording import VERSION_1_WORDS, VERSION_2_WORDS, Wording

ADDRESS = re.compile(r'(?:(https?)://)?([A-Za-z0-9._-]+)(?::([0-9]{1,5}))?/?')
PORTS = {'http': 80, 'https': 443}
# What reading states out of anything at all may end in; brackets without end in the last.
UNEXPECTED = (ValueError, LookupError, TypeError, AttributeError, RecursionError)


@dataclass(frozen=True, slots=True)
class RwsAccess:
    """How a controller's web services are reached.

    Parameters
    ----------
    address : str
        Host or host:port, in front of it ``http://`` or ``https://`` when no other may answer.
    user, password : str
        Account on the controller.
    timeout_s : float [s]
        Longest wait for an answer.
    certificate : str
        SHA-256 of the certificate of HTTPS, or a PEM file of who vouches for it; empty: those
        that this machine knows.
    task, unit : str
        The motion task and its robot.
    """

    address: str
    user: str
    password: str
    timeout_s: float = 3.0
    certificate: str = ''
    task: str = 'T_ROB1'
    unit: str = 'ROB_1'


class WebServices:
    """One controller's web services; everything raises BridgeError where it cannot be had.

    Parameters
    ----------
    access : RwsAccess
        Where, and who asks.
    """

    def __init__(self, access: RwsAccess) -> None:
        found = ADDRESS.fullmatch(access.address)
        if not found:
            raise BridgeError(
                'not an address of Robot Web Services',
                where='rws_address',
                found=access.address,
                expected='host or host:port, with http:// or https:// before it if need be',
            )
        self._access, self._trust = access, Trust.from_text(access.certificate)
        self._scheme, self._host, self._port = found[1] or '', found[2], found[3] or ''
        if self._trust != Trust():
            # A certificate is asked for: nothing without one will do.
            self._scheme = self._scheme or 'https'
        if self._scheme == 'http' and self._trust != Trust():
            raise BridgeError(
                'HTTP has no certificate', where='rws_address', found=access.address,
                expected='https://, or no rws_certificate',
            )  # fmt: skip
        self._wire: WebWire | None = None

    @property
    def task(self) -> str:
        """The motion task."""
        return self._access.task

    @property
    def words(self) -> Wording:
        """How the version that answers words things."""
        return self._connected().words

    def value(self, what: str, field: str) -> str:
        """Return one field of a resource, by its name in :class:`Wording`.

        Raises
        ------
        BridgeError
            No such field, or the controller cannot be reached.
        """
        try:
            return str(self.states(what)[0][field])
        except LookupError as error:
            raise BridgeError('unexpected answer of the controller', where=what) from error

    def states(self, what: str, name: str = '') -> list[dict[str, str]]:
        """Return the states of a resource, every field as text."""
        wire, path = self._connected(), self._path(what, name)
        mark = '&' if '?' in path else '?'
        ending = wire.words.ending
        answer = wire.ask('GET', f'{path}{mark}{ending}' if ending else path)
        try:
            return wire.words.states(answer)
        except UNEXPECTED as error:
            raise BridgeError('unexpected answer of the controller', where=path) from error

    def expect(self, what: str, field: str, expected: str) -> None:
        """Refuse another value of a field of a resource."""
        found = self.value(what, field)
        if found != expected:
            raise BridgeError(
                'the controller is not ready', where=field, found=found, expected=expected
            )

    def post(self, what: str, form: dict[str, str] | None = None) -> None:
        """Ask for an action."""
        self._connected().ask('POST', self._path(what), urlencode(form or {}).encode())

    def put_file(self, path: str, data: bytes) -> None:
        """Write a file of the controller."""
        self._connected().ask('PUT', f'/fileservice/{quote(path, safe="/$")}', data)

    def file(self, path: str) -> bytes:
        """Return a file of the controller."""
        return self._connected().ask('GET', f'/fileservice/{quote(path, safe="/$")}')

    def _path(self, what: str, name: str = '') -> str:
        path: str = getattr(self.words, what)
        access = self._access
        return path.format(task=access.task, unit=access.unit, name=quote(name))

    # -- which version answers -----------------------------------------------------------------

    def _connected(self) -> WebWire:
        if self._wire is None:
            words = self._who_answers()
            base = self._base('https' if words.version == 2 else 'http')
            account = (self._access.user, self._access.password)
            self._wire = WebWire(base, words, account, self._trust, self._access.timeout_s)
        return self._wire

    def _who_answers(self) -> Wording:
        """Return the version of whoever answers; no password is told meanwhile."""
        failure: BridgeError | None = None
        if self._scheme != 'https':
            try:
                status, asks_for = self._knock('http')
            except FAILURES as error:
                failure = unreachable(self._base('http'), error)
            else:
                elsewhere = 300 <= status < 400
                if not elsewhere and not (status == UNAUTHORISED and asks_for == 'basic'):
                    return VERSION_1_WORDS
        if self._scheme == 'http':
            raise failure or BridgeError(
                'the controller takes the password on HTTPS alone', where=self._base('http'),
                advice='leave http:// out of rws_address, or load and start at the pendant',
            )  # fmt: skip
        try:
            self._knock('https')
        except FAILURES as error:
            port = int(self._port or PORTS['https'])
            bad = certificate_error(self._host, port, self._access.timeout_s, error)
            raise (bad or failure or unreachable(self._base('https'), error)) from error
        return VERSION_2_WORDS

    def _knock(self, scheme: str) -> tuple[int, str]:
        """Return the status of an answer and how it asks who is there."""
        request = Request(f'{self._base(scheme)}/rw/system', method='GET')  # noqa: S310
        for name, value in VERSION_2_WORDS.headers.items() if scheme == 'https' else ():
            request.add_header(name, value)
        try:
            with opener(self._trust).open(request, timeout=self._access.timeout_s) as answer:
                return int(answer.status), ''
        except HTTPError as error:
            with error:
                asks_for = error.headers.get('WWW-Authenticate', '')
                return error.code, asks_for.partition(' ')[0].lower()

    def _base(self, scheme: str) -> str:
        port = f':{self._port}' if self._port else ''
        return f'{scheme}://{self._host}{port}'
