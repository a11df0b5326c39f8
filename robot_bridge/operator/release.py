"""Whose the arm is: the token of a release, and the heartbeat of who was given it."""

import math
import secrets

TOKEN_BYTES = 16


class Release:
    """One release after the other; only the last one counts, until it ends.

    The token is random for every release of every bridge: where names clash, requests and beats
    reach two bridges, and at most the one that gave the token takes them for its own.  It guards
    against mistakes, not against malice: whoever listens on the topic of the beats can read it.

    Attributes
    ----------
    n_foreign : int
        Beats with another token than that of the release in force.
    foreign_s : float [s]
        When the last one came.
    """

    def __init__(self) -> None:
        self.n_foreign, self.foreign_s = 0, -math.inf
        self._token = ''
        self._until_s = self._beat_s = -math.inf
        self._number: int | None = None

    def grant(self, until_s: float) -> str:
        """Release until a time [s] and return the token; nobody has been heard holding yet."""
        self._token, self._until_s = secrets.token_hex(TOKEN_BYTES), until_s
        self._beat_s, self._number = -math.inf, None
        return self._token

    def end(self) -> None:
        """Take nobody's word any more."""
        self._token, self._beat_s = '', -math.inf

    def is_of(self, token: str) -> bool:
        """Tell whether this is the token of the release in force."""
        return bool(self._token) and token == self._token

    def over(self, now_s: float) -> bool:
        """Tell whether its time has run out."""
        return now_s > self._until_s

    def silent(self, now_s: float, timeout_s: float) -> bool:
        """Tell whether its holder has not been heard for so long; never for a time of 0."""
        return timeout_s > 0.0 and now_s - self._beat_s > timeout_s

    def beat(self, token: str, number: int | None, now_s: float, timeout_s: float) -> bool:
        """Take a beat; return False when two hold with this one token.

        ``number`` counts the beats of one sender.  One that runs back while beats are fresh is of
        a second sender: of two that hold, one who lets go would not be noticed.
        """
        if not self._token:
            return True
        if not self.is_of(token):
            self.n_foreign, self.foreign_s = self.n_foreign + 1, now_s
            return True
        last, self._number = self._number, number
        back = number is not None and last is not None and number < last
        if back and not self.silent(now_s, timeout_s):
            self._beat_s = -math.inf
            return False
        self._beat_s = now_s
        return True
