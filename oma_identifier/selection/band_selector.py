"""Bands whose covariances did not change are not solved again."""

from collections.abc import Sequence
from dataclasses import replace
from weakref import WeakKeyDictionary

from oma_identifier.selection.mixtures import told_apart
from oma_identifier.selection.selection import BandSelection, select_in_band
from oma_identifier.selection.ssi_poles import identify_band, identify_canonical
from oma_identifier.settings import IdentificationSettings
from oma_identifier.spectra import SpectralPeaks
from oma_identifier.subspace import BandCovariance


class BandSelector:
    """Selects the modes of bands, and knows what it selected as long as the covariances live."""

    def __init__(self) -> None:
        self._selected: WeakKeyDictionary[
            BandCovariance, dict[IdentificationSettings, Sequence[BandSelection]]
        ] = WeakKeyDictionary()

    def select(
        self,
        source: BandCovariance,
        settings: IdentificationSettings,
        peaks: SpectralPeaks | None = None,
    ) -> Sequence[BandSelection]:
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
        sequence of BandSelection
            Empty where the record is too short for any pole; two where canonical variates tell
            apart what is one pole without.
        """
        known = self._selected.setdefault(source, {})
        if settings not in known:
            known[settings] = self._select(source, settings, peaks)
        return known[settings]

    def _select(
        self,
        source: BandCovariance,
        settings: IdentificationSettings,
        peaks: SpectralPeaks | None,
    ) -> Sequence[BandSelection]:
        band = identify_band(source, settings)
        if band is None:
            return ()
        plain = select_in_band(band, settings, peaks)
        again = identify_canonical(band) if plain.selected else None
        if again is None:
            return (plain,)
        canonical = select_in_band(again, settings, peaks)
        stay, instead = told_apart(plain.selected, canonical.selected)
        if not instead:
            return (plain,)
        return (
            replace(plain, selected=tuple(stay)),
            replace(canonical, selected=tuple(instead), unsure=()),
        )
