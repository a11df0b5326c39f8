"""The modes of a recording, identified by the same pipeline as everywhere else."""

from dataclasses import replace

import numpy as np

from modal_core.channel import SensorLayout
from modal_core.errors import IdentificationError
from modal_core.measurements import JointSamples, NANOSECONDS_PER_SECOND, SampleBlock
from modal_core.mode import ModeSet
from model_gap.campaign import GapRecord
from model_gap.comparison.thresholds import LIMITS
from oma_identifier.pipeline import IdentificationPipeline
from oma_identifier.settings import IdentificationSettings
from structural_model import FlexibleJointModel


def identified_modes(
    record: GapRecord, model: FlexibleJointModel, layout: SensorLayout, highest_hz: float
) -> ModeSet:
    """Return the modes of a recording; the rigid motion of the sensors is taken out by the model.

    Parameters
    ----------
    record : GapRecord
        Accelerations and the motion of the joints.
    model : FlexibleJointModel
        For the rigid motion only.
    layout : SensorLayout
        The sensors.
    highest_hz : float [Hz]
        Up to where the arm was excited.

    Returns
    -------
    ModeSet
        Of the channels the pipeline uses; empty when nothing can be identified.
    """
    rate, count = record.sample_rate_hz, len(record.acceleration)
    settings = IdentificationSettings(
        window_s=count / rate,
        min_frequency_hz=LIMITS.lowest_hz,
        max_frequency_hz=min(highest_hz, LIMITS.highest_hz),
    )
    names = tuple(layout.channels[column].name for column in record.recorded)
    pipeline = IdentificationPipeline(settings, layout.only(names), robot=model)
    stamps = np.rint(np.arange(count) / rate * NANOSECONDS_PER_SECOND).astype(np.int64)
    size = max(1, round(rate / 4.0))
    found = ModeSet((), names)
    for first in range(0, count, size):
        rows = slice(first, first + size)
        pipeline.add(
            JointSamples(
                stamps[rows],
                model.joint_names,
                record.pose + record.motor_shift[rows],
                record.motor_velocity[rows],
            )
        )
        block = np.asarray(record.acceleration[rows, record.recorded], dtype=np.float32)
        pipeline.add(SampleBlock('campaign', int(stamps[first]), first, rate, names, block))
    try:
        for window in (*pipeline.windows(), *pipeline.finish()):
            found = max(found, pipeline.identify(window).modes, key=len)
    except IdentificationError:
        return ModeSet((), names)
    return replace(found, modes=tuple(mode for mode in found if not mode.harmonic))
