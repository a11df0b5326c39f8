"""One HTTP or HTTPS connection to a controller's web services: requests, answers, errors."""

from base64 import b64encode
from http.client import HTTPException, HTTPMessage, HTTPResponse
from http.cookiejar import CookieJar
import ssl
import time
from typing import IO
from urllib.error import HTTPError, URLError
from urllib.request import (
    BaseHandler,
    build_opener,
    HTTPCookieProcessor,
    HTTPDigestAuthHandler,
    HTTPPasswordMgrWithDefaultRealm,
    HTTPRedirectHandler,
    OpenerDirector,
    ProxyHandler,
    Request,
)

from modal_core.errors import BridgeError
from robot_bridge.rws.certificate import not_known, PinnedHandler, Trust
from robot_bridge.rws.wording import FILE, FORM, Wording

LARGEST_ANSWER_BYTES, PIECE_BYTES, MOST_DETAIL_BYTES = 10_000_000, 65_536, 2000
UNAUTHORISED = 401
FAILURES = (OSError, HTTPException, ValueError, LookupError)
"""What a request ends in when there is no answer of a web server."""


class WebWire:
    """Requests to one place in one wording.

    Parameters
    ----------
    base : str
        Scheme, host and port.
    words : Wording
        Of the version.
    account : tuple of str
        User and password.
    trust : Trust
        Of the certificate.
    timeout_s : float [s]
        Longest wait for an answer.
    """

    def __init__(
        self,
        base: str,
        words: Wording,
        account: tuple[str, str],
        trust: Trust,
        timeout_s: float,
    ) -> None:
        self.base, self.words, self._timeout_s = base, words, timeout_s
        self._headers = dict(words.headers)
        handlers: list[BaseHandler] = [HTTPCookieProcessor(CookieJar())]
        if words.version == 1:
            passwords = HTTPPasswordMgrWithDefaultRealm()
            passwords.add_password(None, base, *account)
            handlers.append(HTTPDigestAuthHandler(passwords))
        else:
            word = b64encode(':'.join(account).encode()).decode()
            self._headers['Authorization'] = f'Basic {word}'
        self._opener = opener(trust, *handlers)

    def ask(self, method: str, path: str, data: bytes | None = None) -> bytes:
        """Return the answer to one request.

        Raises
        ------
        BridgeError
            The controller refuses, or cannot be reached.
        """
        request = self._request(method, path, data)
        try:
            until_s = time.monotonic() + self._timeout_s
            with self._opener.open(request, timeout=self._timeout_s) as answer:
                return _content(answer, until_s)
        except HTTPError as error:
            raise self._refused(error, f'{method} {path.split("?")[0]}') from error
        except FAILURES as error:
            raise unreachable(self.base, error) from error

    def _request(self, method: str, path: str, data: bytes | None) -> Request:
        request = Request(self.base + path, data=data, method=method)  # noqa: S310
        headers = dict(self._headers)
        if path.startswith('/fileservice'):
            # Files come as they are, whatever is accepted.
            headers.pop('Accept', None)
        kind = FILE if method == 'PUT' else FORM
        if data is not None or self.words.version == 1:
            headers['Content-Type'] = kind + self.words.media_ending
        for name, value in headers.items():
            request.add_unredirected_header(name, value)
        return request

    def _refused(self, error: HTTPError, what: str) -> BridgeError:
        detail = _detail(error)
        asks_for = error.headers.get('WWW-Authenticate', '').lower()
        if 300 <= error.code < 400 or (asks_for.startswith('basic') and self.words.version == 1):
            return BridgeError(
                'no Robot Web Services 1.0 here any more', where=self.base,
                advice='was the controller changed? then start the bridge again',
            )  # fmt: skip
        if error.code == UNAUTHORISED:
            return BridgeError(
                'the controller refuses user or password',
                where=self.base,
                advice='set rws_user, and rws_password_file or AMA_RWS_PASSWORD',
            )
        return BridgeError(
            f'the controller refuses {what}',
            where=self.base,
            found=f'{error.code} {detail}'.strip(),
        )


def opener(trust: Trust, *handlers: BaseHandler) -> OpenerDirector:
    """Return what opens requests: to the controller itself and nobody else."""
    # No proxy: a controller is on the machine's own network.
    return build_opener(ProxyHandler({}), PinnedHandler(trust), _NoRedirection(), *handlers)


def unreachable(base: str, error: BaseException) -> BridgeError:
    """Return the error of a request without an answer."""
    reason = getattr(error, 'reason', None) or error
    return BridgeError(f'the controller cannot be reached: {reason}', where=base)


def certificate_error(
    host: str, port: int, timeout_s: float, error: BaseException
) -> BridgeError | None:
    """Return the error of a certificate nobody vouches for; None when it is something else."""
    reason = error.reason if isinstance(error, URLError) else error
    if not isinstance(reason, ssl.SSLCertVerificationError):
        return None
    return not_known(host, port, timeout_s, reason.verify_message)


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
