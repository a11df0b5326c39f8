"""What a predictor computed last, by all it depends on.

Fits, screening and reports ask for the same cell many times over, or for one that differs only in
its sensors.  What is remembered never changes an answer: the key holds everything it depends on.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, Generic, TypeVar

from model_gap.cell import PoseSystem
from model_gap.predict.local_torques import Paths
from model_gap.predict.solved import Solved
from structural_model import FlexibleJointModel

Value = TypeVar('Value')


@dataclass(frozen=True, eq=False)
class Identity:
    """Objects as part of a key, equal only to themselves: arrays need not be compared.

    Parameters
    ----------
    objects : tuple
        Kept alive, so that no others can take their places.
    """

    objects: tuple[Any, ...]

    def __eq__(self, other: object) -> bool:
        """Return whether another key is of the same objects."""
        return (
            isinstance(other, Identity)
            and len(self.objects) == len(other.objects)
            and all(one is two for one, two in zip(self.objects, other.objects, strict=True))
        )

    def __hash__(self) -> int:
        """Return a hash of who the objects are."""
        return hash(tuple(map(id, self.objects)))


@dataclass
class Latest(Generic[Value]):
    """The value that was computed last, and its key; nothing at first."""

    known: tuple[tuple[Any, ...], Value] | None = None

    def of(self, key: tuple[Any, ...], compute: Callable[[], Value]) -> Value:
        """Return the value of a key, computed if it is another than the last.

        Parameters
        ----------
        key : tuple
            All that the value depends on; compared with ``==``.
        compute : callable
            Gives the value.
        """
        if self.known is None or self.known[0] != key:
            self.known = key, compute()
        return self.known[1]


@dataclass
class PredictionCache:
    """What predictors computed last; may be shared, since keys name the records.

    Parameters
    ----------
    arms : Latest
        An arm by its spec.
    systems : Latest
        Linear systems at all poses by spec and channels.
    motions : Latest
        How the arm moves, by the cell but for what only sensors read.
    paths : Latest
        Paths of nonlinear torques, by the cell without them.
    """

    arms: Latest[FlexibleJointModel] = field(default_factory=Latest)
    systems: Latest[list[PoseSystem]] = field(default_factory=Latest)
    motions: Latest[Solved] = field(default_factory=Latest)
    paths: Latest[Paths] = field(default_factory=Latest)
