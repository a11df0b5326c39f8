"""The workflow: compare, locate, name, decide, add, show."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from threadpoolctl import threadpool_limits

from modal_core.errors import ModelError
from model_gap.campaign import Campaign
from model_gap.decide import decide, Decision, gap_fraction, locate, noise_floor, Verdict, Where
from model_gap.fit import split
from model_gap.hypothesis import Hypothesis
from model_gap.predict import compile_laws
from model_gap.search import run_search, Search, SearchSettings
from structural_model import FlexibleJointModel


@dataclass(frozen=True)
class GapResult:
    """What was found.

    Parameters
    ----------
    search : Search
        Data, model and rounds.
    decision : Decision
        The verdict.
    final : Hypothesis
        Effects and tolerances at their fitted values.
    where : tuple of Where
        The gap by place.
    gap_before, gap_after, gap_before_heldout, gap_after_heldout, noise_floor : float
        Fractions of the response.
    seed : int
        Of the split.
    """

    search: Search
    decision: Decision
    final: Hypothesis
    where: tuple[Where, ...]
    gap_before: float
    gap_after: float
    gap_before_heldout: float
    gap_after_heldout: float
    noise_floor: float
    seed: int


def find_gap(
    model: FlexibleJointModel,
    campaign: Campaign,
    settings: SearchSettings | None = None,
    seed: int = 0,
    progress: Callable[[float], None] = lambda _: None,
) -> GapResult:
    """Find where a model and a campaign disagree, and why.

    Parameters
    ----------
    model : FlexibleJointModel
        As it is.
    campaign : Campaign
        Recordings of the robot.
    settings : SearchSettings or None
        Band, tolerances, catalogue.
    seed : int
        Of the draw of held-out poses, where the campaign does not say.
    progress : callable
        Takes the fraction done.

    Raises
    ------
    ModelError
        The model has no flexible joint to explain anything with.
    """
    if model.n_dof == 0:
        raise ModelError('model has no flexibility', where=model.robot_name)
    compile_laws()
    divided = split(campaign, np.random.default_rng(seed))
    search = Search.begin(model, divided, settings)
    with threadpool_limits(limits=1, user_api='blas'):  # small matrices: threads only wait
        return _result(run_search(search, progress), seed)


def _result(search: Search, seed: int) -> GapResult:
    decision = decide(search)
    final = search.rounds[0].before.hypothesis
    if decision.accepted and decision.verdict in (Verdict.NAMED, Verdict.AMBIGUOUS):
        final = decision.accepted[-1].fit.hypothesis
    return GapResult(
        search=search,
        decision=decision,
        final=final,
        where=locate(search, final),
        gap_before=gap_fraction(search.data.fitting, search.nominal),
        gap_after=gap_fraction(search.data.fitting, final),
        gap_before_heldout=gap_fraction(search.data.heldout, search.nominal),
        gap_after_heldout=gap_fraction(search.data.heldout, final),
        noise_floor=noise_floor(
            search.data.heldout if search.data.heldout.records else search.data.fitting
        ),
        seed=seed,
    )
