"""Bands whose covariances did not change are not solved again."""

from weakref import WeakKeyDictionary

from oma_identifier.selection.selection import BandSelection, select_in_band
from oma_identifier.selection.ssi_poles import identify_band
from oma_identifier.settings import IdentificationSettings
from oma_identifier.spectra import SpectralPeaks
from oma_identifier.subspace import BandCovariance


class BandSelector:
    """Selects the modes of bands, and knows what it selected as long as the covariances live."""

    def __init__(self) -> None:
        self._selected: WeakKeyDictionary[
            BandCovariance, dict[IdentificationSettings, BandSelection | None]
        ] = WeakKeyDictionary()

    def select(
        self,
        source: BandCovariance,
        settings: IdentificationSettings,
        peaks: SpectralPeaks | None = None,
    ) -> BandSelection | None:
        """Identify the poles of one band and select its modes.

        Parameters
        ----------
        source : BandCovariance
            Of the band.
        settings : IdentificationSettings
            Orders and limits.
        peaks : SpectralPeaks or None
            Of the samples behind the covariances, where they are at hand.

        Returns
        -------
        BandSelection or None
            None where the record is too short for any pole.
        """
        known = self._selected.setdefault(source, {})
        if settings not in known:
            band = identify_band(source, settings)
            known[settings] = None if band is None else select_in_band(band, settings, peaks)
        return known[settings]
