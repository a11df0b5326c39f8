"""What a report says."""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from autonomous_modal_analysis.identified.results import Identification
from autonomous_modal_analysis.report.truth import TrueMode
from modal_core.poles import PoleTable
from modal_reports import ChannelSpectra, Geometry, Spectrogram, Spectrum


@dataclass(frozen=True, slots=True)
class ReportContent:
    """Everything one report shows.

    Parameters
    ----------
    title : str
        For example the robot and the occasion.
    recording : str
        Name of the recording the results come from.
    identification : Identification
        Modes of the whole recording and of its windows, channels, health, settings.
    poles : PoleTable or None
        Behind the modes of the whole recording.
    spectrum : Spectrum or None
        Behind the stabilisation diagram.
    truth : tuple of TrueMode or None
        None when the true modes are not known.
    geometry : Geometry or None
        The arm at rest; without it shapes are drawn channel by channel.
    displacements : tuple of (n_points, 3) complex array
        One per mode of the whole recording, in their order.
    spectra : ChannelSpectra or None
        Of the channels.
    spectrogram : Spectrogram or None
        Over time and joint speed, of the same windows.
    provenance : mapping of str to str
        Who made this from what: software, versions, files, checksums, time.
    """

    title: str
    recording: str
    identification: Identification
    poles: PoleTable | None = None
    spectrum: Spectrum | None = None
    truth: tuple[TrueMode, ...] | None = None
    geometry: Geometry | None = None
    displacements: tuple[NDArray[np.complex128], ...] = ()
    spectra: ChannelSpectra | None = None
    spectrogram: Spectrogram | None = None
    provenance: Mapping[str, str] = field(default_factory=dict)
