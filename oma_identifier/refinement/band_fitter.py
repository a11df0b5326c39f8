"""Fits of the bands of one record, whose tails depend on each other."""

from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from oma_identifier.likelihood import (
    BandModel,
    continued,
    ConvergenceLimits,
    FIRST_PASS,
    fit_group,
    GroupFit,
    LATER_PASS,
    ModeIndex,
    ReducedBand,
    Spectra,
    StartModes,
    updated,
)


@dataclass(frozen=True, slots=True)
class BandFitter:
    """What the fits of one record share.

    Parameters
    ----------
    spectra : Spectra
        Of the record.
    usable : (n_frequencies,) bool array
        Which lines to use.
    idle : collection of ModeIndex
        Modes that shall not be refined; a group with one of them is not fitted.
    """

    spectra: Spectra
    usable: NDArray[np.bool_]
    idle: Collection[ModeIndex]

    def fit(
        self,
        now: StartModes,
        groups: Sequence[list[ModeIndex]],
        known: Sequence[GroupFit] = (),
        convergence: ConvergenceLimits = FIRST_PASS,
        begin: Callable[[ReducedBand], BandModel | None] = lambda _: None,
    ) -> list[GroupFit]:
        """Fit every group but those whose fit is known."""
        done = {tuple(each.group): each for each in known}
        return [
            done.get(tuple(group)) or self._one(now, group, convergence, begin) for group in groups
        ]

    def again(
        self, now: StartModes, fits: Sequence[GroupFit]
    ) -> tuple[StartModes, list[GroupFit]]:
        """Fit the same groups once more, from where they are."""
        groups = [each.group for each in fits]
        before = {each.group[0]: each for each in fits}
        same = {mode: mode for mode in now.indices()}
        fits = self.fit(
            now,
            groups,
            convergence=LATER_PASS,
            begin=lambda band: continued(band, before.get(band.included[0]), same),
        )
        return updated(now, fits), fits

    def _one(
        self,
        now: StartModes,
        group: list[ModeIndex],
        convergence: ConvergenceLimits,
        begin: Callable[[ReducedBand], BandModel | None],
    ) -> GroupFit:
        if any(mode in self.idle for mode in group):
            return GroupFit(group)
        return fit_group(self.spectra, now, group, self.usable, convergence, begin)
