"""What a person released of a series: its motions, one controller, for a while; no ROS."""

from dataclasses import dataclass

from autonomous_modal_analysis.mapping.series import Series
from modal_core.errors import BridgeError

PARTS, ROOM_S = 2.0, 600.0
"""How long a release lasts: twice the time of the series, for a person lets go and rests, and ten
minutes more; after that every motion asks for its own hash."""


@dataclass(frozen=True, slots=True)
class SeriesRelease:
    """One release of a whole series.

    Parameters
    ----------
    hashes : frozenset of str
        Of its motions, ways included.
    controller : str
        The one it is for.
    until_s : float [s]
        When it ends, monotonic clock.
    """

    hashes: frozenset[str]
    controller: str
    until_s: float

    @classmethod
    def of(cls, series: Series, controller: str, now_s: float) -> 'SeriesRelease':
        """Return the release of a series that begins now [s]."""
        hashes = [each for stop in series.stops for each in (stop.way_hash, stop.plan_hash)]
        until_s = now_s + PARTS * series.seconds + ROOM_S
        return cls(frozenset(each for each in hashes if each), controller, until_s)

    def chosen(self, plan_hash: str, controller: str, now_s: float) -> str:
        """Return the hash of a motion that is released; empty: it asks for a release of its own.

        Raises
        ------
        BridgeError
            Another controller than the one the series was released for.
        """
        self.check_controller(controller)
        return plan_hash if plan_hash in self.hashes and now_s <= self.until_s else ''

    def check_controller(self, controller: str) -> None:
        """Refuse another controller than the one the series was released for.

        Raises
        ------
        BridgeError
            It is another.
        """
        if controller != self.controller:
            raise BridgeError(
                'the series was released for another controller', found=controller,
                expected=self.controller, advice='release it anew',
            )  # fmt: skip
