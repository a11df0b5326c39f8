"""What a refinement knows from stage to stage."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field
from typing import NewType

import numpy as np
from numpy.typing import NDArray

from modal_core.mode import Mode, ModeSet
from modal_core.samples import Samples
from modal_core.work.free_memory import give_back, LARGE_BYTES
from oma_identifier.likelihood import (
    GroupFit,
    inputs_of,
    ModeIndex,
    moving_channels,
    Spectra,
    spectra_of,
    StartModes,
    unit,
    usable_lines,
)
from oma_identifier.refinement.acceptance import Outcome
from oma_identifier.refinement.band_fitter import BandFitter
from oma_identifier.refinement.narrow_force import NarrowForce
from oma_identifier.refinement.warm_start import StartingValues, WarmStart

GivenIndex = NewType('GivenIndex', int)
"""Position among the modes that were given."""


@dataclass(frozen=True, slots=True)
class Record:
    """What a refinement starts from, the same for all stages.

    Parameters
    ----------
    modes : ModeSet
        As given.
    channels : (n_alive,) int array
        That are not dead.
    spectra : Spectra
        Of these channels.
    usable : (n_frequencies,) bool array
        Which lines of the spectra to use.
    resting : frozenset of GivenIndex
        Modes that shall not be refined.
    warm_start : WarmStart or None
        What another stretch of the same structure told.
    inputs : (n_inputs, n_frequencies) complex array or None
        Transforms of known inputs at the frequencies of the spectra.
    candidates : tuple of Mode
        What may be modes that are missing.
    is_whole : bool
        Whether it is a record as one, and no window.
    """

    modes: ModeSet
    channels: NDArray[np.intp]
    spectra: Spectra
    usable: NDArray[np.bool_]
    resting: frozenset[GivenIndex]
    warm_start: WarmStart | None
    inputs: NDArray[np.complex64] | None = None
    candidates: tuple[Mode, ...] = ()
    is_whole: bool = False

    @classmethod
    def of(
        cls,
        samples: Samples,
        modes: ModeSet,
        harmonics: ModeSet | None,
        resting: Collection[int],
        warm_start: WarmStart | None,
        more: Sequence[Samples] = (),
        candidates: Sequence[Mode] = (),
        is_whole: bool = False,
    ) -> 'Record':
        """Transform the samples."""
        channels = moving_channels(samples)
        spectra = spectra_of(samples, channels, more)
        if spectra.values.nbytes >= LARGE_BYTES:
            give_back()
        return cls(
            modes,
            channels,
            spectra,
            usable_lines(spectra, harmonics or ()),
            frozenset(map(GivenIndex, resting)),
            warm_start,
            inputs_of(samples, more),
            tuple(candidates),
            is_whole,
        )

    def start_of(self, modes: Sequence[Mode]) -> StartModes:
        """Return poles and shapes of modes as they came."""
        return StartModes(
            np.array([mode.frequency_hz for mode in modes]),
            np.array([mode.damping_ratio for mode in modes]),
            np.column_stack([unit(mode.shape[self.channels]) for mode in modes]),
        )


@dataclass(frozen=True, slots=True)
class Refining:
    """The modes after one stage of their refinement.

    Parameters
    ----------
    record : Record
        What they are refined from.
    given : tuple of GivenIndex
        Which of the modes given are still refined, by frequency: those of ``ModeIndex`` 0, 1, ...
    start : StartModes
        These as they came.
    warm : StartingValues or None
        These as another stretch tells them, where it agrees.
    now : StartModes
        As refined so far: first those given, then those that were found missing.
    fits : tuple of GroupFit
        Of all groups of modes that overlap.
    added : mapping of ModeIndex to GroupFit
        Modes that were not given and that the data demand.
    outcomes : mapping of GivenIndex to Outcome
        As far as known.
    narrow : tuple of NarrowForce
        Forces that were taken for modes.
    """

    record: Record
    given: tuple[GivenIndex, ...]
    start: StartModes
    warm: StartingValues | None
    now: StartModes
    fits: tuple[GroupFit, ...] = ()
    added: Mapping[ModeIndex, GroupFit] = field(default_factory=dict)
    outcomes: Mapping[GivenIndex, Outcome] = field(default_factory=dict)
    narrow: tuple[NarrowForce, ...] = ()

    @classmethod
    def begin(
        cls,
        record: Record,
        given: Sequence[GivenIndex],
        outcomes: Mapping[GivenIndex, Outcome] | None = None,
    ) -> 'Refining':
        """Return some of the given modes before the first stage."""
        start = record.start_of([record.modes.modes[index] for index in given])
        warm = None
        if record.warm_start is not None:
            modes = [record.modes.modes[index] for index in given]
            idle = _positions(given, record.resting)
            warm = record.warm_start.start(modes, start, record.channels, idle)
        now = start if warm is None else warm.modes
        return cls(record, tuple(given), start, warm, now, outcomes=outcomes or {})

    @property
    def n_given(self) -> int:
        """How many of the modes given are refined; modes from here on were not given."""
        return len(self.given)

    @property
    def idle(self) -> frozenset[ModeIndex]:
        """Modes that shall not be refined."""
        return _positions(self.given, self.record.resting)

    @property
    def fitter(self) -> BandFitter:
        """Of the bands of the record."""
        return BandFitter(self.record.spectra, self.record.usable, self.idle)

    def given_mode(self, mode: ModeIndex) -> Mode:
        """Return a mode as it was given."""
        return self.record.modes.modes[self.given[mode]]


def _positions(
    given: Sequence[GivenIndex], resting: frozenset[GivenIndex]
) -> frozenset[ModeIndex]:
    return frozenset(ModeIndex(mode) for mode, index in enumerate(given) if index in resting)


def is_refinable(mode: Mode) -> bool:
    """Tell whether a mode is one that a refinement may begin with."""
    return not mode.harmonic and 1e-4 < mode.damping_ratio < 0.5
