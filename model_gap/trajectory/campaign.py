"""A campaign of encoder recordings: which are fitted, which are held out, where it starts."""

from collections.abc import Iterable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from modal_core.errors import SettingsError
from modal_core.files.yaml_file import load_yaml
from model_gap.campaign import CampaignEntry, read_campaign_file, refuse_copies
from model_gap.trajectory.recording import (
    EncoderRecording,
    has_encoders,
    read_encoder_recording,
    SUFFIX,
)
from structural_model import FlexibleJointModel

Array = NDArray[np.float64]
FILE = 'campaign.yaml'
START = 'start'
# Of several recordings; of one alone, its last part.
HELD_OUT_SHARE = 0.4


@dataclass(frozen=True)
class EncoderCampaign:
    """Recordings of one robot.

    Parameters
    ----------
    fitting, heldout : tuple of EncoderRecording
        What laws are sought in, and what they are judged by.
    start : (n_joints,) array [rad]
        Serial joint angles at which the positions are zero.
    tolerances : dict
        How roughly the model is known, as the campaign says.
    remarks : tuple of str
        For people.
    """

    fitting: tuple[EncoderRecording, ...]
    heldout: tuple[EncoderRecording, ...]
    start: Array
    tolerances: dict[str, Any] = field(default_factory=dict)
    remarks: tuple[str, ...] = ()


def is_encoder_campaign(folder: str | Path) -> bool:
    """Return whether a folder holds encoder recordings rather than accelerations."""
    folder = Path(folder)
    if not folder.is_dir():
        return False
    if not (folder / FILE).exists():
        return any(has_encoders(item) for item in folder.iterdir())
    return any(has_encoders(entry.path) for entry in read_campaign_file(folder).entries)


def read_encoder_campaign(folder: str | Path, model: FlexibleJointModel) -> EncoderCampaign:
    """Read a folder of ``.npz`` files, and ``campaign.yaml`` where there is one.

    Raises
    ------
    ModalAnalysisError
        A file is not what it should be.
    """
    folder = Path(folder)
    stated = folder / FILE
    if stated.exists():
        file = read_campaign_file(folder)
        entries, remarks, sizes = file.entries, file.remarks, dict(file.tolerances)
        start = load_yaml(stated).get('start_pose')
    else:
        files = folder.iterdir() if folder.is_dir() else ()
        paths = sorted(item for item in files if item.suffix == SUFFIX)
        if not paths:
            raise SettingsError('no recordings', where=folder, expected=f'{SUFFIX} files there')
        entries, remarks, sizes = tuple(CampaignEntry(item, item.name) for item in paths), (), {}
        start = None
    recordings = [read_encoder_recording(item.path, model.n_joints) for item in entries]
    samples = [(it.motor_rad, it.link_rad, it.torque_nm) for it in recordings]
    refuse_copies(zip((entry.name for entry in entries), samples, strict=True), folder)
    if len({item.encoders for item in recordings}) > 1:
        raise SettingsError('recordings of different encoders', where=folder)
    fitting, heldout, how = _divided(recordings, [item.heldout for item in entries])
    pose = _start(model, start, str(stated))
    return EncoderCampaign(tuple(fitting), tuple(heldout), pose, sizes, (*remarks, how))


def _divided(
    recordings: list[EncoderRecording], stated: list[bool | None]
) -> tuple[list[EncoderRecording], list[EncoderRecording], str]:
    if len(recordings) == 1:
        (whole,) = recordings
        cut = 1.0 - HELD_OUT_SHARE
        parts = (
            whole.part(0.0, cut, f'{whole.name}, begin'),
            whole.part(cut, 1.0, f'{whole.name}, end'),
        )
        return [parts[0]], [parts[1]], 'one recording: its last two fifths are held out'
    if not any(item is not None for item in stated):
        count = max(1, int(HELD_OUT_SHARE * len(recordings)))
        stated = [place >= len(recordings) - count for place in range(len(recordings))]
    pairs = list(zip(recordings, stated, strict=True))
    fitting = [item for item, out in pairs if not out]
    heldout = [item for item, out in pairs if out]
    if not fitting or not heldout:
        raise SettingsError(
            'nothing to fit' if heldout else 'nothing held out', where=FILE,
            advice='say heldout: true of some recordings, not of all',
        )  # fmt: skip
    return fitting, heldout, f'held out: {_names(heldout)}'


def _names(recordings: Iterable[EncoderRecording]) -> str:
    return ', '.join(item.name for item in recordings)


def _start(model: FlexibleJointModel, stated: object, where: str) -> Array:
    """Return the pose from which positions count: stated, the model's own, or zero."""
    place = f'{where}: start_pose'
    if stated is None:
        known = START in model.poses_controller_rad
        return model.pose(START) if known else np.zeros(model.n_joints)
    if isinstance(stated, str):
        return model.pose(stated)
    numbers = isinstance(stated, list) and all(
        isinstance(angle, int | float) and not isinstance(angle, bool) for angle in stated
    )
    if not numbers or not isinstance(stated, list) or len(stated) != model.n_joints:
        raise SettingsError(
            'not a pose', where=place, found=stated,
            expected=f'a name, or {model.n_joints} controller angles [deg]',
        )  # fmt: skip
    angles = np.deg2rad(np.array(stated, dtype=float))
    if not np.isfinite(angles).all():
        raise SettingsError('not a pose', where=place, found=stated, expected='finite angles')
    return np.asarray(model.to_serial(angles))
