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
from model_gap.linearised import linearised
from model_gap.lines import common_lines, lines_left
from model_gap.neighbours import neighbours
from model_gap.nuisance import nuisances, Tolerances
from model_gap.predict import Predictor, SAME_POSE_RAD
from model_gap.race import race
from model_gap.reach import within_reach
from model_gap.screen import Projection, screen, Trial
from model_gap.setup import Setup
from model_gap.spectra import Band, record_spectra, TARGET_BINS
from model_gap.stretched import stretch, STRETCHED, unknown_masses
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
ROUGH_PER_TYPE = 4
ROUGH_PER_PLACE = 2
# As many beside an accepted torque law, where a fit takes longer.
AFTER_TORQUES = 4
REFINED = 4
# Rough fits this far behind the best are not refined.
HOPELESS = 200.0
# Once a rough fit is this good, torque laws that promised less than this share are not tried.
SETTLED_MISFIT = 1.5
SETTLED_SHARE = 0.5
# Nor is what promised less than this share of the best in the screening.
LEAST_PROMISE = 0.06
# Nothing is refined when the best promises less than this share of what is worth adding.
PROMISE = 0.5
FURTHER_PROMISE = 1.0
# Of what is left over, a further effect must take away this share.
FURTHER_SHARE = 0.3
# Below this misfit a linear trial says enough; nor is more needed where one promises such a share
# of what there is to gain.
OPEN_MISFIT = 1.1
CLOSED_SHARE = 0.8
# Details are looked into of candidates this close to the best.
DETAILED = 100.0
# A misfit this large means that the fit without an effect is distorted: candidates are then tried
# on the nominal model.
DISTORTED_MISFIT = 4.0
# Of a misfit so small not all is resonance: hums stand out of it.
NEAR_MISFIT = 30.0
# Tolerances alone go far where an effect is missing: a fit that stopped short misleads.
FIRST_LINEARISATIONS = 3
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
    simulated : bool or None
        The recordings are of a simulation linear about the motors' angles; None: not yet known.
    """

    model: FlexibleJointModel
    campaign: Campaign
    settings: SearchSettings = field(default_factory=SearchSettings)
    progress: Callable[[float], None] = lambda _: None
    steps: list[Step] = field(default_factory=list)
    simulated: bool | None = None

    def __post_init__(self) -> None:
        """Transform the records."""
        setup = Setup(explicit_damping(self.model.spec), self.campaign.layout.channels)
        names = tuple(sensor.name for sensor in self.campaign.layout)
        self._n_channels = len(setup.channels)
        lines = common_lines(self.campaign.records, self.settings.band)
        setup = with_known_effects(Scene(self.model, names, setup, lines))
        self.scene = Scene(self.model, names, setup, lines)
        self.tolerances = nuisances(setup, moving_links(self.model), self.settings.tolerances)
        self._prepare(setup)

    def _prepare(self, about: Setup) -> None:
        """Make records linear about an arm, and transform them."""
        fitting = self._records(about, heldout=False)
        heldout = self._records(about, heldout=True)
        self.fitting = self._predictor(fitting)
        self.heldout = self._predictor(heldout)
        short = [shortened(record, SCREEN_S) for record in fitting]
        self.coarse = self._predictor(short, SCREEN_BINS, COARSE_STEPS)
        few = of_first_poses(short, SCREEN_POSES)
        self.screening = self._predictor(few, SCREEN_BINS, COARSE_STEPS)
        self.racing = self._predictor(loudest(few), SCREEN_BINS, COARSE_STEPS)
        self.weighting = Weighting.of(self.fitting)
        self.heldout_weighting = Weighting.of(self.heldout) if heldout else None
        self.coarse_weighting = Weighting.of(self.coarse)
        self.screening_weighting = Weighting.of(self.screening)
        self.racing_weighting = Weighting.of(self.racing)

    def _records(self, about: Setup, *, heldout: bool) -> list[GapRecord]:
        records = [item for item in self.campaign.records if bool(item.heldout) == heldout]
        high_hz = self.settings.band.high_hz
        return records if self.simulated else linearised(records, self.model, about, high_hz)

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
        return Predictor(self.model, spectra, steps_per_s, hanging=not self.simulated)

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
        if self.heldout_weighting is None:
            return float('nan')
        rows = self.heldout_weighting.rows(self.heldout.predict(hypothesis.setup()))
        return misfit(self.heldout_weighting, rows)

    def run(self) -> list[Step]:
        """Search until nothing more is worth adding."""
        first = fit(self.nominal, self.fitting, self.weighting, relinearise=FIRST_LINEARISATIONS)
        current = self._followed(first)
        for number in range(self.settings.most_effects):
            step = self._settled(self._step(current))
            self.steps.append(step)
            self.progress((number + 1.0) / (self.settings.most_effects + 1.0))
            if not self._earns_place(step):
                break
            current = step.candidates[0].fit
            if self._room_left(current) < self.settings.worth_adding:
                break
        self.progress(1.0)
        return self.steps

    def _settled(self, step: Step) -> Step:
        """Fit the best candidate to the end; drop earlier effects that no longer earn a place."""
        if not self._earns_place(step):
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
        gain = last.log_evidence - step.before.log_evidence
        last = self._followed(last)
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
        undecided, self.simulated = self.simulated is None, False
        self._prepare(fitted.hypothesis.setup())
        found = fit(fitted.hypothesis, self.fitting, self.weighting, iterations=4)
        if undecided:
            self.simulated = True
            linear = self._predictor(self._records(self.scene.setup, heldout=False))
            start = fitted.hypothesis
            other = fit(start, linear, Weighting.of(linear), iterations=4)
            clear = min(other.misfit, found.misfit) < SETTLED_MISFIT
            self.simulated = False if clear else None
            if clear and other.log_evidence > found.log_evidence + LINEAR_LEAD:
                self.simulated = True
                self._prepare(self.scene.setup)
                return other
        return found

    def _candidate(self, effect: Effect, fitted: Fit, before: Fit) -> Candidate:
        gain = fitted.log_evidence - before.log_evidence
        return Candidate(effect, fitted, gain, self.heldout_misfit(fitted.hypothesis))

    def _earns_place(self, step: Step) -> bool:
        least = max(self.settings.worth_adding, share_to_add(step.before))
        return bool(step.candidates) and step.candidates[0].gain >= least

    def _room_left(self, current: Fit) -> float:
        """Return what one more effect could gain at best: down to the noise, at no prior cost."""
        values = current.hypothesis.tolerance_values
        return open_gap(current) + float(0.5 * values @ values)

    def _with_lines(self, current: Fit) -> Fit:
        """Look for hums in what is left over, once the model is not far off."""
        if current.misfit > NEAR_MISFIT:
            return current
        known = self.scene.lines_hz
        lines = lines_left(self.fitting, current.hypothesis, self.settings.band, known)
        if lines == known:
            return current
        self.scene = replace(self.scene, lines_hz=lines)
        self._prepare(current.hypothesis.setup())
        hypothesis = replace(current.hypothesis, scene=self.scene)
        return fit(hypothesis, self.fitting, self.weighting, relinearise=0)

    def _step(self, current: Fit) -> Step:
        current = self._with_lines(current)
        candidates = [
            effect
            for kind in self.settings.catalogue
            for effect in kind.instances(self.scene)
            if not any(same(effect, item) for item in current.hypothesis.effects)
        ]
        trials = self._screen(current, candidates)
        share = FURTHER_PROMISE if current.hypothesis.effects else PROMISE
        stretched = stretch(current.hypothesis) > STRETCHED
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
        stretched = stretch(base) > STRETCHED
        poor = current.misfit > DISTORTED_MISFIT
        if poor or not stretched:  # else tolerances hide what there is to reach
            bases = [base] if base.effects or not poor else [base, self.nominal]
            candidates = within_reach(candidates, bases, predictor, LEAST_REACH, REACH_SHARE)
            base = bases[-1]
        columns = tolerance_columns(base, predictor, weighting)
        projection = Projection.of(base, predictor, weighting, columns)
        trials = screen(candidates, [projection], predictor, weighting)
        if self._is_open(current, trials):
            trials = race(trials, current.hypothesis, self.racing, self.racing_weighting)
        return trials

    def _is_open(self, current: Fit, trials: Sequence[Trial]) -> bool:
        """Return whether there is a gap that no trial of the screening promises to close."""
        stretched = stretch(current.hypothesis) > STRETCHED
        closed = bool(trials) and trials[0].gain > CLOSED_SHARE * open_gap(current)
        return stretched or (current.misfit > OPEN_MISFIT and not closed)

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
            others = trial.effect.other_starts(trial.values) if trial is trials[0] else ()
            for values in dict.fromkeys((trial.values, *others)):
                rough.append(
                    fit(
                        replace(trial.base, held=held).with_effect(trial.effect, values),
                        self.coarse,
                        self.coarse_weighting,
                        columns=shared,
                        iterations=4 if slow else 6,
                        relinearise=1 if slow else 3,
                    )
                )
        rough += [
            fit(replace(start, held=held), self.coarse, self.coarse_weighting, relinearise=3)
            for start in unknown_masses(current.hypothesis)
        ]
        rough = best_of_each(rough)
        close = [item for item in rough if item.log_evidence > rough[0].log_evidence - HOPELESS]
        close = close[:REFINED]
        if close[0].misfit > SETTLED_MISFIT:
            close = with_details(close, self.coarse, self.coarse_weighting)
        if current.misfit > DISTORTED_MISFIT and not self.simulated:
            self._prepare(replace(close[0].hypothesis, held=()).setup())
        found = []
        for item in close:
            slow = any(effect.amplitude_dependent for effect in item.hypothesis.effects)
            fine = fit(
                replace(item.hypothesis, held=()),
                self.fitting,
                self.weighting,
                iterations=3 if slow else 5,
                relinearise=0,
            )
            found.append(fine)
        best = max(item.log_evidence for item in found)
        near = [item for item in found if item.log_evidence > best - DETAILED]
        rest = [item for item in found if item.log_evidence <= best - DETAILED]
        near = with_details(near, self.fitting, self.weighting)
        near += self._next_door(near, [item.hypothesis.effects[-1].key for item in found])
        return [
            self._candidate(item.hypothesis.effects[-1], item, current) for item in (*near, *rest)
        ]

    def _next_door(self, near: Sequence[Fit], tried: Sequence[tuple[str, str]]) -> list[Fit]:
        """Fit the best effect of a link on the links beside it as well."""
        best = max(near, key=lambda item: item.log_evidence).hypothesis
        moved = neighbours(best, tried, self.coarse, self.coarse_weighting)
        fine = [fit(item, self.fitting, self.weighting, iterations=5) for item in moved]
        return with_details(fine, self.fitting, self.weighting)


def open_gap(fitted: Fit) -> float:
    """Return the log evidence that bringing what is left over down to the noise would gain."""
    return EFFECTIVE_DATA * float(np.log(max(fitted.misfit, 1.0)))


def share_to_add(before: Fit) -> float:
    """Return what a further effect must gain: a part of what the ones before left over.

    One that takes away a tenth fits what a law of the first describes only roughly.
    """
    if not before.hypothesis.effects:
        return 0.0
    return FURTHER_SHARE * open_gap(before)


def with_details(found: Sequence[Fit], predictor: Predictor, weighting: Weighting) -> list[Fit]:
    """Return each fit with its last effect's details free, where it has any.

    No one knows them: values, deviations and evidence must contain that.
    """
    kept = []
    for item in found:
        start = item.hypothesis.with_details()
        if start is not None:
            item = fit(start, predictor, weighting, iterations=5, relinearise=2)
        kept.append(item)
    return kept


def chosen(trials: Sequence[Trial]) -> list[Trial]:
    """Return the trials worth a refined fit: the best, not too many of one type and place."""
    found: list[Trial] = []
    for trial in trials:
        alike = sum(item.effect.type == trial.effect.type for item in found)
        here = sum(item.effect.key == trial.effect.key for item in found)
        promising = trial.gain > max(1.0, LEAST_PROMISE * trials[0].gain)
        if alike < ROUGH_PER_TYPE and here < ROUGH_PER_PLACE and promising:
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


def same(one: Effect, other: Effect) -> bool:
    """Return whether two effects are one and the same, whatever details are free."""
    return (one.key, one.variant) == (other.key, other.variant)


def best_of_each(fits: Sequence[Fit]) -> list[Fit]:
    """Return the best fit of every effect, the best first: several starts may have met."""
    found: list[Fit] = []
    for item in sorted(fits, key=lambda item: -item.log_evidence):
        last = item.hypothesis.effects[-1]
        if not any(same(last, other.hypothesis.effects[-1]) for other in found):
            found.append(item)
    return found


def loudest(records: Sequence[GapRecord]) -> list[GapRecord]:
    """Return the records of the level with the largest motion."""
    size = {item.level: 0.0 for item in records}
    for item in records:
        size[item.level] = max(size[item.level], float(item.motor_acceleration.std()))
    level = max(size, key=lambda name: size[name])
    return [item for item in records if item.level == level]


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
