"""Campaigns of motor and link encoders with torques: what moves an arm, what twists its gears.

In come a model with gears and recordings; out go the laws it lacks (friction, counterbalance,
payload, springs, delays) with their uncertainty, each judged by recordings that took no part.
"""

from model_gap.trajectory.as_json import encoder_gap_mapping
from model_gap.trajectory.campaign import (
    EncoderCampaign,
    is_encoder_campaign,
    read_encoder_campaign,
)
from model_gap.trajectory.corrected import corrected_model
from model_gap.trajectory.encoder_gap import EncoderGap, gap_share
from model_gap.trajectory.find_encoder_gap import find_encoder_gap
from model_gap.trajectory.folder import EncoderFolder
from model_gap.trajectory.recording import EncoderRecording, read_encoder_recording
from model_gap.trajectory.words import summary_lines

__all__ = [
    'EncoderCampaign',
    'EncoderFolder',
    'EncoderGap',
    'EncoderRecording',
    'corrected_model',
    'encoder_gap_mapping',
    'find_encoder_gap',
    'gap_share',
    'is_encoder_campaign',
    'read_encoder_campaign',
    'read_encoder_recording',
    'summary_lines',
]
