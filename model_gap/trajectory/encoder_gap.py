"""What an encoder campaign tells of a model: laws, quantities, verdict."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
import math

import numpy as np

from model_gap.decide import Verdict
from model_gap.trajectory.campaign import EncoderCampaign
from model_gap.trajectory.confirm import share_of
from model_gap.trajectory.fit import Fit
from model_gap.trajectory.gear_told import GearTold
from model_gap.trajectory.problem import Layout
from model_gap.trajectory.rival import Rival
from model_gap.trajectory.search import Found
from model_gap.trajectory.term import Array, Term, Track
from structural_model import FlexibleJointModel
from structural_model.description import KnownEffect


@dataclass(frozen=True)
class Law:
    """One effect that was found.

    Parameters
    ----------
    term : Term
        What and where.
    effect : KnownEffect
        With numbers from all recordings.
    fitted : KnownEffect
        With numbers from the fitted recordings alone.
    heldout : KnownEffect
        With numbers from the held-out recordings alone, with which they must agree.
    gain : float
        Log evidence it is worth beside the others.
    without, all_in : float
        Held-out gap of its quantity without it, and with all laws.
    rivals : tuple of str
        What would do nearly as well in its place.
    """

    term: Term
    effect: KnownEffect
    fitted: KnownEffect
    heldout: KnownEffect
    gain: float
    without: float
    all_in: float
    rivals: tuple[str, ...]


@dataclass(frozen=True)
class Quantity:
    """Torques or twists, before and after.

    Parameters
    ----------
    name : str
        ``torque`` or ``twist``.
    rows : tuple of str
        Joints.
    found : Found
        The search.
    laws : tuple of Law
        What was found.
    all_layout, all_fit, all_covariance
        Weights from all recordings.
    unconfirmed : tuple of Term
        Found in the fitted recordings, and no help in those held out.
    size : (n_rows,) array
        How much every row varies in the held-out recordings, as a mean square.
    rivals : tuple of Rival
        What data alone make of every row.
    before, after : dict of str to (n_rows,) array
        Rms error by recording, [N m] or [rad].
    noise : dict of str to (n_rows,) array
        Of it what the noise of the recording does, see :func:`noise.noise_in_band`.
    gears : tuple of GearTold
        Of twists: gears whose stiffness is not among the laws.
    """

    name: str
    rows: tuple[str, ...]
    found: Found
    laws: tuple[Law, ...]
    all_layout: Layout
    all_fit: Fit
    all_covariance: Array
    unconfirmed: tuple[Term, ...]
    size: Array
    rivals: tuple[Rival, ...]
    before: Mapping[str, Array]
    after: Mapping[str, Array]
    noise: Mapping[str, Array]
    gears: tuple[GearTold, ...]


@dataclass(frozen=True)
class EncoderGap:
    """What an encoder campaign tells of a model.

    Parameters
    ----------
    model : FlexibleJointModel
        As it was given.
    campaign : EncoderCampaign
        Recordings.
    tracks : tuple of Track
        Of all recordings, fitted ones first.
    quantities : tuple of Quantity
        Torques, then twists where there are encoders.
    """

    model: FlexibleJointModel
    campaign: EncoderCampaign
    tracks: tuple[Track, ...]
    quantities: tuple[Quantity, ...]

    @property
    def laws(self) -> tuple[Law, ...]:
        """All laws that were found."""
        return tuple(law for item in self.quantities for law in item.laws)

    @property
    def unexplained(self) -> list[tuple[str, str, Rival]]:
        """Quantity and axis of what data alone explain and the laws do not."""
        return [
            (item.name, row, rival)
            for item in self.quantities
            for row, rival in zip(item.rows, item.rivals, strict=True)
            if rival.beats
        ]

    @property
    def verdict(self) -> Verdict:
        """The word for all of it."""
        if any(rival.upsets for _, _, rival in self.unexplained):
            return Verdict.UNEXPLAINED
        if not self.laws:
            return Verdict.NONE
        sure = any(not law.rivals for law in self.laws)
        return Verdict.NAMED if sure else Verdict.AMBIGUOUS


def gap_share(quantity: Quantity, names: Sequence[str]) -> float:
    """Return the rms error after as a share of that before, axes in units of what they show."""
    return _share(quantity.after, quantity, names)


def noise_share(quantity: Quantity, names: Sequence[str]) -> float:
    """Return the noise as a share of the rms error before, as :func:`gap_share`."""
    return _share(quantity.noise, quantity, names)


def left_share(quantity: Quantity, names: Sequence[str]) -> float:
    """Return the rms error after as a share of what is measured, the mean over the axes."""
    size = np.maximum(quantity.size, 1e-300)
    after = np.mean([quantity.after[name] ** 2 for name in names], axis=0)
    return math.sqrt(float(np.mean(after / size)))


def _share(errors: Mapping[str, Array], quantity: Quantity, names: Sequence[str]) -> float:
    squares, before = (
        np.mean([part[name] ** 2 for name in names], axis=0) for part in (errors, quantity.before)
    )
    return math.sqrt(share_of(squares, before, quantity.size))
