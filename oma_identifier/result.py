"""What an identification returns."""

from dataclasses import dataclass, replace

from modal_core.mode import ModeSet
from modal_core.poles import PoleTable
from modal_core.quality import DataQuality
from modal_core.window import Pose
from oma_identifier.selection import Identified
from oma_identifier.spectra import SingularValueSpectrum

KNOWN_MOTION = 'known_motion'
"""Flag of a result with modes in whose estimate known inputs took part."""
NO_MODE = 'no mode stands out from the noise'
ONLY_LINES = 'only harmonics: no mode stands out beside them'


@dataclass(frozen=True, slots=True)
class WindowResult:
    """Everything identified from one window, or from a whole recording.

    Parameters
    ----------
    index : int
        Window counter; -1 for a whole recording.
    start_ns, end_ns : int [ns]
        First sample, and just after the last.
    modes : ModeSet
        Modes of the structure, by frequency; empty when the window cannot be identified.
    harmonics : ModeSet
        Lines of machines and drives that were found and kept out of ``modes``; each is marked
        ``harmonic``.
    poles : PoleTable
        All poles with the reason each was kept or rejected; ``mode_id`` as in ``modes``.
    spectrum : SingularValueSpectrum
        Behind the stabilisation diagram.
    quality : DataQuality
        Health of the data, and why there is no mode when there is none.
    pose : Pose or None
        Where the robot was.
    n_conditions : int
        Loading conditions that were told apart, by a method that compares them; else 0.
    """

    index: int
    start_ns: int
    end_ns: int
    modes: ModeSet
    harmonics: ModeSet
    poles: PoleTable
    spectrum: SingularValueSpectrum
    quality: DataQuality
    pose: Pose | None = None
    n_conditions: int = 0


def result_of(
    found: Identified,
    spectrum: SingularValueSpectrum,
    quality: DataQuality,
    span_ns: tuple[int, int],
    index: int = -1,
    pose: Pose | None = None,
) -> WindowResult:
    """Return what was found in a window, or in a whole recording, with what is in doubt of it."""
    return WindowResult(
        index=index,
        start_ns=span_ns[0],
        end_ns=span_ns[1],
        modes=found.modes,
        harmonics=found.harmonics,
        poles=found.poles,
        spectrum=spectrum,
        quality=_explained(quality, found),
        pose=pose,
        n_conditions=found.n_conditions,
    )


def _explained(quality: DataQuality, found: Identified) -> DataQuality:
    """Return the quality with what is in doubt, and why there is no mode when there is none."""
    if found.doubtful_hz:
        quality = replace(quality, flags=(*quality.flags, 'line_or_mode'))
    if any(mode.known_motion for mode in found.modes):
        quality = replace(quality, flags=tuple(dict.fromkeys((*quality.flags, KNOWN_MOTION))))
    if len(found.modes) or not quality.identifiable:
        return quality
    reason = ONLY_LINES if len(found.harmonics) else NO_MODE
    return replace(quality, identifiable=False, reason=reason)
