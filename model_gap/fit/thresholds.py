"""When numbers fit, in one place, with source or measure."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class FitThresholds:
    """Limits of fitting hypotheses to data."""

    effective_data: float = 300.0
    """Independent pieces that the data count as: errors of a model are alike over
    neighbouring bins and sensors."""
    trials: tuple[float, ...] = 1.0, 0.4, 0.12
    """Parts of a step that are tried in turn. Chosen, not measured."""
    little_gain: float = 1.0
    """Derivatives are still good where a descent gained less log probability than this: 1.4
    σ."""
    tolerance_step: float = 0.05
    """Of a tolerance, in its deviations, for derivatives: chosen, not measured."""
    effect_step: float = 0.002
    """Of a number of an effect, in its scale, for derivatives. Chosen, not measured."""
    little_sag: float = 0.005
    """[rad] or [m] that an arm hangs in its springs. Derivatives that leave out where it hangs
    with others are 0.5 % off then, less than by what is left out elsewhere (2 %); 13 % where a
    counterbalance pulls it 0.13 rad aside."""
    rounds: int = 4
    """Rounds of the posterior predictive check. Chosen, not measured."""
    check_steps: int = 5
    """Steps of that check at most, each linearised anew: one is enough of a model that is known
    well."""
    heldout_share: float = 0.4
    """Of the poses, held out. Chosen, not measured."""
    least_poses: int = 3
    """Poses from which on any is held out: two are left to fit."""


FIT = FitThresholds()
