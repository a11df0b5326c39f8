"""What torque laws of a spring share that gravity twists: how much of its load is there."""

from collections.abc import Sequence
from typing import ClassVar

from model_gap.effects.effect import Effect, EffectParameter, Scene

SHARE = 'preload_share'


class PreloadedEffect(Effect):
    """A law about the twist under gravity; where there is none, its share is no number."""

    amplitude_dependent = True
    optional = (SHARE,)
    # Twist under gravity [rad] from which the law depends on it: a hundredth of what springs twist
    # when the arm is shaken (1e-4 rad).
    least_preload_rad: ClassVar[float] = 1e-6
    most_share: ClassVar[float] = 1.5

    @classmethod
    def instances(cls, scene: Scene) -> Sequence[Effect]:
        """Return one per flexible joint."""
        return [cls(*place) for place in scene.joint_places]

    def preload(self, scene: Scene) -> tuple[EffectParameter, ...]:
        """Return how much of the computed gravity load is there, where there is any."""
        if not scene.is_preloaded(self.place, self.least_preload_rad):
            return ()
        return (EffectParameter(SHARE, '1', 0.5, 0.0, self.most_share, neutral=1.0),)

    def with_preload(
        self, starts: Sequence[tuple[float, float]], scene: Scene
    ) -> Sequence[tuple[float, ...]]:
        """Return starts, each with its share where gravity loads the joint."""
        if self.preload(scene):
            return starts
        return list(dict.fromkeys((value,) for value, _ in starts))


def law_values(values: Sequence[float]) -> tuple[float, float]:
    """Return what a law takes: its own number, and the share, all of it where it is no number."""
    value, *share = values
    return value, share[0] if share else 1.0
