"""Record a campaign into a folder; one that was interrupted goes on where it stopped."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
import hashlib
import json
from pathlib import Path
from typing import Any

import yaml

from autonomous_modal_analysis.campaigns.campaign_plan import PlannedRecording
from autonomous_modal_analysis.identified.plan_record import recorded_plan_hash
from excitation_planner.plan import ExcitationPlan
from modal_core.channel import LAYOUT_FILE, SensorLayout
from modal_core.errors import RecordingError, SettingsError
from modal_core.files.atomic_file import write_text
from modal_core.files.yaml_file import load_yaml
from modal_core.measurements import NANOSECONDS_PER_SECOND
from modal_core.work.progress import Progress
from modal_recordings.message_recording import MessageRecording
from modal_recordings.open_recording import open_recording
from structural_model.flexible_joint_model import FlexibleJointModel
from structural_model.robot_writer import layout_text

CAMPAIGN = 'campaign.yaml'
# Plays a plan and leaves the whole recording at the path, or nothing.
Player = Callable[[ExcitationPlan, Path, Progress], None]


@dataclass(frozen=True)
class CampaignFolder:
    """Where a campaign goes and what it is made with.

    Parameters
    ----------
    path : Path
        The folder.
    model : FlexibleJointModel
        The robot.
    layout : SensorLayout
        Its sensors; written beside the recordings.
    conditions : mapping
        Everything that makes recordings of the same plan differ; its hash alone is kept, so that
        what is hidden in an emulated arm stays hidden.
    notes : tuple of str
        For people; kept in campaign.yaml.
    """

    path: Path
    model: FlexibleJointModel
    layout: SensorLayout
    conditions: Any = None
    notes: tuple[str, ...] = ()

    @property
    def conditions_hash(self) -> str:
        """Short hash of the conditions."""
        text = json.dumps(self.conditions, sort_keys=True, default=str)
        return hashlib.sha256(text.encode()).hexdigest()[:16]


def record_campaign(
    folder: CampaignFolder,
    planned: Sequence[PlannedRecording],
    play: Player,
    progress: Progress = lambda _: None,
    tell: Callable[[str], None] = lambda _: None,
) -> Path:
    """Make the recordings that are not there yet, and keep campaign.yaml up to date.

    A recording counts as made when it is whole and holds the very plan that is asked for.

    Parameters
    ----------
    folder : CampaignFolder
        Where to.
    planned : sequence of PlannedRecording
        What to record, in order.
    play : callable
        ``(plan, path, progress)``: plays a plan and leaves its recording.
    progress, tell : callable
        Take the fraction done, and what is being done.

    Returns
    -------
    Path
        Of campaign.yaml.

    Raises
    ------
    SettingsError
        The folder holds another campaign.
    ModalAnalysisError
        A plan or recording cannot be made; what was recorded before is kept.
    """
    before = _check_folder(folder)
    folder.path.mkdir(parents=True, exist_ok=True)
    write_text(folder.path / LAYOUT_FILE, layout_text(folder.layout))
    entries: list[dict[str, Any]] = []
    for number, item in enumerate(planned):
        path = folder.path / item.file

        def part(fraction: float, number: int = number) -> None:
            progress((number + fraction) / len(planned))

        plan = item.plan(folder.model, folder.layout)
        if is_whole(path, plan):
            tell(f'{item.file}: kept')
        else:
            tell(f'{item.file}: {number + 1} of {len(planned)}')
            play(plan, path, part)
        entries.append(_entry(item, plan, folder.model))
        # What is not reached yet stays in the list: whoever stops here has what was there before.
        later = [before[other.file] for other in planned[number + 1 :] if other.file in before]
        _write_campaign(folder, [*entries, *later])
        part(1.0)
    return folder.path / CAMPAIGN


def is_whole(path: Path, plan: ExcitationPlan) -> bool:
    """Return whether a recording is undamaged, long enough, and of this plan."""
    try:
        recording = open_recording(path)
        if not isinstance(recording, MessageRecording):
            return False
        if recorded_plan_hash(recording) != plan.plan_hash:
            return False
        info = recording.info()
        seconds = (info.end_ns - info.start_ns) / NANOSECONDS_PER_SECOND
        return not recording.damage() and seconds >= plan.duration_s
    except RecordingError:
        return False


def _check_folder(folder: CampaignFolder) -> dict[str, dict[str, Any]]:
    """Return the recordings of the folder's campaign by file, none where there is none."""
    path = folder.path / CAMPAIGN
    if not path.exists():
        return {}
    content = load_yaml(path)
    if content.get('conditions') != folder.conditions_hash:
        raise SettingsError(
            'the folder holds a campaign made under other conditions',
            where=path,
            advice='choose another --out, or remove the folder',
        )
    listed = content.get('recordings')
    entries = (
        [item for item in listed if isinstance(item, dict)] if isinstance(listed, list) else []
    )
    return {str(item['file']): item for item in entries if 'file' in item}


def _entry(
    item: PlannedRecording, plan: ExcitationPlan, model: FlexibleJointModel
) -> dict[str, Any]:
    angles = model.shown_axes(item.pose)
    return {
        'file': item.file,
        'level': f'{item.level:g}',
        'pose': [round(float(angle), 6) for angle in item.pose],
        'controller_deg': [round(float(angle), 3) for angle in angles],
        'plan_hash': plan.plan_hash,
    }


def _write_campaign(folder: CampaignFolder, entries: Sequence[dict[str, Any]]) -> None:
    content = {
        'robot': folder.model.robot_name,
        'conditions': folder.conditions_hash,
        'notes': list(folder.notes),
        'sensors': LAYOUT_FILE,
        'recordings': list(entries),
    }
    text = yaml.safe_dump(content, sort_keys=False, default_flow_style=None, width=100)
    write_text(folder.path / CAMPAIGN, text)
