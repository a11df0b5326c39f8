"""Who may look: hosts, origins and the token."""

from collections.abc import Mapping
from dataclasses import dataclass
import hmac
import ipaddress
import socket
from urllib.parse import SplitResult, urlsplit

SHORTEST_TOKEN = 16
LOCAL = 'localhost'


@dataclass(frozen=True, slots=True)
class Access:
    """What a request must show.

    Parameters
    ----------
    token : str
        To be shown by everyone; empty: by nobody (loopback only).
    names : tuple of str
        Host names under which the page may be asked for, beside this machine's own.
    """

    token: str = ''
    names: tuple[str, ...] = ()

    def refusal(self, headers: Mapping[str, str]) -> str:
        """Return why a request is refused whatever it asks for; empty where it is not.

        A page of somebody else can have its own host name resolve to this machine (DNS
        rebinding): its requests then bear that name.  An address bears none, so it is let in.
        """
        host = headers.get('Host', '')
        if not self._is_ours(_split(f'http://{host}').hostname or ''):
            return 'this host name is not served'
        origin = headers.get('Origin')
        if origin is not None and _split(origin).netloc.lower() != host.lower():
            return 'a page of another origin asks'
        if headers.get('Sec-Fetch-Site', 'none') not in ('none', 'same-origin'):
            return 'a page of another origin asks'
        return ''

    def is_known(self, token: str) -> bool:
        """Return whether a token is the right one; any is where none is needed."""
        return not self.token or hmac.compare_digest(_bytes(token), _bytes(self.token))

    def _is_ours(self, name: str) -> bool:
        try:
            ipaddress.ip_address(name)
        except ValueError:
            known = (LOCAL, socket.gethostname(), *self.names)
            return bool(name) and name in {each.lower() for each in known}
        return True


def is_loopback(address: str) -> bool:
    """Return whether only this machine reaches an address."""
    try:
        return ipaddress.ip_address(address).is_loopback
    except ValueError:
        return address == LOCAL


def host_of(address: str) -> str:
    """Return the host of a page's address, of the interface it is served on."""
    try:
        found = ipaddress.ip_address(address)
    except ValueError:
        return address
    if found.is_unspecified:
        return socket.gethostname()
    return f'[{found}]' if found.version == 6 else str(found)


def _split(url: str) -> SplitResult:
    """Return the parts of an address; all empty where it is none."""
    try:
        return urlsplit(url)
    except ValueError:
        return urlsplit('')


def _bytes(token: str) -> bytes:
    # A header may hold any bytes.
    return token.encode('utf-8', 'surrogateescape')
