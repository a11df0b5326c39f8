"""Which next recording would tell two explanations apart: the one they predict most differently.

References
----------
Hunter and Reiner (1965), doi:10.1080/00401706.1965.10490265: the experiment with the largest
difference between the predictions of two fitted rivals.
"""

from collections.abc import Sequence
import dataclasses
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from modal_core.errors import ModelError
from model_gap.campaign import RecordSpectra
from model_gap.cell import CellModel
from model_gap.effects import arm_mass
from model_gap.hypothesis import Hypothesis
from model_gap.predict import Predictor
from structural_model.description import MassSpec

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class ExperimentRange:
    """Which recordings are considered.

    Parameters
    ----------
    poses : int
        Drawn at random.
    inside : float
        Share of the joints' ranges that they are drawn from.
    level_factors : tuple of float
        Motion over that of the loudest record.
    steady_rad_s : float [rad/s]
        Slow motion underneath.
    payload_share : float
        Known mass over that of the arm.
    """

    poses: int = 16
    inside: float = 0.8
    level_factors: tuple[float, ...] = (0.5, 2.0)
    steady_rad_s: float = 0.1
    payload_share: float = 0.03


RANGE = ExperimentRange()


@dataclass(frozen=True)
class Experiment:
    """A recording that could be made.

    Parameters
    ----------
    words : str
        What to do.
    separation : float
        Root mean square difference of the two predictions, in standard deviations of the noise.
    """

    words: str
    separation: float


def experiments_between(
    one: Hypothesis, other: Hypothesis, predictor: Predictor, rng: np.random.Generator
) -> tuple[Experiment, ...]:
    """Return possible recordings, the one that separates two hypotheses best first.

    Parameters
    ----------
    one, other : Hypothesis
        Fitted.
    predictor : Predictor
        Of the campaign: its loudest record is repeated elsewhere, louder or softer, with a known
        mass at the flange, or in slow steady motion.
    rng : numpy.random.Generator
        For the poses.
    """
    loudest = max(predictor.records, key=lambda item: float(np.abs(item.motor_acceleration).sum()))
    asked = _asked(predictor, loudest, rng)
    found = _separations([record for _, record in asked], one, other, predictor)
    mass = round(RANGE.payload_share * arm_mass(one.scene), 1)
    loaded = _separations([loudest], one, other, predictor, mass)
    words = [text for text, _ in asked] + [f'the same poses with {mass:g} kg at the flange']
    listed = [Experiment(*item) for item in zip(words, found + loaded, strict=True)]
    return tuple(sorted(listed, key=lambda item: -item.separation))


def separation_now(one: Hypothesis, other: Hypothesis, predictor: Predictor) -> float:
    """Return how far apart the two are on the records there are, in the same measure."""
    return float(np.sqrt(np.mean(np.square(_differences(predictor, one, other, 0.0)))))


def _asked(
    predictor: Predictor, loudest: RecordSpectra, rng: np.random.Generator
) -> list[tuple[str, RecordSpectra]]:
    record = loudest.record
    limits = predictor.model.limits
    middle = (limits.position_high + limits.position_low) / 2.0
    half = RANGE.inside * (limits.position_high - limits.position_low) / 2.0
    asked = []
    for _ in range(RANGE.poses):
        pose = middle + half * rng.uniform(-1.0, 1.0, len(middle))
        if limits.position_violation(pose) is None:
            there = dataclasses.replace(record, pose=pose)
            words = f'serial joints at {predictor.model.joints_words(pose)}'
            asked.append((words, dataclasses.replace(loudest, record=there)))
    for factor in RANGE.level_factors:
        asked.append(
            (f'the same poses, motion {factor:g} times as large', scaled_motion(loudest, factor))
        )
    moving = dataclasses.replace(record, motor_velocity=record.motor_velocity + RANGE.steady_rad_s)
    words = (
        f'the same motion on top of {RANGE.steady_rad_s:g} rad/s of steady motion of the joints'
    )
    asked.append((words, dataclasses.replace(loudest, record=moving)))
    return asked


def scaled_motion(item: RecordSpectra, factor: float) -> RecordSpectra:
    """Return a record whose motion is so many times as large."""
    record = dataclasses.replace(
        item.record,
        motor_acceleration=factor * item.record.motor_acceleration,
        motor_velocity=factor * item.record.motor_velocity,
        motor_shift=factor * item.record.motor_shift,
    )
    return dataclasses.replace(
        item,
        record=record,
        motor_acceleration=factor * item.motor_acceleration,
        motor_shift=factor * item.motor_shift,
        tail=factor * item.tail,
    )


def _separations(
    records: Sequence[RecordSpectra],
    one: Hypothesis,
    other: Hypothesis,
    like: Predictor,
    mass_kg: float = 0.0,
) -> list[float]:
    predictor = dataclasses.replace(like, records=records)
    try:
        return _differences(predictor, one, other, mass_kg)
    except ModelError:
        return [0.0] * len(records)


def _differences(
    predictor: Predictor, one: Hypothesis, other: Hypothesis, mass_kg: float
) -> list[float]:
    first, second = (predictor.predict(_loaded(item, mass_kg)) for item in (one, other))
    return [
        float(np.sqrt(np.mean(item.squares(a - b)[item.seen])))
        for item, a, b in zip(predictor.records, first, second, strict=True)
    ]


def _loaded(hypothesis: Hypothesis, mass_kg: float) -> CellModel:
    cell = hypothesis.cell()
    if mass_kg == 0.0:
        return cell
    item = MassSpec('known_mass', hypothesis.scene.model.link_names[-1], mass_kg, (0.0, 0.0, 0.0))
    return cell.with_spec(dataclasses.replace(cell.spec, masses=(*cell.spec.masses, item)))
