"""Experimental modal analysis from taps of an instrumented hammer."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from autonomous_modal_analysis.api.found_modes import FoundModes, Placed
from autonomous_modal_analysis.api.result import Columns
from impact_testing import impact_modes, ImpactRecord, ImpactResult, ImpactSettings, read_impact
from modal_core.errors import SettingsError
from modal_core.mode import ModeSet
from modal_reports import Quantity

MASS = Quantity('modal mass', 'kg')


@dataclass(frozen=True, eq=False, repr=False)
class TapTest(FoundModes):
    """Modes from taps, with their masses.

    Parameters
    ----------
    found : ImpactResult
        Modes, judged taps, FRFs and checks.
    name : str
        Names of the recordings.
    """

    found: ImpactResult
    name: str

    @property
    def modes(self) -> ModeSet:
        """The modes, shapes over channels and points hit."""
        return self.found.modes

    @property
    def harmonics(self) -> ModeSet:
        """None: what a tap does not cause is noise."""
        return ModeSet((), self.found.places, 'impact')

    @property
    def modal_masses_kg(self) -> NDArray[np.float64]:
        """Modal masses of the shapes, (n_modes,) [kg]; NaN without a driving point."""
        return np.array([each.modal_mass_kg for each in self.found.scaled_modes])

    @property
    def modal_masses_std_kg(self) -> NDArray[np.float64]:
        """Standard deviations of the modal masses, (n_modes,) [kg]."""
        return np.array([each.modal_mass_std_kg for each in self.found.scaled_modes])

    @property
    def remarks(self) -> tuple[str, ...]:
        """What should be known, each with its remedy."""
        return self.found.remarks

    def headline(self) -> str:
        """Say what was found."""
        good = sum(point.n_good for point in self.found.points)
        low, high = self.found.band_hz
        return (
            f'{len(self.modes)} modes between {low:.4g} and {high:.4g} Hz from {good} taps'
            f' on {len(self.found.points)} points'
        )

    def columns(self) -> Columns:
        """Return the modes by column, their masses among them."""
        own = super().columns()
        masses: Columns = {
            'modal_mass_kg': self.modal_masses_kg.tolist(),
            'modal_mass_std_kg': self.modal_masses_std_kg.tolist(),
        }
        return {**own, **masses}

    def shown(self) -> Columns:
        """Return the modes as texts."""
        masses = [
            MASS.number(each.modal_mass_kg, each.modal_mass_std_kg)
            for each in self.found.scaled_modes
        ]
        return {**super().shown(), MASS.label: masses}

    def to_dict(self) -> dict[str, Any]:
        """Return what ``ama impact --json`` prints."""
        from autonomous_modal_analysis.tap_report import tap_test_json

        return tap_test_json(self.found)

    def save(self, folder: str | Path) -> None:
        """Write modes.json, modes.csv, frf.uff and report.html into a folder, made when missing.

        Raises
        ------
        OSError
            It cannot be written to.
        """
        from autonomous_modal_analysis.tap_report import save_tap_test

        save_tap_test(Path(folder), self.found, self.name)

    def _placed(self) -> Placed | None:
        return None


def impact(
    recordings: str | Path | ImpactRecord | Sequence[str | Path | ImpactRecord],
    *,
    at: str | Sequence[str] | None = None,
    force: str | None = None,
    sample_rate_hz: float | None = None,
    unit: str | None = None,
    channels: Sequence[str] | None = None,
    **settings: Any,
) -> TapTest:
    """Identify the modes of a structure from taps of an instrumented hammer.

    Parameters
    ----------
    recordings : path, ImpactRecord or sequence of these
        One per point hit (roving hammer) or place of the sensors (roving accelerometers); those
        of one point and the same sensors are joined, so each tap may have a file.
    at : str, sequence of str or None
        Channel at the point hit, one per recording or one for all; ``-elbow.x`` where the hammer
        struck against it.  None: what the force's name says behind an @.
    force : str or None
        Name of the force's column; None: the one in newtons.
    sample_rate_hz, unit, channels
        Of files that do not say it themselves, as for :func:`autonomous_modal_analysis.open`.
    **settings
        Fields of :class:`impact_testing.ImpactSettings`: ``min_frequency_hz``,
        ``max_frequency_hz``, ``segment_s``, ``window_end``.

    Returns
    -------
    TapTest

    Raises
    ------
    ModalAnalysisError
        No force channel, too few good taps, or no mode: one line that says what is needed.

    Examples
    --------
    A mass of 2 kg on a spring, tapped four times:

    >>> import numpy as np
    >>> import autonomous_modal_analysis as ama
    >>> from impact_testing import ImpactRecord
    >>> from modal_core.channel import Channel
    >>> from modal_core.samples import Samples
    >>> rate, pole = 256.0, 2 * np.pi * 8 * (-0.02 + 0.9998j)
    >>> force = np.zeros(4096)
    >>> force[[100, 1100, 2100, 3100]] = 200.0
    >>> time = np.arange(4096) / rate
    >>> answer = np.real(pole**2 * np.exp(pole * time) / (2j * pole.imag)) * 2 / 2.0 / rate
    >>> motion = np.convolve(force, answer)[:4096]
    >>> motion += 1e-4 * np.random.default_rng(1).normal(size=4096)
    >>> record = ImpactRecord(force, Samples(motion[:, None], rate, (Channel('m.x'),)), 'm.x')
    >>> ama.impact(record).frequencies_hz.round(2)
    array([8.])
    """
    given = [recordings] if isinstance(recordings, str | Path | ImpactRecord) else list(recordings)
    hits = _hits(at, len(given))
    records = [
        each
        if isinstance(each, ImpactRecord)
        else read_impact(each, hit, force, sample_rate_hz, unit, channels)
        for each, hit in zip(given, hits, strict=True)
    ]
    try:
        asked = ImpactSettings(**settings)
    except TypeError as error:
        raise SettingsError('unknown setting', where='impact', found=str(error)) from error
    return TapTest(impact_modes(records, asked), ', '.join(record.name for record in records))


def _hits(at: str | Sequence[str] | None, n_recordings: int) -> list[str | None]:
    if at is None or isinstance(at, str):
        return [at] * n_recordings
    if len(at) != n_recordings:
        raise SettingsError(
            'points hit and recordings differ in number',
            where='at',
            found=len(at),
            expected=f'one for all, or {n_recordings}',
        )
    return list(at)
