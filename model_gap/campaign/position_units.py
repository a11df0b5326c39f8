"""Whether joint positions are in the units that robots tell them in."""

import numpy as np
from numpy.typing import NDArray

from modal_core.errors import RecordingError
from model_gap.campaign.thresholds import CAMPAIGN
from structural_model import FlexibleJointModel

Array = NDArray[np.float64]


def check_position_units(pose: Array, model: FlexibleJointModel, where: str) -> None:
    """Refuse angles in degrees and ways in millimetres.

    Parameters
    ----------
    pose : (n_joints,) array [rad], [m]
        Mean of a recording, as it says.
    model : FlexibleJointModel
        With the ranges of its joints.
    where : str
        For the message.

    Raises
    ------
    RecordingError
        A joint stands where none can; the message says what its unit may be.
    """
    low, high = model.limits.position_low, model.limits.position_high
    farthest = np.maximum(np.abs(low), np.abs(high))
    turn = 2.0 * np.pi
    sliding = np.array(model.sliding)
    most = np.where(
        sliding,
        (1.0 + CAMPAIGN.full_travels) * np.minimum(farthest, CAMPAIGN.longest_travel_m),
        np.minimum(farthest, turn) + CAMPAIGN.full_turns * turn,
    )
    out = np.abs(pose) > most
    if not out.any():
        return
    other = np.where(sliding, 1e-3 * pose, np.deg2rad(pose))
    # Recordings may go beyond the ranges of a model a little.
    looks = np.all(np.abs(other[out]) <= 1.1 * farthest[out])
    kinds = [
        ('degrees', 'radians', 'angles in radians (degrees times 0.017453)', ~sliding),
        ('millimetres', 'metres', 'ways in metres', sliding),
    ]
    there = [(unit, right, advice) for unit, right, advice, of in kinds if np.any(out & of)]
    units, right, advice = (' and '.join(words) for words in zip(*there, strict=True))
    names = zip(model.joint_names, pose, out, strict=True)
    raise RecordingError(
        f'joint positions look like {units}' if looks else 'joint positions are out of all range',
        where=where,
        found=', '.join(f'{name} {value:.3g}' for name, value, far in names if far),
        expected=right,
        advice=f'record {advice}' if looks else '',
    )
