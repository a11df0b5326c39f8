"""Whether the modes of a short record hold still: its quarters compared.

A record of few windows has nobody to tell that a mode drifts.  Its quarters do, where they are
long enough for the mode.  One that drifts by many half-widths is no mode of the record as one at
all, but one of its quarters.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
import math

import numpy as np

from modal_core.errors import IdentificationError
from modal_core.mode import Mode, ModeSet
from modal_core.numbers.indicators import mac
from modal_core.samples import Samples
from modal_core.work.free_memory import LARGE_BYTES
from modal_core.work.side_by_side import side_by_side
from oma_identifier.record.thresholds import RECORD
from oma_identifier.record.window_means import MeanMode, Sightings
from oma_identifier.record.with_means import without_mixtures

N_PARTS = 4


@dataclass(frozen=True, slots=True)
class Steadiness:
    """Modes of a record, those that drift with what that adds to their deviations.

    Parameters
    ----------
    modes : ModeSet
        In the order given.
    varies : bool
        Whether any of them does.
    lacking : tuple of MeanMode
        Modes that drift of which the record as one has none.
    """

    modes: ModeSet
    varies: bool
    lacking: tuple[MeanMode, ...] = ()


def steadiness(
    modes: ModeSet, samples: Samples, identify: Callable[[Samples], ModeSet]
) -> Steadiness:
    """Compare the quarters of a record.

    Parameters
    ----------
    modes : ModeSet
        Of the record.
    samples : Samples
        Its longest stretch.
    identify : callable
        Identifies a part of it.
    """
    if not len(modes):
        return Steadiness(modes, varies=False)
    length = len(samples.acceleration) // N_PARTS

    def identified(first: int) -> ModeSet | None:
        try:
            return identify(samples.part(slice(first, first + length)))
        except (IdentificationError, np.linalg.LinAlgError):
            return None

    begins = range(0, N_PARTS * length, length)
    # Of long records memory counts more.
    is_large = samples.acceleration.nbytes >= LARGE_BYTES
    found = map(identified, begins) if is_large else side_by_side(identified, begins)
    parts = [each for each in found if each is not None]
    checked = [_checked(mode, modes, parts) if _is_alone(mode, modes) else mode for mode in modes]
    varies = any(one is not mode for one, mode in zip(checked, modes, strict=True))
    lacking = _lacking(parts, modes)
    steady = replace(modes, modes=tuple(checked))
    return Steadiness(steady, varies or bool(lacking), lacking)


def _checked(mode: Mode, modes: ModeSet, parts: list[ModeSet]) -> Mode:
    """Return the mode as it came where its parts agree."""
    seen = Sightings(mode)
    for part in parts:
        alike = [other for other in part if _alike(mode, other)]
        if alike:
            seen.add(min(alike, key=lambda other: _apart(mode, other)), 1.0)
    if seen.n_independent < RECORD.fewest_parts:
        return mode
    mean = seen.mean()
    return mean.widen(mode, modes) if mean.moves(mode) else mode


def _lacking(parts: list[ModeSet], modes: ModeSet) -> tuple[MeanMode, ...]:
    """Return what drifts through the parts and is like no mode of the record."""
    tracks: list[Sightings] = []
    for part in parts:
        free = list(tracks)
        for mode in part:
            if any(_alike(known, mode) for known in modes):
                continue
            before = [track for track in free if _alike(track.last, mode)]
            if before:
                track = min(before, key=lambda each: _apart(each.last, mode))
                free.remove(track)
            else:
                track = Sightings(mode)
                tracks.append(track)
            track.add(mode, 1.0)
    long = [track.mean() for track in tracks if track.n_independent >= RECORD.fewest_parts]
    return tuple(without_mixtures([mean for mean in long if mean.varies], modes))


def _is_alone(mode: Mode, modes: ModeSet) -> bool:
    """Tell whether no part can take another mode for this one."""
    return not any(_alike(mode, other) for other in modes if other is not mode)


def _apart(first: Mode, second: Mode) -> float:
    return abs(math.log(second.frequency_hz / first.frequency_hz))


def _alike(mode: Mode, other: Mode) -> bool:
    near = _apart(mode, other) < max(RECORD.reach, 2.0 * mode.damping_ratio)
    return near and float(mac(mode.shape, other.shape)[0, 0]) > RECORD.same_mac
