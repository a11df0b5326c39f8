"""Identify an array."""

from collections.abc import Sequence
from typing import Any, Unpack

from autonomous_modal_analysis.api.modal_result import ModalResult
from autonomous_modal_analysis.api.recording import Recording
from autonomous_modal_analysis.api.robot import Layout
from autonomous_modal_analysis.api.settings import Settings
from autonomous_modal_analysis.console.terminal import no_progress, ProgressCallback
from modal_recordings import array_recording


def identify(
    array: Any,
    sample_rate_hz: float | None = None,
    *,
    channel_names: Sequence[str] | None = None,
    unit: str | None = None,
    layout: Layout | None = None,
    progress: ProgressCallback = no_progress,
    **settings: Unpack[Settings],
) -> ModalResult:
    """Identify natural frequencies, damping ratios and mode shapes from accelerations.

    No setting is needed: band, model orders, references and the choice of modes follow from the
    data.  The same array in a file gives the same modes by ``ama identify``.

    Parameters
    ----------
    array : (n_samples, n_channels) or (n_samples,) array_like [m/s²]
        Responses to ambient or random excitation; a pandas DataFrame names its channels.  NaN is
        a sample lost: a few are filled in, a channel with many is left out.
    sample_rate_hz : float [Hz] or None
        Rate of the rows; None: from a column that is named a time.
    channel_names : sequence of str or None
        One per column, with or without its unit, such as ``'deck [g]'``; ``'-'`` leaves a column
        out.  None: from the columns of a DataFrame, else ``ch1``, ``ch2``, ...
    unit : str or None
        Of the values: m/s^2, g, mm/s, um, um/m, ...; None: m/s², unless the names say.
    layout : SensorLayout, mapping, path or None
        Places and directions of the channels, for drawing the shapes.
    progress : callable
        Told the fraction done, 0..1.
    **settings
        Fields of :class:`oma_identifier.settings.IdentificationSettings`: ``method`` (ssi_cov,
        ssi_data, plscf, var, rvar, notch, vmd, psdtm, csi, force, efdd or fdd), ``window_s`` [s],
        ``hop_s`` [s], ``min_frequency_hz``, ``max_frequency_hz`` [Hz], ...

    Returns
    -------
    ModalResult
        Modes with standard deviations, of the whole array and of its windows.

    Raises
    ------
    ModalAnalysisError
        In one line: the array has no rate, the wrong orientation, a column that counts up as
        times do; a setting is unknown or out of range; or the data cannot be identified.

    Examples
    --------
    Two modes of a frame with two floors, 8 and 21 Hz, 1 % damped, shaken by noise for five
    minutes:

    >>> import numpy as np
    >>> from scipy.signal import lfilter
    >>> import autonomous_modal_analysis as ama
    >>> rng = np.random.default_rng(1)
    >>> poles = np.exp(2 * np.pi * np.array([8, 21]) * (-0.01 + 1j) / 100)
    >>> forces = rng.normal(size=(2, 30_000))
    >>> modal = [lfilter([1], [1, -2 * p.real, abs(p) ** 2], f) for p, f in zip(poles, forces)]
    >>> floors = np.transpose(modal) @ [[0.6, 1.0], [1.0, -0.6]]
    >>> result = ama.identify(floors, 100, channel_names=['lower', 'upper'])
    >>> result.frequencies_hz.round(1)
    array([ 8., 21.])
    >>> bool(np.all(np.abs(result.damping_ratios - 0.01) < 4 * result.damping_ratios_std))
    True

    What is wrong with an array is said in one line:

    >>> ama.identify(floors.T, 100)
    Traceback (most recent call last):
    modal_core.errors.RecordingError: array: more channels than samples (found shape (2, 30000), \
expected samples along the first axis); transpose it
    """
    recording = Recording(array_recording(array, sample_rate_hz, channel_names, unit), 'array')
    return recording.identify(layout=layout, progress=progress, **settings)
