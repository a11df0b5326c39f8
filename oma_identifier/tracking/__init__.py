"""Modes that keep their ids from window to window.

In come the modes of one window after the other; out go the same modes with ids that follow
frequency, shape and pose, and a memory that outlives a restart.
"""

from oma_identifier.tracking.checkpoint_file import CheckpointFile
from oma_identifier.tracking.prediction import PredictedMode, Prediction, Predictions
from oma_identifier.tracking.thresholds import TRACKING
from oma_identifier.tracking.track import relative_std
from oma_identifier.tracking.tracking import ModeTracker, TrackedModes

__all__ = [
    'TRACKING',
    'CheckpointFile',
    'ModeTracker',
    'PredictedMode',
    'Prediction',
    'Predictions',
    'TrackedModes',
    'relative_std',
]
