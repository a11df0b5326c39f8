"""Which recordings are of one point: a point may have a file for each tap."""

from collections.abc import Sequence

from impact_testing.record import ImpactRecord
from impact_testing.taps.search import taps_of

FEWEST_TAPS = 2
"""Of one tap neither coherence nor noise is known."""


def points_of(records: Sequence[ImpactRecord]) -> list[list[int]]:
    """Return the numbers of the records of each point.

    Records of one point and the same sensors are of one where any of them has too few taps to
    stand alone.  Others stay apart: that one did not hit the point it is named for shows.  So do
    those of which nobody says what was hit.
    """
    alike: dict[tuple[object, ...], list[int]] = {}
    for number, record in enumerate(records):
        own = () if record.hit else (number,)
        alike.setdefault((record.hit, record.responses.channels, *own), []).append(number)
    found = list[list[int]]()
    for each in alike.values():
        few = len(each) > 1 and any(len(taps_of(records[n])) < FEWEST_TAPS for n in each)
        found += [each] if few else [[n] for n in each]
    return sorted(found)
