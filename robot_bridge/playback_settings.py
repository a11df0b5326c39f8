"""What of a recording is played, and how."""

from collections.abc import Mapping
from dataclasses import dataclass

from modal_core.settings.schema import check_settings, setting


@dataclass(frozen=True, slots=True)
class PlaybackSettings:
    """What of a recording is played, and how.

    Parameters
    ----------
    rate : float
        1 is as recorded; 2 twice as fast.
    start_offset_s : float [s]
        Skipped at the beginning.
    loop : bool
        Begin again at the end; the stamps jump back, as they were recorded.
    remap : mapping
        Recorded topic to the topic played on.
    """

    rate: float = setting(1.0, '1: as recorded; 10: ten times as fast', 1e-3, 1000.0)
    start_offset_s: float = setting(0.0, 'skipped at the beginning [s]', 0.0, 1e9)
    loop: bool = setting(False, 'begin again at the end')
    remap: Mapping[str, str] | None = None

    def __post_init__(self) -> None:
        """Refuse what cannot be played."""
        check_settings(self)
