"""What is kept of a window, and what stays the same over the windows of a run."""

from dataclasses import dataclass, field
from hashlib import sha256
import json
import math

from modal_core.mode import ModeSet
from modal_core.quality import DataQuality
from modal_core.window import Pose, ResultOfWindow


@dataclass(frozen=True, slots=True)
class Circumstances:
    """What holds for many windows; texts that are not known are empty.

    Parameters
    ----------
    robot, tool : str
        Which robot, and what it carries.
    software : str
        That identified the modes.
    settings : str
        Of the identification, as text.
    recording, recording_hash : str
        Name and SHA-256 of the recording; empty for a live robot.
    """

    robot: str = ''
    tool: str = ''
    software: str = ''
    settings: str = ''
    recording: str = ''
    recording_hash: str = ''

    @property
    def settings_hash(self) -> str:
        """SHA-256 of the settings, hexadecimal; empty where they are not known."""
        return sha256(self.settings.encode()).hexdigest() if self.settings else ''

    @property
    def key(self) -> str:
        """SHA-256 of all of it."""
        parts = [self.robot, self.tool, self.software, self.settings_hash]
        return sha256(
            json.dumps([*parts, self.recording, self.recording_hash]).encode()
        ).hexdigest()


@dataclass(frozen=True, slots=True)
class KeptWindow:
    """One window's result.

    Parameters
    ----------
    index : int
        Counts windows from 0; -1 for a whole recording.
    start_ns, end_ns : int [ns]
        Time of the first sample and just after the last.
    modes : ModeSet
        Of the structure, then lines of machines and drives, marked ``harmonic``.
    quality : DataQuality
        Health of the data; of the channels only those with flags are kept.
    pose : Pose or None
        Where the robot was.
    temperature_c, load_kg : float [°C], [kg]
        NaN where not known.
    """

    index: int
    start_ns: int
    end_ns: int
    modes: ModeSet
    quality: DataQuality = field(default_factory=DataQuality)
    pose: Pose | None = None
    temperature_c: float = math.nan
    load_kg: float = math.nan

    @property
    def is_whole(self) -> bool:
        """Whether it is a whole recording, which its windows tell of once more."""
        return self.index < 0

    @classmethod
    def of(
        cls, result: ResultOfWindow, temperature_c: float = math.nan, load_kg: float = math.nan
    ) -> 'KeptWindow':
        """Return what is kept of a result."""
        found = result.modes
        modes = ModeSet((*found, *result.harmonics), found.channel_names, found.method)
        return cls(
            index=result.index,
            start_ns=result.start_ns,
            end_ns=result.end_ns,
            modes=modes,
            quality=result.quality,
            pose=result.pose,
            temperature_c=temperature_c,
            load_kg=load_kg,
        )
