"""HTTP authentication as controllers ask for it: digest in version 1.0, basic in version 2.0.

References
----------
RFC 2617, sections 2, 3.2.1 and 3.2.2 (MD5, qop auth).
"""

from base64 import b64decode
import binascii
from collections import OrderedDict
from hashlib import md5
import re
import secrets
from secrets import compare_digest
from typing import Protocol
from urllib.parse import urlsplit

REALM = 'validuser@robapi.abb'
MOST_NONCES = 256
LONGEST_HEADER = 2048
_FIELD = re.compile(r'(\w+)\s*=\s*(?:"([^"]*)"|([^\s,]+))')


class Login(Protocol):
    """A way to ask who is there."""

    def challenge(self) -> str:
        """Return a fresh WWW-Authenticate header."""

    def accepts(self, header: str, method: str, uri: str) -> bool:
        """Tell whether an Authorization header is right for this request."""


class Basic:
    """Takes the password as it is: for encrypted connections only.

    Parameters
    ----------
    user, password : str
        The one account.
    """

    def __init__(self, user: str, password: str) -> None:
        self._right = f'{user}:{password}'.encode()

    def challenge(self) -> str:
        """Return the WWW-Authenticate header."""
        return f'Basic realm="{REALM}"'

    def accepts(self, header: str, method: str, uri: str) -> bool:
        """Tell whether an Authorization header is right."""
        kind, _, word = header.partition(' ')
        if len(header) > LONGEST_HEADER or kind.lower() != 'basic':
            return False
        try:
            return compare_digest(b64decode(word, validate=True), self._right)
        except binascii.Error:
            return False


class Digest:
    """Challenges, and checks what comes back; a nonce count may be used once.

    Parameters
    ----------
    user, password : str
        The one account.
    """

    def __init__(self, user: str, password: str) -> None:
        self._user, self._password = user, password
        self._nonces: OrderedDict[str, int] = OrderedDict()

    def challenge(self) -> str:
        """Return a fresh WWW-Authenticate header."""
        nonce = secrets.token_hex(16)
        self._nonces[nonce] = 0
        while len(self._nonces) > MOST_NONCES:
            self._nonces.popitem(last=False)
        return f'Digest realm="{REALM}", domain="/", qop="auth", nonce="{nonce}", algorithm=MD5'

    def accepts(self, header: str, method: str, uri: str) -> bool:
        """Tell whether an Authorization header is right for this request."""
        if len(header) > LONGEST_HEADER or not header.lower().startswith('digest '):
            return False
        fields = {name.lower(): quoted or plain for name, quoted, plain in _FIELD.findall(header)}
        nonce, count = fields.get('nonce', ''), fields.get('nc', '')
        # Clients of a websocket may sign its whole address.
        signed = fields.get('uri', '')
        if nonce not in self._nonces or uri not in (signed, urlsplit(signed).path):
            return False
        if fields.get('username') != self._user or fields.get('realm') != REALM:
            return False
        secret = _hash(f'{self._user}:{REALM}:{self._password}')
        request = _hash(f'{method}:{signed}')
        if fields.get('qop') != 'auth' or not re.fullmatch('[0-9a-fA-F]{8}', count):
            return False
        text = f'{secret}:{nonce}:{count}:{fields.get("cnonce", "")}:auth:{request}'
        if not compare_digest(_hash(text), fields.get('response', '').lower()):
            return False
        if int(count, 16) <= self._nonces[nonce]:
            return False
        self._nonces[nonce] = int(count, 16)
        return True


def _hash(text: str) -> str:
    return md5(text.encode(), usedforsecurity=False).hexdigest()
