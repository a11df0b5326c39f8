"""Samples of many sensors on one grid: the way in.

In come measurements as they arrive (samples with stamps, blocks with counters, joint states);
out go windows on one uniform grid, each with the health of every channel. The time that most
samples agree with leads; memory is bounded by what a window needs.
"""

from oma_identifier.intake.sample_buffer import SampleBuffer
from oma_identifier.intake.topic_intake import in_order, TopicIntake

__all__ = ['SampleBuffer', 'TopicIntake', 'in_order']
