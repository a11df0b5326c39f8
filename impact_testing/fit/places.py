"""Where the FRFs of each point belong in the shapes."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from impact_testing.responses import PointData


@dataclass(frozen=True, slots=True)
class Places:
    """Places of shapes: the channels of all recordings, then points hit that have none.

    Parameters
    ----------
    names : tuple of str
    n_channels : int
    into : tuple of int
        Place of each point hit.
    out : tuple of int arrays
        Places of its channels.
    loose : tuple of int
        Points that did not hit the place of the channel they are named for.
    """

    names: tuple[str, ...]
    n_channels: int
    into: tuple[int, ...]
    out: tuple[NDArray[np.int64], ...]
    loose: tuple[int, ...] = ()

    @classmethod
    def of(cls, data: Sequence[PointData], loose: Sequence[int] = ()) -> 'Places':
        """Find them."""
        spectra = [each.frf.spectra for each in data]
        channels = tuple(dict.fromkeys(name for each in spectra for name in each.names))
        known = ['' if n in loose else each.record.point for n, each in enumerate(spectra)]
        hits = _named(known, [each.record.name for each in spectra])
        further = tuple(hit for hit in dict.fromkeys(hits) if hit not in channels)
        number = {name: place for place, name in enumerate((*channels, *further))}
        return cls(
            names=tuple(number),
            n_channels=len(channels),
            into=tuple(number[hit] for hit in hits),
            loose=tuple(loose),
            out=tuple(np.array([number[name] for name in each.names]) for each in spectra),
        )

    @property
    def n(self) -> int:
        """How many."""
        return len(self.names)

    @property
    def tied(self) -> bool:
        """Whether a driving point gives channels and points hit one scale."""
        return any(place < self.n_channels for place in self.into)

    @property
    def shown(self) -> slice:
        """Places that have one scale: all where a driving point ties them."""
        if self.tied:
            return slice(0, self.n)
        n_points = self.n - self.n_channels
        return (
            slice(0, self.n_channels)
            if self.n_channels >= n_points
            else slice(self.n_channels, None)
        )

    @property
    def apart(self) -> list[int]:
        """Places no two of which one FRF has: those not hit, or those that are no channels."""
        hit = set(self.into)
        if len(hit) <= self.n_channels:
            return [place for place in range(self.n) if place not in hit]
        return list(range(self.n_channels, self.n))


def _named(points: Sequence[str], records: Sequence[str]) -> list[str]:
    """Return the places of hits; a point that nobody names is one of its own.

    So are two of recordings that are called alike.
    """
    found: list[str] = []
    for point, record in zip(points, records, strict=True):
        own = f'hit of {record}'
        while own in found:
            own += "'"
        found.append(point or own)
    return found
