"""The modes of a record as one, and those that its windows tell better, joined."""

from collections.abc import Sequence
from dataclasses import replace
import logging
import math

from modal_core.mode import Mode, ModeSet
from modal_core.numbers.indicators import mac_of_span
from oma_identifier.record.thresholds import RECORD
from oma_identifier.record.window_means import MeanMode, overlapping
from oma_identifier.selection import Identified, renumbered

NEW = -1
log = logging.getLogger(__name__)


def with_means(
    found: Identified,
    means: Sequence[MeanMode],
    above_hz: float = math.inf,
    window: Identified | None = None,
) -> Identified:
    """Return what was found in a record, with the windows' means where those say more.

    They do where the record as one was not seen, beside that of modes that only they could refine,
    and of modes whose windows disagree: the scatter between windows is added, and where several
    modes of the record are such a one at some time they give way to it.

    Parameters
    ----------
    found : Identified
        Of the record as one.
    means : sequence of MeanMode
        Of its windows.
    above_hz : float [Hz]
        Up to where the record as one was seen.
    window : Identified or None
        Of one window, with ids: its poles stand for those above.
    """
    better = [each for each in means if _is_better(each, found, above_hz)]
    joined = _once([_instead(each, found, above_hz) for each in better])
    for index, mode in enumerate(found.modes):
        if mode.frequency_hz >= above_hz:
            continue
        mean = next((each for each in better if each.is_image(mode)), None)
        if mean is None:
            joined.append((mode, index))
        else:
            log.debug(
                '%.4g Hz: the windows tell it better, at %.4g Hz',
                mode.frequency_hz,
                mean.mode.frequency_hz,
            )
    joined.sort(key=lambda each: each[0].frequency_hz)
    modes = tuple(mode for mode, _ in joined)
    poles = renumbered(found.poles, [origin for _, origin in joined])
    if window is not None:
        order = [mode.id for mode in window.modes]
        origin = [order.index(mode.id) if mode.id in order else NEW for mode in modes]
        above = renumbered(window.poles, origin)
        poles = poles.chosen(poles.frequency_hz < above_hz)
        poles = poles.joined(above.chosen(above.frequency_hz >= above_hz))
    return replace(found, modes=replace(found.modes, modes=modes), poles=poles)


def without_mixtures(means: Sequence[MeanMode], modes: ModeSet) -> list[MeanMode]:
    """Return the windows' means without those of several modes together or in turn.

    Where bells of the record's modes overlap, a window may list one of them in another's place,
    and no mode of the record is the mean of such windows.  It lies in the span of their shapes.
    Of modes that drift, or are seen in windows alone, 0 to 0.65 did; of such means 0.97 to 0.99.
    One that the record tells from its neighbours, and its windows do not, holds still.
    """
    return [mean for mean in means if not _is_mixture(mean, modes)]


def _is_mixture(mean: MeanMode, modes: ModeSet) -> bool:
    images = [mode for mode in modes if mean.is_image(mode)]
    if images:
        return mean.varies and len(images) == 1 and not mean.moves(images[0])
    near = overlapping(mean.mode, modes)
    return mac_of_span(mean.mode.shape, modes.shapes[:, near]) > RECORD.same_mac


def _is_better(mean: MeanMode, found: Identified, above_hz: float) -> bool:
    if mean.varies or mean.mode.frequency_hz >= above_hz:
        return True
    if math.isinf(above_hz):
        return False
    # Strong modes above the rate of the samples have tails below: there windows are refined.
    plain = [mode.shape_std is None for mode in found.modes if mean.is_image(mode)]
    return mean.mode.shape_std is not None and len(plain) > 0 and all(plain)


def _once(joined: Sequence[tuple[Mode, int]]) -> list[tuple[Mode, int]]:
    """Return each mode of the record once, the least sure: tracks of windows may break."""
    by_std = sorted(joined, key=lambda each: each[0].frequency_std_hz)
    kept = {(origin, mode.frequency_hz): mode for mode, origin in by_std}
    return [(mode, origin) for (origin, _), mode in kept.items()]


def _instead(mean: MeanMode, found: Identified, above_hz: float) -> tuple[Mode, int]:
    """Return what stands for a mode, and where it was among those found."""
    images = [index for index, mode in enumerate(found.modes) if mean.is_image(mode)]
    if len(images) == 1 and mean.varies and mean.mode.frequency_hz < above_hz:
        return mean.widen(found.modes.modes[images[0]], found.modes), images[0]
    return mean.mode, images[0] if images else NEW
