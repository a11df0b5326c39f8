"""The records of a campaign, transformed: all of them, and fewer, shorter and coarser ones.

The way to an explanation is sought on little data, the verdict is found on all.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from model_gap.campaign import Band, CAMPAIGN, GapRecord, record_spectra
from model_gap.cell import CellModel
from model_gap.predict import linearised, PREDICTION, Predictor
from structural_model import FlexibleJointModel


@dataclass(frozen=True, slots=True)
class DataSizes:
    """How much of the records each stage sees.

    Parameters
    ----------
    screen_bins, least_bins : int
        Of a short record; at least so many.
    many_channels : int
        More channels say the same with fewer bins.
    screen_poses : int
        Of the screening.
    screen_s : float [s]
        Length of a short record.
    """

    screen_bins: int = 90
    least_bins: int = 60
    many_channels: int = 15
    screen_poses: int = 3
    screen_s: float = 12.0


SIZES = DataSizes()


@dataclass(frozen=True)
class SearchData:
    """A predictor of every set of records.

    Parameters
    ----------
    fitting, heldout : Predictor
        Every record, on all bins.
    coarse : Predictor
        The beginning of every fitting record, on few bins.
    screening : Predictor
        Of these a few poses.
    loudest : Predictor
        Of these the loudest level.
    """

    fitting: Predictor
    heldout: Predictor
    coarse: Predictor
    screening: Predictor
    loudest: Predictor


def prepare_data(
    records: Sequence[GapRecord],
    model: FlexibleJointModel,
    band: Band,
    lines_hz: Sequence[float],
    about: CellModel | None,
) -> SearchData:
    """Make records linear about an arm, and transform them.

    Parameters
    ----------
    records : sequence of GapRecord
        All of a campaign.
    model : FlexibleJointModel
        Nominal arm.
    band : Band
        What is compared.
    lines_hz : sequence of float [Hz]
        Hums, kept out of the bins.
    about : CellModel or None
        The arm whose second-order motion is taken out; None for records of a simulation that is
        linear about the motors' angles.
    """

    def predictor(
        chosen: Sequence[GapRecord],
        bins: int = CAMPAIGN.target_bins,
        steps_per_s: float = PREDICTION.steps_per_s,
        screening: bool = False,
    ) -> Predictor:
        n_channels = chosen[0].acceleration.shape[1] if chosen else 0
        # Many channels say the same with fewer bins.
        bins = max(
            SIZES.least_bins, round(bins * min(1.0, SIZES.many_channels / max(n_channels, 1)))
        )
        spectra = [record_spectra(item, band, bins, tuple(lines_hz)) for item in chosen]
        return Predictor(model, spectra, steps_per_s, about is not None, screening)

    roughly = partial(predictor, bins=SIZES.screen_bins, steps_per_s=PREDICTION.rough_steps_per_s)
    if about is not None:
        records = linearised(records, model, about, band.high_hz)
    fitting = [item for item in records if not item.heldout]
    short = [shortened(item, SIZES.screen_s) for item in fitting]
    few = of_first_poses(short, SIZES.screen_poses)
    return SearchData(
        fitting=predictor(fitting),
        heldout=predictor([item for item in records if item.heldout]),
        coarse=roughly(short),
        screening=roughly(few, screening=True),
        loudest=roughly(loudest(few), screening=True),
    )


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
        known = any(np.abs(pose - record.pose).max() < PREDICTION.same_pose_rad for pose in poses)
        if not known and len(poses) < count:
            poses.append(record.pose)
            known = True
        if known:
            found.append(record)
    return found
