"""What is kept of the plans that may still be started."""

from typing import Generic, TypeVar

from robot_bridge.player import PlanPath

T = TypeVar('T')


class ReleasedPlans(Generic[T]):
    """One thing for each plan, by its hash: what is started is what was armed.

    Whatever arrives in between is beside it, and never in its place.
    """

    def __init__(self) -> None:
        self._kept: dict[str, T] = {}

    def keep(self, in_hand: PlanPath | None, plan_hash: str, thing: T) -> None:
        """Keep the thing of a plan, and that of the plan that was in hand until now."""
        before = in_hand.plan_hash if in_hand is not None else ''
        self._kept = {key: one for key, one in self._kept.items() if key == before}
        self._kept[plan_hash] = thing

    def of(self, path: PlanPath | None) -> T | None:
        """Return what is kept of a plan; None where there is none."""
        return self._kept.get(path.plan_hash) if path is not None else None
