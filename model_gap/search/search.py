"""State of a search: data, what stands so far, and the rounds behind it.

Nothing here starts a fit, and nothing changes: each step takes a state and returns another.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
import logging

import numpy as np
from numpy.typing import NDArray

from model_gap.campaign import Band, Campaign, explicit_damping
from model_gap.cell import CellModel, joint_vector, Nuisance, nuisances, Tolerances
from model_gap.effects import CATALOGUE, Effect, Scene
from model_gap.fit import FIT, Fit
from model_gap.hypothesis import DOUBTFUL, Hypothesis, stretch, STRETCHED, with_known_effects
from model_gap.predict import static_twist
from model_gap.search.evidence_bound import least_further_gain
from model_gap.search.lines import common_lines
from model_gap.search.screen import Trial
from model_gap.search.search_data import prepare_data, SearchData
from structural_model import FlexibleJointModel

log = logging.getLogger(__name__)


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

    def earns_place(self, worth_adding: float) -> bool:
        """Return whether the best candidate gains enough to be believed."""
        least = max(worth_adding, least_further_gain(self.before))
        return bool(self.candidates) and self.candidates[0].gain >= least


@dataclass(frozen=True)
class RivalPair:
    """Two explanations that the evidence does not tell apart.

    Parameters
    ----------
    accepted, rival : Candidate
        That which was accepted, and the other; both beside all else that was found.
    """

    accepted: Candidate
    rival: Candidate


@dataclass(frozen=True, eq=False)
class Search:
    """Where a search stands.

    Parameters
    ----------
    model : FlexibleJointModel
        Nominal arm.
    campaign : Campaign
        Every record marked as held out or not.
    settings : SearchSettings
        How.
    scene : Scene
        Nominal cell, and the lines and orders seen so far.
    tolerances : tuple of Nuisance
        What is known of the nominal cell only roughly.
    data : SearchData
        The records, transformed about what was found so far.
    simulated : bool or None
        The recordings are of a simulation linear about the motors' angles; None: not yet known.
    roughly_known : (n_tolerances,) array or None
        Tolerances with what is known only roughly as the recordings tell it, all others nominal.
    doubted : bool
        Recordings that took no part contradicted what tolerances alone explained.
    current : Fit or None
        What the next effect is added to; None before the first fit.
    trials : tuple of Trial
        Of this round, best first.
    fits : tuple of Fit
        Of this round, best first.
    rounds : tuple of Round
        Those that are done.
    finished : bool
        Nothing more is worth adding.
    accepted : tuple of Candidate
        What held-out records confirm, in the order it was found.
    rivals : tuple of RivalPair
        What the accepted effects cannot be told from.
    """

    model: FlexibleJointModel
    campaign: Campaign
    settings: SearchSettings
    scene: Scene
    tolerances: tuple[Nuisance, ...]
    data: SearchData
    simulated: bool | None = None
    roughly_known: NDArray[np.float64] | None = None
    doubted: bool = False
    current: Fit | None = None
    trials: tuple[Trial, ...] = ()
    fits: tuple[Fit, ...] = ()
    rounds: tuple[Round, ...] = ()
    finished: bool = False
    accepted: tuple[Candidate, ...] = ()
    rivals: tuple[RivalPair, ...] = ()

    @classmethod
    def begin(
        cls,
        model: FlexibleJointModel,
        campaign: Campaign,
        settings: SearchSettings | None = None,
        simulated: bool | None = None,
    ) -> 'Search':
        """Transform the records; nothing is fitted yet."""
        settings = settings or SearchSettings()
        cell = CellModel(explicit_damping(model.spec), campaign.layout.channels)
        names = tuple(sensor.name for sensor in campaign.layout)
        lines = common_lines(campaign.records, settings.band)
        scene = Scene(model, names, cell, lines, preload_rad=preloads(model, campaign))
        cell = with_known_effects(scene, settings.catalogue)
        return cls(
            model,
            campaign,
            settings,
            replace(scene, cell=cell),
            nuisances(cell, links_with_mass(model), settings.tolerances),
            prepare_data(
                campaign.records, model, settings.band, lines, None if simulated else cell
            ),
            simulated,
        )

    def with_data_about(self, about: CellModel | None) -> 'Search':
        """Return it with the records of a cell, or (None) of a linear simulation."""
        lines, band = self.scene.lines_hz, self.settings.band
        about = None if self.simulated else about
        data = prepare_data(self.campaign.records, self.model, band, lines, about)
        return replace(self, data=data)

    def with_best(self, best: Candidate) -> 'Search':
        """Return it with another best candidate of the last round."""
        last = self.rounds[-1]
        last = replace(last, candidates=(best, *last.candidates[1:]))
        return replace(self, rounds=(*self.rounds[:-1], last))

    @property
    def fitted(self) -> Fit:
        """What the next effect is added to.

        Raises
        ------
        ValueError
            Nothing was fitted yet.
        """
        if self.current is None:
            raise ValueError('no fit yet: the search has not begun')
        return self.current

    @property
    def nominal(self) -> Hypothesis:
        """The model as it was given."""
        return Hypothesis(
            self.scene, self.tolerances, (), np.zeros(len(self.tolerances)), np.zeros(0)
        )

    @property
    def stretched_from(self) -> float:
        """Deviations from which on a tolerance may stand for an effect."""
        return DOUBTFUL if self.doubted else STRETCHED

    @property
    def stretched(self) -> bool:
        """Whether a tolerance may stand for an effect."""
        return stretch(self.fitted.hypothesis) > self.stretched_from

    @property
    def unstretched(self) -> Hypothesis:
        """The model as it was given, but for what is known only roughly."""
        if self.roughly_known is None:
            return self.nominal
        return replace(self.nominal, tolerance_values=self.roughly_known)

    @property
    def relaxed(self) -> Hypothesis:
        """What was found so far, its tolerances as they were before any fit: they hide nothing."""
        unstretched = self.unstretched.tolerance_values
        return replace(self.fitted.hypothesis, tolerance_values=unstretched)

    @property
    def usual_tolerances(self) -> tuple[Nuisance, ...]:
        """What its tolerances would be were nothing stated."""
        return nuisances(self.scene.cell, links_with_mass(self.model), Tolerances())

    @property
    def rough_places(self) -> tuple[int, ...]:
        """Which tolerances are wider than usual; a gain acts linearly, however wide it is."""
        usual = {item.name: item.sigma for item in self.usual_tolerances}
        return tuple(
            number
            for number, item in enumerate(self.tolerances)
            if item.kind != 'gain' and item.sigma > usual.get(item.name, item.sigma)
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

    def candidate(self, fitted: Fit, before: Fit) -> Candidate:
        """Return a fit as a candidate: its last effect, and its gain over a fit without it."""
        effect, gain = fitted.hypothesis.effects[-1], self.gain(fitted, before)
        return Candidate(effect, fitted, gain, self.heldout_misfit(fitted.hypothesis))

    def gain(self, fitted: Fit, before: Fit) -> float:
        """Return by how much evidence a fit exceeds one without its last effect.

        Less what the fit without it would gain too, were it excused as the other one is.
        """
        gain = fitted.log_evidence - before.log_evidence
        law = fitted.hypothesis.cell()
        if not law.forces:
            return gain
        excused = self.data.fitting.excused_misfit(before.hypothesis.cell(), law)
        doubt = FIT.effective_data * max(float(np.log(before.misfit / excused)), 0.0)
        if doubt > 1.0:
            log.debug('%r: %.3g of %.3g is its doubt', fitted.hypothesis.effects[-1], doubt, gain)
        return gain - doubt

    def candidates(self, fits: Sequence[Fit]) -> tuple[Candidate, ...]:
        """Return this round's fits as candidates, the best first."""
        found = [self.candidate(item, self.fitted) for item in fits]
        return tuple(sorted(found, key=lambda item: -item.gain))


def preloads(model: FlexibleJointModel, campaign: Campaign) -> dict[str, float]:
    """Return the most that gravity twists each joint in the poses of a campaign [rad]."""
    bare = Scene(model, (), CellModel(model.spec, ()))
    vectors = {place: joint_vector(model, place, model.dof_names) for place in bare.joint_marks}
    poses = np.unique([record.pose for record in campaign.records], axis=0)
    return {
        place: max(abs(static_twist(model, vector, pose)) for pose in poses)
        for place, vector in vectors.items()
    }


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
