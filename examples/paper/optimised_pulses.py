"""Beyond the paper: pulses chosen by the planner against the paper's uniform intervals.

Run ``python -m examples.paper.optimised_pulses``.
"""

from dataclasses import dataclass

from examples.paper.cell import ROBOT, robot
from examples.paper.output import show_table
from excitation_planner.optimise import natural_std, optimise, uniform_intervals, worst_mode
from excitation_planner.plan import ExcitationPlan
from excitation_planner.planner import plan_excitation
from excitation_planner.request import PlanRequest
from structural_model import load_layout

SEED = 2025
DURATION_S = 20.0
HALF_RANGE_RAD = 0.02
NOISE_DENSITY = 0.01
N_TRIALS = 30


@dataclass(frozen=True)
class Choice:
    """A plan and what it is called."""

    name: str
    plan: ExcitationPlan
    band_hz: tuple[float, float]


def choices(n_trials: int = N_TRIALS, duration_s: float = DURATION_S) -> list[Choice]:
    """Plan uniform intervals, and the optimiser's choice of the same length and range."""
    model, layout = robot(), load_layout(ROBOT)
    request = PlanRequest(
        seed=SEED, duration_s=duration_s, noise_density=NOISE_DENSITY, half_range=HALF_RANGE_RAD
    )
    paper = uniform_intervals(request)
    found = optimise(model, layout, paper, n_trials=n_trials)
    band_hz = (paper.band_low_hz, paper.band_high_hz)
    return [
        Choice(name, plan_excitation(model, layout, chosen), band_hz)
        for name, chosen in (('uniform intervals', paper), ('optimised', found.request))
    ]


def main() -> None:
    rows = []
    for each in choices():
        assert each.plan.prediction is not None  # noqa: S101 - fresh plans carry it
        mode = worst_mode(each.plan.prediction.modes, each.band_hz)
        rows.append(
            (
                each.name,
                f'{mode.frequency_hz:.2f}',
                f'{mode.frequency_std_hz:.3f}',
                f'{mode.damping_ratio_std / mode.damping_ratio:.2f}',
                f'{natural_std(mode):.2f}',
                len(each.plan.prediction.missed),
            )
        )
    show_table(
        f'Beyond the paper: {DURATION_S:g} s at P1, ±{HALF_RANGE_RAD:g} rad, seed {SEED}',
        ('pulses', 'worst mode [Hz]', 'σ of f [Hz]', 'σ of ζ / ζ', 'worst σ', 'modes missed'),
        rows,
        keep='optimised',
    )


if __name__ == '__main__':
    main()
