"""One physical effect of the catalogue: what it does to a cell, and what is known about it."""

from abc import ABC, abstractmethod
from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
import math
from types import MappingProxyType
from typing import ClassVar

import numpy as np

from model_gap.cell import BETWEEN_LINKS, CellModel, is_coupled, marked, Nuisance, Ripple
from structural_model import FlexibleJointModel

FEW_STARTS = 4


@dataclass(frozen=True)
class EffectParameter:
    """One number of an effect; fitted on an inner scale x with value = from_inner(x).

    Parameters
    ----------
    name, unit : str
        As reported.
    scale : float
        Of the prior on the inner scale, what is plausible: its standard deviation were it normal.
    low, high : float
        Plausible range of the value.
    neutral : float
        Value at which the effect does nothing, at x = 0.
    log : bool
        value = neutral·exp(x) instead of neutral + x.
    """

    name: str
    unit: str
    scale: float
    low: float
    high: float
    neutral: float = 0.0
    log: bool = False

    def value(self, inner: float) -> float:
        """Return the value of an inner number, inside the plausible range."""
        raw = self.neutral * np.exp(inner) if self.log else self.neutral + inner
        return float(min(max(raw, self.low), self.high))

    def inner(self, value: float) -> float:
        """Return the inner number of a value."""
        return float(np.log(value / self.neutral)) if self.log else float(value - self.neutral)

    def is_size_of(self, first: 'EffectParameter') -> bool:
        """Return whether it says how large an effect is, as its first number does."""
        alike = self.unit == first.unit and not self.log and self.neutral == 0.0
        return self is first or alike

    def said(self, value: float) -> str:
        """Return a value with its unit."""
        return f'{value:.3g}' + ('' if self.unit == '1' else f' {self.unit}')

    def slope(self, inner: float) -> float:
        """Return d value / d inner."""
        return self.value(inner) if self.log else 1.0


@dataclass(frozen=True, slots=True)
class ToldNumber:
    """One number of an effect as people read it.

    Parameters
    ----------
    name, unit : str
        As reported.
    value : float
        In that unit.
    """

    name: str
    unit: str
    value: float


@dataclass(frozen=True, slots=True)
class Hanging:
    """Where a mass that swings would explain much of what is left over.

    Parameters
    ----------
    link, axis : str
        What it hangs on, and the axis of the link it swings along.
    point : (3,) tuple [m]
        Where on the link, in its axes.
    mass_kg, frequency_hz, damping_ratio : float
        Of the mass.
    """

    link: str
    axis: str
    point: tuple[float, float, float]
    mass_kg: float
    frequency_hz: float
    damping_ratio: float


@dataclass(frozen=True)
class Scene:
    """What an effect may be attached to.

    Parameters
    ----------
    model : FlexibleJointModel
        Nominal arm.
    sensors : tuple of str
        Names of the sensors.
    cell : CellModel
        Nominal cell.
    lines_hz : tuple of float [Hz]
        Lines seen in the recordings, strongest first.
    ripples : tuple of Ripple
        Seen in what is left over, most likely ones of every joint.
    hanging : tuple of Hanging
        Masses that would explain most of what is left over, a few of every link and axis.
    preload_rad : dict of str to float [rad]
        Most that gravity twists each joint (``joint_marks``) in the poses that were recorded; of
        those that are missing it is not known.
    """

    model: FlexibleJointModel
    sensors: tuple[str, ...]
    cell: CellModel
    lines_hz: tuple[float, ...] = ()
    ripples: tuple[Ripple, ...] = ()
    hanging: tuple[Hanging, ...] = ()
    preload_rad: Mapping[str, float] = field(default_factory=dict)

    def is_preloaded(self, place: str, least_rad: float) -> bool:
        """Return whether gravity may twist a joint by more than that."""
        return self.preload_rad.get(place, math.inf) > least_rad

    @property
    def flexible_joints(self) -> tuple[str, ...]:
        """Joints with a drive compliance."""
        return tuple(item.name for item in self.cell.spec.joints if not item.drive.spring.rigid)

    @property
    def joint_places(self) -> tuple[tuple[str, str], ...]:
        """Flexible joints; those whose drive a rod couples also between their two links."""
        coupled = [name for name in self.flexible_joints if is_coupled(self.model, name)]
        return (
            *((name, '') for name in self.flexible_joints),
            *((name, BETWEEN_LINKS) for name in coupled),
        )

    @property
    def joint_marks(self) -> tuple[str, ...]:
        """The same, as names of joint torques."""
        return tuple(marked(*place) for place in self.joint_places)


class Effect(ABC):
    """A named effect at a location; immutable, without numbers of its own."""

    type: ClassVar[str]
    equation: ClassVar[str]
    source: ClassVar[str]
    signature: ClassVar[str]
    # What it says of the robot, a plain sentence: {place} and the parameters by name.
    says: ClassVar[str] = ''
    # Other type to the experiment that separates the two.
    confused_with: ClassVar[Mapping[str, str]] = MappingProxyType({})
    amplitude_dependent: ClassVar[bool] = False
    moves_poles: ClassVar[bool] = True
    # Type of the effect that it generalises: tried only where that is good, and named only where
    # it is better by more than what two explanations are told apart by.
    special_case: ClassVar[str] = ''
    # Parameters that are a point of its link, in the link's axes.
    point: ClassVar[tuple[str, ...]] = ()
    # Parameters that turn its axis, which is its variant, towards the two axes after it.
    turns: ClassVar[tuple[str, ...]] = ()
    # What it finds is written into the sensor layout: how readings mix, at all frequencies alike.
    of_layout: ClassVar[bool] = False
    # Steps of a joint fit after which it is judged whether a start leads anywhere.
    first_steps: ClassVar[int] = 2
    # It hangs at a point of a link, and where is sought before it is tried: ``Scene.hanging``.
    hangs: ClassVar[bool] = False
    # Link or joint a picture shows it at, where it has no place of its own.
    shown_at: ClassVar[str] = ''
    # Parameters that are there only where they act; elsewhere they are neutral.
    optional: ClassVar[tuple[str, ...]] = ()

    def __init__(self, location: str | None = None, variant: str = '') -> None:
        self.location = location
        self.variant = variant

    @classmethod
    @abstractmethod
    def instances(cls, scene: Scene) -> Sequence['Effect']:
        """Return one effect per possible location."""

    @abstractmethod
    def parameters(self, scene: Scene) -> tuple[EffectParameter, ...]:
        """Return the parameters with units and ranges."""

    @abstractmethod
    def apply(self, cell: CellModel, values: Sequence[float], scene: Scene) -> CellModel:
        """Return a cell that contains the effect."""

    def starts(self, scene: Scene) -> Sequence[Sequence[float]]:
        """Return values to start the fit from: a coarse grid over the plausible range."""
        grids = [np.linspace(item.low, item.high, 5) for item in self.parameters(scene)]
        return [tuple(grid[1] for grid in grids), tuple(grid[3] for grid in grids)]

    def other_starts(self, values: tuple[float, ...]) -> Sequence[tuple[float, ...]]:
        """Return further ways into a fit of what promised most, where one may end in a trap."""
        return ()

    def generalise(self, values: tuple[float, ...]) -> Sequence[tuple[float, ...]]:
        """Return starts near what its special case was fitted to."""
        return ()

    def simpler(
        self, values: tuple[float, ...], scene: Scene
    ) -> 'tuple[Effect, tuple[float, ...]] | None':
        """Return what it is a case of without its last freedom, and the numbers it has there.

        A law with more numbers comes near what is simpler from any start, and may hide it.
        """
        return None

    def instead_of(
        self, tolerance: Nuisance, deviations: float, scene: Scene
    ) -> Sequence[Sequence[float]]:
        """Return starts with which the effect may do what a tolerance far off nominal does."""
        return ()

    def few_starts(self, scene: Scene) -> Sequence[Sequence[float]]:
        """Return a few of the starts, for a fit that finds its way from afar."""
        starts = self.starts(scene)
        inner = np.linspace(0, len(starts) - 1, FEW_STARTS + 2)[1:-1]
        return [starts[place] for place in np.unique(np.rint(inner).astype(int))]

    def detailed(self) -> 'Effect | None':
        """Return the effect with what matters less, such as its exact place, free as well.

        Its parameters are those of this effect, then others that start at their neutral values.
        None when there is nothing more to free.
        """
        return None

    def told(self, values: Sequence[float], scene: Scene) -> tuple[ToldNumber, ...]:
        """Return the numbers as people read them: those fitted, where these say it already."""
        items = self.parameters(scene)
        return tuple(
            ToldNumber(item.name, item.unit, float(value))
            for item, value in zip(items, values, strict=True)
        )

    def probe(self, cell: CellModel, scene: Scene) -> tuple[CellModel, str] | None:
        """Return where a force bounds what the effect explains: an arm, a coordinate of it.

        None when the effect does not act along one coordinate.
        """
        return (cell, self.place) if self.amplitude_dependent else None

    @classmethod
    def in_words(cls, place: str, numbers: Mapping[str, float]) -> str:
        """Return what the effect says of the robot, a plain sentence.

        Parameters
        ----------
        place : str
            Where, as people say it.
        numbers : dict of str to float
            Parameters by name.
        """
        words = cls.says or f'{cls.type.replace("_", " ")} at {{place}}'
        known: defaultdict[str, object] = defaultdict(lambda: math.nan, numbers, place=place)
        return words.format_map(known)

    @property
    def free_numbers(self) -> int:
        """How many numbers are fitted in every record beside the parameters."""
        return 0

    @property
    def place(self) -> str:
        """Name of the joint torque, for effects that are one."""
        return marked(str(self.location), self.variant)

    @property
    def key(self) -> tuple[str, str]:
        """Type and location."""
        return self.type, self.location or ''

    def __repr__(self) -> str:
        """Return type at location."""
        place = f' at {self.location}' if self.location else ''
        return ' '.join(filter(None, (f'{self.type}{place}', self.variant.strip())))


def same(one: Effect, other: Effect) -> bool:
    """Return whether two effects are one and the same, whatever details are free."""
    return (one.key, one.variant) == (other.key, other.variant)


class DetailedEffect(Effect):
    """An effect with details that no one knows, free once a fit is good.

    Parameters
    ----------
    location, variant : str
        Where, and which of several.
    details : bool
        Whether they are free.
    """

    def __init__(
        self, location: str | None = None, variant: str = '', details: bool = False
    ) -> None:
        super().__init__(location, variant)
        self.details = details

    def detailed(self) -> Effect | None:
        """Return the effect with its details free, None when they are."""
        return None if self.details else type(self)(self.location, self.variant, details=True)
