"""Whether the modes of a short record hold still: its quarters compared.

A record of few windows has nobody to tell that a mode drifts.  Its quarters do, where they are
long enough for the mode.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
import math

import numpy as np

from modal_core.errors import IdentificationError
from modal_core.indicators import mac
from modal_core.mode import Mode, ModeSet
from modal_core.samples import Samples
from oma_identifier.record.thresholds import RECORD
from oma_identifier.record.window_means import Sightings

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
    """

    modes: ModeSet
    varies: bool


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
    parts = []
    for first in range(0, N_PARTS * length, length):
        part = samples.part(slice(first, first + length))
        try:
            parts.append(identify(part))
        except (IdentificationError, np.linalg.LinAlgError):
            continue
    checked = [_checked(mode, parts) if _is_alone(mode, modes) else mode for mode in modes]
    varies = any(one is not mode for one, mode in zip(checked, modes, strict=True))
    return Steadiness(replace(modes, modes=tuple(checked)), varies)


def _checked(mode: Mode, parts: list[ModeSet]) -> Mode:
    """Return the mode as it came where its parts agree."""
    seen = Sightings(mode)
    for part in parts:
        alike = [other for other in part if _alike(mode, other)]
        if alike:
            seen.add(min(alike, key=lambda other: _apart(mode, other)), 1.0)
    if seen.n_independent < RECORD.fewest_parts:
        return mode
    mean = seen.mean()
    return mean.widen(mode) if mean.varies else mode


def _is_alone(mode: Mode, modes: ModeSet) -> bool:
    """Tell whether no part can take another mode for this one."""
    return not any(_alike(mode, other) for other in modes if other is not mode)


def _apart(first: Mode, second: Mode) -> float:
    return abs(math.log(second.frequency_hz / first.frequency_hz))


def _alike(mode: Mode, other: Mode) -> bool:
    near = _apart(mode, other) < max(RECORD.reach, 2.0 * mode.damping_ratio)
    return near and float(mac(mode.shape, other.shape)[0, 0]) > RECORD.same_mac
