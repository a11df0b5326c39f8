"""Find the effects: fit tolerances, screen the catalogue, refine the best, repeat."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from model_gap.campaign import Campaign, GapRecord
from model_gap.effects import CATALOGUE, Effect, Scene
from model_gap.explicit_damping import explicit_damping
from model_gap.fit import EFFECTIVE_DATA, Fit, fit
from model_gap.hypothesis import Hypothesis
from model_gap.known_effects import with_known_effects
from model_gap.linearise import misfit, tolerance_columns, Weighting
from model_gap.lines import common_lines
from model_gap.nuisance import nuisances, Tolerances
from model_gap.predict import Predictor, SAME_POSE_RAD
from model_gap.reach import within_reach
from model_gap.screen import Projection, screen, Trial
from model_gap.setup import Setup
from model_gap.spectra import Band, record_spectra, TARGET_BINS
from model_gap.time_domain import STEPS_PER_S
from structural_model import FlexibleJointModel

SCREEN_BINS = 90
MANY_CHANNELS = 15
LEAST_BINS = 60
SCREEN_POSES = 3
COARSE_STEPS = 400.0
SCREEN_S = 12.0
# An effect is tried only where a free force could gain so much, and this share of the best place.
LEAST_REACH = 3.0
REACH_SHARE = 0.1
ROUGH = 8
ROUGH_PER_TYPE = 3
# As many beside an accepted torque law, where a fit takes longer.
AFTER_TORQUES = 4
REFINED = 4
# Rough fits this far behind the best are not refined.
HOPELESS = 200.0
# Effects with more parameters come from further away and are linearised more often.
FEW_PARAMETERS = 3
# Once a rough fit is this good, torque laws that promised less than this share are not tried.
SETTLED_MISFIT = 1.5
SETTLED_SHARE = 0.5
# Nor is what promised less than this share of the best in the screening.
LEAST_PROMISE = 0.06
# Nothing is refined when the best promises less than this share of what is worth adding.
PROMISE = 0.5
FURTHER_PROMISE = 1.0
# Tolerances this far out of their range absorb an effect.  A misfit this large means that the fit
# without an effect is distorted: candidates are then tried on the nominal model.
DISTORTED_TOLERANCE = 3.5
DISTORTED_MISFIT = 4.0


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
class Step:
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
    """

    model: FlexibleJointModel
    campaign: Campaign
    settings: SearchSettings = field(default_factory=SearchSettings)
    progress: Callable[[float], None] = lambda _: None
    steps: list[Step] = field(default_factory=list)

    def __post_init__(self) -> None:
        """Transform the records."""
        setup = Setup(explicit_damping(self.model.spec), self.campaign.layout.channels)
        names = tuple(sensor.name for sensor in self.campaign.layout)
        self._n_channels = len(setup.channels)
        lines = common_lines(self.campaign.records, self.settings.band)
        setup = with_known_effects(Scene(self.model, names, setup, lines))
        self.scene = Scene(self.model, names, setup, lines)
        self.tolerances = nuisances(setup, moving_links(self.model), self.settings.tolerances)
        fitting = [record for record in self.campaign.records if not record.heldout]
        heldout = [record for record in self.campaign.records if record.heldout]
        self.fitting = self._predictor(fitting)
        self.heldout = self._predictor(heldout)
        short = [shortened(record, SCREEN_S) for record in fitting]
        self.coarse = self._predictor(short, SCREEN_BINS, COARSE_STEPS)
        few = of_first_poses(short, SCREEN_POSES)
        self.screening = self._predictor(few, SCREEN_BINS, COARSE_STEPS)
        self.weighting = Weighting.of(self.fitting)
        self.heldout_weighting = Weighting.of(self.heldout) if heldout else None
        self.coarse_weighting = Weighting.of(self.coarse)
        self.screening_weighting = Weighting.of(self.screening)

    def _predictor(
        self,
        records: Sequence[GapRecord],
        bins: int = TARGET_BINS,
        steps_per_s: float = STEPS_PER_S,
    ) -> Predictor:
        band = self.settings.band
        lines = self.scene.lines_hz
        # Many channels say the same with fewer bins.
        bins = max(LEAST_BINS, round(bins * min(1.0, MANY_CHANNELS / self._n_channels)))
        spectra = [record_spectra(item, band, bins, lines) for item in records]
        return Predictor(self.model, spectra, steps_per_s)

    @property
    def nominal(self) -> Hypothesis:
        """The model as it was given."""
        return Hypothesis(
            self.scene, self.tolerances, (), np.zeros(len(self.tolerances)), np.zeros(0)
        )

    def heldout_misfit(self, hypothesis: Hypothesis) -> float:
        """Return χ on the held-out records, NaN without any."""
        if self.heldout_weighting is None:
            return float('nan')
        rows = self.heldout_weighting.rows(self.heldout.predict(hypothesis.setup()))
        return misfit(self.heldout_weighting, rows)

    def run(self) -> list[Step]:
        """Search until nothing more is worth adding."""
        current = fit(self.nominal, self.fitting, self.weighting)
        for number in range(self.settings.most_effects):
            step = self._settled(self._step(current))
            self.steps.append(step)
            self.progress((number + 1.0) / (self.settings.most_effects + 1.0))
            if not step.candidates or step.candidates[0].gain < self.settings.worth_adding:
                break
            current = step.candidates[0].fit
            if self._room_left(current) < self.settings.worth_adding:
                break
        self.progress(1.0)
        return self.steps

    def _settled(self, step: Step) -> Step:
        """Fit the best candidate to the end; drop earlier effects that no longer earn a place."""
        if not step.candidates or step.candidates[0].gain < self.settings.worth_adding:
            return step
        best = step.candidates[0]
        last = fit(best.fit.hypothesis, self.fitting, self.weighting, iterations=4)
        number = 0
        while number < len(last.hypothesis.effects) - 1:
            fewer = last.hypothesis.without(number)
            again = fit(fewer, self.fitting, self.weighting, iterations=5, relinearise=0)
            if last.log_evidence - again.log_evidence < self.settings.worth_adding:
                last = again
            else:
                number += 1
        return replace(
            step,
            candidates=(self._candidate(best.effect, last, step.before), *step.candidates[1:]),
        )

    def _candidate(self, effect: Effect, fitted: Fit, before: Fit) -> Candidate:
        gain = fitted.log_evidence - before.log_evidence
        return Candidate(effect, fitted, gain, self.heldout_misfit(fitted.hypothesis))

    def _room_left(self, current: Fit) -> float:
        """Return what one more effect could gain at best: down to the noise, at no prior cost."""
        values = current.hypothesis.tolerance_values
        left = EFFECTIVE_DATA * np.log(max(current.misfit, 1.0))
        return float(left + 0.5 * values @ values)

    def _step(self, current: Fit) -> Step:
        candidates = [
            effect
            for kind in self.settings.catalogue
            for effect in kind.instances(self.scene)
            if effect.key not in [item.key for item in current.hypothesis.effects]
        ]
        trials = self._screen(current, candidates)
        share = FURTHER_PROMISE if current.hypothesis.effects else PROMISE
        stretched = _stretched(current.hypothesis) > DISTORTED_TOLERANCE
        promising = trials and (stretched or trials[0].gain >= share * self.settings.worth_adding)
        refined = self._refine(current, chosen(trials)) if promising else []
        return Step(
            before=current,
            heldout_before=self.heldout_misfit(current.hypothesis),
            candidates=tuple(sorted(refined, key=lambda item: -item.gain)),
            trials=tuple(trials),
        )

    def _screen(self, current: Fit, candidates: Sequence[Effect]) -> list[Trial]:
        base = current.hypothesis
        predictor, weighting = self.screening, self.screening_weighting
        stretched = _stretched(base) > DISTORTED_TOLERANCE
        poor = current.misfit > DISTORTED_MISFIT
        if poor or not stretched:  # else tolerances hide what there is to reach
            bases = [base] if base.effects or not poor else [base, self.nominal]
            candidates = within_reach(candidates, bases, predictor, LEAST_REACH, REACH_SHARE)
            base = bases[-1]
        columns = tolerance_columns(base, predictor, weighting)
        projection = Projection.of(base, predictor, weighting, columns)
        return screen(candidates, [projection], predictor, weighting)

    def _refine(self, current: Fit, trials: Sequence[Trial]) -> list[Candidate]:
        if not trials:
            return []
        shared = tolerance_columns(trials[0].base, self.coarse, self.coarse_weighting)
        held = self.coarse.hold(trials[0].base.setup()).held
        rough: list[Fit] = []
        for trial in trials[: AFTER_TORQUES if held else None]:
            slow = trial.effect.amplitude_dependent
            done = min((item.misfit for item in rough), default=np.inf) < SETTLED_MISFIT
            if slow and done and trial.gain < SETTLED_SHARE * trials[0].gain:
                continue
            rough.append(
                fit(
                    replace(trial.base, held=held).with_effect(trial.effect, trial.values),
                    self.coarse,
                    self.coarse_weighting,
                    columns=shared,
                    iterations=4 if slow else 6,
                    relinearise=1 if len(trial.values) <= FEW_PARAMETERS else 3,
                )
            )
        rough.sort(key=lambda item: -item.log_evidence)
        close = [item for item in rough if item.log_evidence > rough[0].log_evidence - HOPELESS]
        found = []
        for item in close[:REFINED]:
            slow = any(effect.amplitude_dependent for effect in item.hypothesis.effects)
            fine = fit(
                replace(item.hypothesis, held=()),
                self.fitting,
                self.weighting,
                iterations=3 if slow else 5,
                relinearise=0,
            )
            found.append(self._candidate(fine.hypothesis.effects[-1], fine, current))
        return found


def _stretched(hypothesis: Hypothesis) -> float:
    return float(np.abs(hypothesis.tolerance_values).max(initial=0.0))


def chosen(trials: Sequence[Trial]) -> list[Trial]:
    """Return the trials worth a refined fit: the best, not too many of one type."""
    found: list[Trial] = []
    for trial in trials:
        same = sum(item.effect.type == trial.effect.type for item in found)
        promising = trial.gain > max(1.0, LEAST_PROMISE * trials[0].gain)
        if same < ROUGH_PER_TYPE and promising:
            found.append(trial)
        if len(found) == ROUGH:
            break
    return found


def shortened(record: GapRecord, seconds: float) -> GapRecord:
    """Return the beginning of a record."""
    count = min(len(record.acceleration), round(seconds * record.sample_rate_hz))
    return replace(
        record,
        acceleration=record.acceleration[:count],
        motor_acceleration=record.motor_acceleration[:count],
        motor_velocity=record.motor_velocity[:count],
        motor_shift=record.motor_shift[:count],
    )


def of_first_poses(records: Sequence[GapRecord], count: int) -> list[GapRecord]:
    """Return the records of the first few poses, all their levels."""
    poses: list[np.ndarray] = []
    found = []
    for record in records:
        known = any(np.abs(pose - record.pose).max() < SAME_POSE_RAD for pose in poses)
        if not known and len(poses) < count:
            poses.append(record.pose)
            known = True
        if known:
            found.append(record)
    return found


def moving_links(model: FlexibleJointModel) -> tuple[str, ...]:
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
