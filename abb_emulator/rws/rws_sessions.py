"""Who is connected, and who holds the mastership.

References
----------
ABB Robot Web Services: 70 sessions, dropped after five minutes without a request.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
import secrets
import time

from abb_emulator.rws.rws_refusal import FORBIDDEN, HELD, RwsRefusalError, UNAVAILABLE

MOST_SESSIONS, LONGEST_IDLE_S = 70, 300.0
COOKIE, SECOND_COOKIE = '-http-session-', 'ABBCX'


@dataclass(slots=True)
class Session:
    """One client.

    Parameters
    ----------
    number : int
        Its ABBCX cookie.
    key : str
        Its session cookie.
    seen_s : float [s]
        Of its last request.
    """

    number: int
    key: str
    seen_s: float
    domains: set[str] = field(default_factory=set)


class Sessions:
    """Every client there is.

    Parameters
    ----------
    clock : callable
        Time [s].
    """

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self._clock = clock
        self._sessions: dict[str, Session] = {}
        self._n_made = 0

    def find(self, key: str) -> Session | None:
        """Return the session of a cookie; None when there is none or it has expired."""
        self._expire()
        session = self._sessions.get(key)
        if session is not None:
            session.seen_s = self._clock()
        return session

    def numbered(self, number: str) -> Session | None:
        """Return the session of a second cookie, which is no secret."""
        self._expire()
        return next((one for one in self._sessions.values() if str(one.number) == number), None)

    def make(self) -> Session:
        """Return a new session.

        Raises
        ------
        RwsRefusalError
            There are too many: a client that keeps no cookie makes one with each request.
        """
        self._expire()
        if len(self._sessions) >= MOST_SESSIONS:
            raise RwsRefusalError('too many sessions', UNAVAILABLE)
        self._n_made += 1
        session = Session(self._n_made, secrets.token_hex(16), self._clock())
        self._sessions[session.key] = session
        return session

    def end(self, session: Session) -> None:
        """Log a client out; its mastership goes with it."""
        self._sessions.pop(session.key, None)

    # -- mastership ----------------------------------------------------------------------------

    def holder(self, domain: str) -> Session | None:
        """Return who holds the mastership of a domain."""
        self._expire()
        return next(self._holders(domain), None)

    def take(self, session: Session, domain: str) -> None:
        """Give a client the mastership of a domain.

        Raises
        ------
        RwsRefusalError
            Another one holds it.
        """
        self.check(session, domain)
        session.domains.add(domain)

    def check(self, session: Session, domain: str) -> None:
        """Refuse what needs a mastership that another client holds."""
        holder = self.holder(domain)
        if holder is not None and holder is not session:
            raise RwsRefusalError('Requested resource is held by someone else', FORBIDDEN, HELD)

    def _holders(self, domain: str) -> Iterator[Session]:
        return (item for item in self._sessions.values() if domain in item.domains)

    def _expire(self) -> None:
        oldest_s = self._clock() - LONGEST_IDLE_S
        for key in [key for key, one in self._sessions.items() if one.seen_s < oldest_s]:
            del self._sessions[key]
