"""Whether the certificate of a controller is the right one: known, or pinned by its fingerprint.

Controllers come with certificates they made themselves, which nobody vouches for.
"""

from dataclasses import dataclass
from functools import partial
import hashlib
from http.client import HTTPResponse, HTTPSConnection
from pathlib import Path
import re
import socket
import ssl
from typing import Any
from urllib.request import HTTPSHandler, Request

from modal_core.errors import BridgeError

SETTING = 'rws_certificate'
_FINGERPRINT = re.compile(r'(?:sha256:)?((?:[0-9a-f]{2}:?){31}[0-9a-f]{2})', re.IGNORECASE)


@dataclass(frozen=True, slots=True)
class Trust:
    """What a controller's certificate must be.

    Parameters
    ----------
    fingerprint : str
        SHA-256 of it, 64 hexadecimal digits in lower case; empty: somebody known vouches for it.
    authorities : Path or None
        PEM file of those who are known; None: those of this machine.
    """

    fingerprint: str = ''
    authorities: Path | None = None

    @classmethod
    def from_text(cls, text: str) -> 'Trust':
        """Return trust out of a setting: a fingerprint, a file, or nothing.

        Raises
        ------
        BridgeError
            Neither a fingerprint nor a readable file.
        """
        if not text:
            return cls()
        found = _FINGERPRINT.fullmatch(text.replace(' ', ''))
        if found:
            return cls(fingerprint=found[1].replace(':', '').lower())
        file = Path(text).expanduser()
        trust = cls(authorities=file)
        try:
            trust.context()
        except (OSError, ValueError) as error:
            raise BridgeError(
                'neither a fingerprint nor certificates in PEM', where=SETTING, found=text[:80],
                expected='64 hexadecimal digits of SHA-256, or a file',
            ) from error  # fmt: skip
        return trust

    def context(self) -> ssl.SSLContext:
        """Return the TLS context that goes with it."""
        if self.fingerprint:
            # Compared by :meth:`check` before anything is sent.
            return _any_certificate()
        return ssl.create_default_context(cafile=self.authorities)

    def check(self, certificate: bytes, where: str) -> None:
        """Refuse another certificate than the one that is pinned.

        Raises
        ------
        BridgeError
            It is another one.
        """
        found = hashlib.sha256(certificate).hexdigest()
        if self.fingerprint and found != self.fingerprint:
            raise BridgeError(
                'the controller has another certificate than the one that is pinned',
                where=where, found=f'SHA-256 {found}', expected=self.fingerprint,
                advice=f'find out why; set {SETTING} only to what the controller itself shows',
            )  # fmt: skip


class PinnedHandler(HTTPSHandler):
    """Opens connections whose certificate is checked before anything is sent.

    Parameters
    ----------
    trust : Trust
        What it must be.
    """

    def __init__(self, trust: Trust) -> None:
        self._own_context = trust.context()
        super().__init__(context=self._own_context)
        self._trust = trust

    def https_open(self, req: Request) -> HTTPResponse:
        """Open a request."""
        made: Any = partial(_Connection, self._trust)
        return self.do_open(made, req, context=self._own_context)


class _Connection(HTTPSConnection):
    def __init__(self, trust: Trust, host: str, **options: Any) -> None:
        super().__init__(host, **options)
        self._trust = trust

    def connect(self) -> None:
        """Connect, and go no further with a wrong certificate."""
        super().connect()
        try:
            self._trust.check(
                self.sock.getpeercert(True) or b'', f'https://{self.host}:{self.port}'
            )
        except BridgeError:
            self.close()
            raise


def not_known(host: str, port: int, timeout_s: float, why: object) -> BridgeError:
    """Return the error of a certificate that nobody vouches for, with its fingerprint."""
    return BridgeError(
        f'nobody known vouches for the certificate of the controller: {why}',
        where=f'https://{host}:{port}', found=f'SHA-256 {_fingerprint(host, port, timeout_s)}',
        advice=f'when the controller itself shows this one, set {SETTING} to it',
    )  # fmt: skip


def _fingerprint(host: str, port: int, timeout_s: float) -> str:
    """Return what certificate is shown; nothing is sent to whoever shows it."""
    try:
        with (
            socket.create_connection((host, port), timeout_s) as plain,
            _any_certificate().wrap_socket(plain, server_hostname=host) as wire,
        ):
            return hashlib.sha256(wire.getpeercert(True) or b'').hexdigest()
    except OSError as error:
        return f'not to be had: {error}'


def _any_certificate() -> ssl.SSLContext:
    context = ssl.SSLContext(ssl.PROTOCOL_TLS_CLIENT)
    context.check_hostname, context.verify_mode = False, ssl.CERT_NONE
    return context
