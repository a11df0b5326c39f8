"""The workflow: compare, locate, name, decide, add, show."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
import logging

import numpy as np
from threadpoolctl import threadpool_limits

from modal_core.errors import ModelError
from modal_core.work.progress import as_much_again, Progress
from model_gap.campaign import Campaign
from model_gap.decide import (
    decide,
    Decision,
    gap_fraction,
    least_seen,
    LeastSeen,
    locate,
    noise_floor,
    untold,
    Verdict,
    Where,
)
from model_gap.fit import Fit, split
from model_gap.gravity import (
    as_it_stands,
    encoders_told,
    Fault,
    left_open,
    put_right,
    rest_of,
    same_put_right,
    standing_as,
    weigh,
    weighed_again,
)
from model_gap.hypothesis import Hypothesis, stretch, STRETCHED
from model_gap.named_at_rest import with_faults
from model_gap.open_encoders import other_encoders, OtherEncoders
from model_gap.predict import compile_laws
from model_gap.quick_look import look_at, QuickLook
from model_gap.search import run_search, Search, search_on_all, SearchSettings, tolerances_only
from model_gap.travelled import compares_none, Travelled, with_travel, without_travelled
from structural_model import FlexibleJointModel

log = logging.getLogger(__name__)


@dataclass(frozen=True)
class GapResult:
    """What was found.

    Parameters
    ----------
    search : Search
        Data, model and rounds.
    decision : Decision
        The verdict.
    calibrated : Fit or None
        Effects and tolerances as the corrected model has them; None: it stays as it was given.
    where : tuple of Where
        The gap by place.
    gap_before, gap_after, gap_before_heldout, gap_after_heldout, noise_floor : float
        Fractions of the response.
    faults_at_rest : tuple of Fault
        What gravity shows to be wrong with sensors and encoders, before any dynamics.
    encoders_told : dict of str to float [deg]
        To how many degrees gravity tells the zero of every joint's encoder; inf: it does not.
    given : FlexibleJointModel
        The model before gravity put right where it stands.
    seed : int
        Of the split.
    travelled : Travelled or None
        Recordings whose joints travel too far to be compared; None: there are none.
    other_encoders : OtherEncoders or None
        Encoders that explain as well what was calibrated; None: none do.
    least_seen : tuple of LeastSeen
        Where nothing was found: how large effects would have to be to be named.
    """

    search: Search
    decision: Decision
    calibrated: Fit | None
    where: tuple[Where, ...]
    gap_before: float
    gap_after: float
    gap_before_heldout: float
    gap_after_heldout: float
    noise_floor: float
    faults_at_rest: tuple[Fault, ...]
    encoders_told: Mapping[str, float]
    given: FlexibleJointModel
    seed: int
    travelled: Travelled | None = None
    other_encoders: OtherEncoders | None = None
    least_seen: tuple[LeastSeen, ...] = ()

    @property
    def final(self) -> Hypothesis:
        """Effects and tolerances of the corrected model: its prediction is what is left."""
        return self.calibrated.hypothesis if self.calibrated else self.search.nominal


def find_gap(
    model: FlexibleJointModel,
    campaign: Campaign,
    settings: SearchSettings | None = None,
    seed: int = 0,
    progress: Progress = lambda _: None,
    first: Callable[[QuickLook], None] = lambda _: None,
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
        Takes the fraction done; less than before where more is to be done than was known.
    first : callable
        Takes what can be said before any effect is tried, while the work goes on.

    Raises
    ------
    ModelError
        The model has no flexible joint to explain anything with.
    """
    if model.n_dof == 0:
        raise ModelError('model has no flexibility', where=model.robot_name)
    settings = settings or SearchSettings()
    compile_laws()
    rest = rest_of(model, campaign)
    faults = weigh(rest, settings.tolerances)
    told = encoders_told(rest, settings.tolerances)
    with threadpool_limits(limits=1, user_api='blas'):  # small matrices: threads only wait
        found = _searched(model, campaign, settings, faults, seed, progress, first)
        if not found.settled:
            log.debug('gravity weighed anew: %s', [fault.words() for fault in found.faults])
            again = as_much_again(progress)
            other = _searched(model, campaign, settings, found.faults, seed, again)
            found = other if other.settled else found
        result = _result(found, told, model, seed)
    progress(1.0)
    return result


@dataclass(frozen=True)
class _Found:
    """What a search found, gravity as it was understood before, and as it is now."""

    search: Search
    at_first: tuple[Fault, ...]
    decision: Decision
    calibrated: Fit | None
    travelled: Travelled | None
    faults: tuple[Fault, ...]

    @property
    def known(self) -> bool:
        """Whether the arm is understood."""
        explained = self.decision.verdict is not Verdict.UNEXPLAINED
        return self.calibrated is not None and explained

    @property
    def settled(self) -> bool:
        """Whether what was put right is wrong with the arm as it is known now, too."""
        return same_put_right(self.at_first, self.faults)

    @property
    def decided(self) -> Decision:
        """The verdict: what gravity contradicts is not certain."""
        if self.settled or self.decision.verdict is not Verdict.NAMED:
            return self.decision
        now = '; '.join(fault.words() for fault in self.faults) or 'nothing is wrong'
        reason = f'gravity, weighed again with what was found, says otherwise: {now}'
        reasons = (*self.decision.reasons, reason)
        return replace(self.decision, verdict=Verdict.AMBIGUOUS, reasons=reasons)

    @property
    def final(self) -> Hypothesis:
        """Effects and tolerances of the corrected model."""
        return self.calibrated.hypothesis if self.calibrated else self.search.nominal


def _searched(
    model: FlexibleJointModel,
    campaign: Campaign,
    settings: SearchSettings,
    faults: tuple[Fault, ...],
    seed: int,
    progress: Progress,
    first: Callable[[QuickLook], None] = lambda _: None,
) -> _Found:
    """Search with model and campaign put right."""
    standing, right = as_it_stands(model, faults), put_right(campaign, faults)
    open_ = replace(settings, tolerances=left_open(settings.tolerances, faults))
    compared, travelled = without_travelled(standing, right, settings.band)
    divided = split(compared, np.random.default_rng(seed))
    search = Search.begin(standing, divided, open_)

    def tell(begun: Search) -> None:
        first(look_at(begun, faults, travelled))

    if compares_none(travelled):
        search = tolerances_only(search, tell)
    else:
        search = run_search(search, progress, tell)
        if untold(search):
            search = search_on_all(search, as_much_again(progress))
    decision = with_travel(decide(search), search, travelled)
    unread = compares_none(travelled) and decision.verdict is Verdict.UNEXPLAINED
    calibrated = None if unread else _calibrated(search, decision)
    found = _Found(search, faults, decision, calibrated, travelled, faults)
    if not found.known:
        return found
    again = weighed_again(faults, found.final, model, campaign, settings.tolerances)
    return replace(found, faults=again)


def _result(
    found: _Found,
    told: Mapping[str, float],
    given: FlexibleJointModel,
    seed: int,
) -> GapResult:
    search, final, calibrated = found.search, found.final, found.calibrated
    faults = found.faults if found.settled else found.at_first
    before = _as_given(search, given)
    heldout = search.data.heldout if search.data.heldout.records else search.data.fitting
    return GapResult(
        search=search,
        decision=with_faults(found.decided, faults, calibrated),
        calibrated=calibrated,
        where=locate(search, final),
        gap_before=gap_fraction(search.data.fitting, before),
        gap_after=gap_fraction(search.data.fitting, final),
        gap_before_heldout=gap_fraction(search.data.heldout, before),
        gap_after_heldout=gap_fraction(search.data.heldout, final),
        noise_floor=noise_floor(heldout),
        faults_at_rest=faults,
        encoders_told=told,
        given=given,
        seed=seed,
        travelled=found.travelled,
        other_encoders=(
            other_encoders(calibrated, search.data.fitting, told)
            if calibrated and found.known
            else None
        ),
        least_seen=least_seen(search) if found.decision.verdict is Verdict.NONE else (),
    )


def _as_given(search: Search, given: FlexibleJointModel) -> Hypothesis:
    """Return the model as it was given: joints and base where its file has them."""
    nominal = search.nominal
    spec = standing_as(nominal.scene.cell.spec, given)
    scene = replace(nominal.scene, cell=nominal.scene.cell.with_spec(spec))
    return replace(nominal, scene=scene)


def _calibrated(search: Search, decision: Decision) -> Fit | None:
    """Return what the corrected model is: the last accepted fit, else tolerances alone.

    Where something stays unexplained these may stand for it: they are kept only if they remain
    ordinary and predict recordings better that took no part.
    """
    if decision.accepted and decision.verdict in (Verdict.NAMED, Verdict.AMBIGUOUS):
        return decision.accepted[-1].fit
    first = search.rounds[0].before
    if decision.verdict is not Verdict.UNEXPLAINED:
        return first
    heldout = search.data.heldout
    ordinary = stretch(first.hypothesis) <= STRETCHED and bool(heldout.records)
    better = ordinary and (
        gap_fraction(heldout, first.hypothesis) < gap_fraction(heldout, search.nominal)
    )
    return first if better else None
