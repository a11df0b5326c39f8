"""Find the effects: fit tolerances, screen the catalogue, refine the best, repeat."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np

from model_gap.campaign import Band, Campaign, explicit_damping
from model_gap.cell import CellModel, nuisances, Tolerances
from model_gap.effects import CATALOGUE, Effect, Scene
from model_gap.fit import Fit, fit, fits, tolerance_columns
from model_gap.hypothesis import Hypothesis, stretch, STRETCHED, with_known_effects
from model_gap.search.evidence_bound import evidence_bound, least_further_gain, tolerance_excess
from model_gap.search.joint_screening import screen_jointly
from model_gap.search.lines import common_lines, lines_left
from model_gap.search.orders import orders_left
from model_gap.search.reach import within_reach
from model_gap.search.refine import fine_fits, rough_fits, same, SETTLED_MISFIT
from model_gap.search.screen import Projection, screen, Trial
from model_gap.search.search_data import prepare_data, SearchData
from structural_model import FlexibleJointModel

# An effect is tried only where a free force could gain so much, and this share of the best place.
LEAST_REACH = 3.0
REACH_SHARE = 0.1
# Nothing is refined when the best promises less than this share of what is worth adding.
PROMISE = 0.5
FURTHER_PROMISE = 1.0
# Below this misfit a linear trial says enough; nor is more needed where one promises such a share
# of what there is to gain.
OPEN_MISFIT = 1.1
CLOSED_SHARE = 0.8
# A misfit this large means that the fit without an effect is distorted: candidates are then tried
# on the nominal model.
DISTORTED_MISFIT = 4.0
# Of a misfit so small not all is resonance: hums stand out of it.
NEAR_MISFIT = 30.0
# Tolerances alone go far where an effect is missing: a fit that stopped short misleads.
FIRST_LINEARISATIONS = 3
# Of the whole work, what is left before the first round, and of that after each.
LEFT_AT_FIRST = 0.9
LEFT_AFTER = 0.4
# Log evidence by which a linear simulation must explain recordings better than a moving arm.
LINEAR_LEAD = 3.0


@dataclass(frozen=True)
class SearchSettings:
    """How a gap is searched for.

    Parameters
    ----------
    band : Band
        Where model and measurement are compared.
    tolerances : Tolerances
        Ordinary imperfection of the model.
    catalogue : tuple of Effect types
        What may be named.
    most_effects : int
        Stop after so many.
    worth_adding : float
        Least gain of log evidence for another effect.
    """

    band: Band = field(default_factory=Band)
    tolerances: Tolerances = field(default_factory=Tolerances)
    catalogue: tuple[type[Effect], ...] = CATALOGUE
    most_effects: int = 3
    worth_adding: float = 12.0


@dataclass(frozen=True)
class Candidate:
    """A refined hypothesis with one effect more than the one before.

    Parameters
    ----------
    effect : Effect
        The effect that was added.
    fit : Fit
        On the fitting records.
    gain : float
        Log evidence less that of the hypothesis without it.
    heldout_misfit : float
        χ on the held-out records.
    """

    effect: Effect
    fit: Fit
    gain: float
    heldout_misfit: float


@dataclass(frozen=True)
class Round:
    """One round of the search.

    Parameters
    ----------
    before : Fit
        The hypothesis the candidates were added to.
    heldout_before : float
        Its χ on the held-out records.
    candidates : tuple of Candidate
        Refined ones, best first.
    trials : tuple of Trial
        All screened ones, best first.
    """

    before: Fit
    heldout_before: float
    candidates: tuple[Candidate, ...]
    trials: tuple[Trial, ...]


@dataclass
class Search:
    """The data of a search and its steps so far.

    Parameters
    ----------
    model : FlexibleJointModel
        Nominal arm.
    campaign : Campaign
        Every record marked as held out or not.
    settings : SearchSettings
        How.
    progress : callable
        Takes the fraction done.
    simulated : bool or None
        The recordings are of a simulation linear about the motors' angles; None: not yet known.
    """

    model: FlexibleJointModel
    campaign: Campaign
    settings: SearchSettings = field(default_factory=SearchSettings)
    progress: Callable[[float], None] = lambda _: None
    rounds: list[Round] = field(default_factory=list)
    simulated: bool | None = None

    def __post_init__(self) -> None:
        """Transform the records."""
        cell = CellModel(explicit_damping(self.model.spec), self.campaign.layout.channels)
        names = tuple(sensor.name for sensor in self.campaign.layout)
        lines = common_lines(self.campaign.records, self.settings.band)
        cell = with_known_effects(Scene(self.model, names, cell, lines))
        self.scene = Scene(self.model, names, cell, lines)
        self.tolerances = nuisances(cell, links_with_mass(self.model), self.settings.tolerances)
        self.data = self._prepared(cell)

    def _prepared(self, about: CellModel | None) -> SearchData:
        """Make the records ready, as those of an arm, or (None) of a linear simulation."""
        lines, band = self.scene.lines_hz, self.settings.band
        about = None if self.simulated else about
        return prepare_data(self.campaign.records, self.model, band, lines, about)

    @property
    def nominal(self) -> Hypothesis:
        """The model as it was given."""
        return Hypothesis(
            self.scene, self.tolerances, (), np.zeros(len(self.tolerances)), np.zeros(0)
        )

    @property
    def notes(self) -> tuple[str, ...]:
        """What was assumed, left out or limits the comparison."""
        linear = (
            'recordings show neither sag nor second-order motion: compared with an arm that is '
            "linear about the motors' angles, as simulations are",
        )
        return (*self.campaign.notes, *(linear if self.simulated else ()))

    def heldout_misfit(self, hypothesis: Hypothesis) -> float:
        """Return χ on the held-out records, NaN without any."""
        heldout = self.data.heldout
        if not heldout.records:
            return float('nan')
        return heldout.weighting.misfit(heldout.rows(hypothesis.cell()))

    def run(self) -> list[Round]:
        """Search until nothing more is worth adding."""
        first = fit(self.nominal, self.data.fitting, relinearise=FIRST_LINEARISATIONS)
        current = self._followed(first).without_columns
        self._tell(0.0)
        for _ in range(self.settings.most_effects):
            step = self._settled(self._step(current))
            self.rounds.append(step)
            if not self.earns_place(step):
                break
            current = step.candidates[0].fit
            if evidence_bound(current) + tolerance_excess(current) < self.settings.worth_adding:
                break
        self.progress(1.0)
        return self.rounds

    def _tell(self, share: float) -> None:
        """Report how much of a round is done; what is left after it is mostly less than it."""
        begun, ends = (
            1.0 - LEFT_AT_FIRST * LEFT_AFTER**n for n in np.arange(2) + len(self.rounds)
        )
        self.progress(float(begun + share * (ends - begun)))

    def _settled(self, step: Round) -> Round:
        """Fit the best candidate to the end; drop earlier effects that no longer earn a place."""
        if not self.earns_place(step):
            return step
        best = step.candidates[0]
        last = fit(best.fit.hypothesis, self.data.fitting, iterations=4)
        number = 0
        while number < len(last.hypothesis.effects) - 1:
            fewer = last.hypothesis.without(number)
            again = fit(fewer, self.data.fitting, iterations=5, relinearise=0)
            if last.log_evidence - again.log_evidence < self.settings.worth_adding:
                last = again
            else:
                number += 1
        gain = last.log_evidence - step.before.log_evidence
        last = self._followed(last).without_columns
        held = self.heldout_misfit(last.hypothesis)
        settled = Candidate(best.effect, last, gain, held)
        return replace(step, candidates=(settled, *step.candidates[1:]))

    def _followed(self, fitted: Fit) -> Fit:
        """Fit again with the second-order motion of what was found out of the recordings.

        A linear simulation has none, and does not hang in its springs: what explains the
        recordings better is kept, once the gap is small enough to tell.
        """
        distorted = fitted.misfit > DISTORTED_MISFIT
        if self.simulated or (distorted and not fitted.hypothesis.effects):
            return fitted
        self.data = self._prepared(fitted.hypothesis.cell())
        again = partial(fit, fitted.hypothesis, linearised=fitted.linearised, iterations=4)
        found = again(predictor=self.data.fitting)
        if self.simulated is None:
            linear = self._prepared(None)
            other = again(predictor=linear.fitting)
            if min(other.misfit, found.misfit) < SETTLED_MISFIT:
                self.simulated = other.log_evidence > found.log_evidence + LINEAR_LEAD
            if self.simulated:
                self.data = linear
                return other
        return found

    def _candidate(self, fitted: Fit, before: Fit) -> Candidate:
        gain = fitted.log_evidence - before.log_evidence
        effect = fitted.hypothesis.effects[-1]
        return Candidate(effect, fitted, gain, self.heldout_misfit(fitted.hypothesis))

    def instead(self, final: Fit, best: Effect, other: Candidate) -> Candidate | None:
        """Return another effect beside all others that were found; None of an impossible arm.

        What two effects of an early round are worth tells little while others are missing.
        """
        keys = [effect.key for effect in final.hypothesis.effects]
        fewer = final.hypothesis.without(keys.index(best.key))
        start = fewer.with_effect(other.effect, other.fit.hypothesis.values()[-1])
        (fitted,) = fits(lambda it: fit(it, self.data.fitting, relinearise=2), [start])
        return self._candidate(fitted, self.rounds[0].before) if fitted else None

    def earns_place(self, step: Round) -> bool:
        """Return whether the best candidate of a round gains enough to be believed."""
        least = max(self.settings.worth_adding, least_further_gain(step.before))
        return bool(step.candidates) and step.candidates[0].gain >= least

    def _with_lines(self, current: Fit) -> Fit:
        """Look for hums and gear orders in what is left over, once the model is not far off."""
        if current.misfit > NEAR_MISFIT:
            return current
        fitting, hypothesis = self.data.fitting, current.hypothesis
        lines = lines_left(fitting, hypothesis, self.settings.band, self.scene.lines_hz)
        ripples = orders_left(hypothesis, fitting, self.scene.flexible_joints)
        new = lines != self.scene.lines_hz
        self.scene = replace(self.scene, lines_hz=lines, ripples=ripples)
        hypothesis = replace(hypothesis, scene=self.scene)
        if not new:
            return replace(current, hypothesis=hypothesis)
        self.data = self._prepared(hypothesis.cell())
        return fit(hypothesis, self.data.fitting, relinearise=0).without_columns

    def _step(self, current: Fit) -> Round:
        current = self._with_lines(current)
        candidates = [
            effect
            for kind in self.settings.catalogue
            for effect in kind.instances(self.scene)
            if not any(same(effect, item) for item in current.hypothesis.effects)
        ]
        self._tell(0.1)
        trials = self._screen(current, candidates)
        self._tell(0.4)
        share = FURTHER_PROMISE if current.hypothesis.effects else PROMISE
        stretched = stretch(current.hypothesis) > STRETCHED
        least = share * self.settings.worth_adding
        promising = stretched or any(trial.gain >= least for trial in trials[:1])
        refined = self._refine(current, trials) if promising else []
        found = [self._candidate(item, current) for item in refined]
        self._tell(0.85)
        return Round(
            before=current,
            heldout_before=self.heldout_misfit(current.hypothesis),
            candidates=tuple(sorted(found, key=lambda item: -item.gain)),
            trials=tuple(trials),
        )

    def _screen(self, current: Fit, candidates: Sequence[Effect]) -> list[Trial]:
        base = current.hypothesis
        predictor = self.data.screening
        stretched = stretch(base) > STRETCHED
        poor = current.misfit > DISTORTED_MISFIT
        if poor or not stretched:  # else tolerances hide what there is to reach
            bases = [base] if base.effects or not poor else [base, self.nominal]
            candidates = within_reach(candidates, bases, predictor, LEAST_REACH, REACH_SHARE)
            base = bases[-1]
        columns = tolerance_columns(base, predictor)
        projection = Projection.of(base, predictor, columns)
        trials = screen(candidates, projection, predictor)
        if self._is_open(current, trials):
            trials = screen_jointly(trials, current.hypothesis, self.data.loudest)
        return trials

    def _is_open(self, current: Fit, trials: Sequence[Trial]) -> bool:
        """Return whether there is a gap that no trial of the screening promises to close."""
        stretched = stretch(current.hypothesis) > STRETCHED
        closed = bool(trials) and trials[0].gain > CLOSED_SHARE * evidence_bound(current)
        return stretched or (current.misfit > OPEN_MISFIT and not closed)

    def _refine(self, current: Fit, trials: Sequence[Trial]) -> list[Fit]:
        rough = rough_fits(current, trials, self.data.coarse)
        self._tell(0.65)
        if rough and current.misfit > DISTORTED_MISFIT and not self.simulated:
            self.data = self._prepared(replace(rough[0].hypothesis, held=()).cell())
        return fine_fits(rough, self.data)


def links_with_mass(model: FlexibleJointModel) -> tuple[str, ...]:
    """Return the links that move on their own and have mass."""
    robot = model.robot
    return tuple(
        frame.name
        for frame in robot.model.frames
        if frame.type.name == 'BODY'
        and frame.parentJoint > 0
        and abs(frame.placement.translation).max() == 0.0
        and robot.model.inertias[frame.parentJoint].mass > 0.0
    )
