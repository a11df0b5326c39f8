"""What an identification returns."""

from dataclasses import dataclass

from modal_core.mode import ModeSet
from modal_core.poles import PoleTable
from modal_core.quality import DataQuality
from modal_core.window import Pose
from oma_identifier.spectra import SingularValueSpectrum


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
