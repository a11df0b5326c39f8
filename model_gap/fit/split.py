"""Which poses take no part in the fit."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from modal_core.errors import SettingsError
from model_gap.campaign import Campaign, GapRecord
from model_gap.fit.thresholds import FIT
from model_gap.predict import PREDICTION


def split(campaign: Campaign, rng: np.random.Generator) -> Campaign:
    """Mark whole poses as held out, as the campaign says or drawn at random.

    Parameters
    ----------
    campaign : Campaign
        Records of one pose stay together: what one of them says holds for all.
    rng : numpy.random.Generator
        For the draw among the poses of which nothing is said, up to the usual share of all.

    Raises
    ------
    SettingsError
        Records of one pose contradict each other, or every pose is held out.
    """
    groups = pose_groups(campaign)
    heldout = _said(campaign.records, groups)
    count = len(heldout)
    if all(heldout.values()):
        raise SettingsError(
            'every pose is held out, nothing is left to fit',
            where='campaign.yaml',
            advice='leave heldout away from some recordings',
        )
    wanted = round(FIT.heldout_share * count) if count >= FIT.least_poses else 0
    wanted -= sum(said is True for said in heldout.values())
    free = [group for group, said in heldout.items() if said is None]
    order = rng.permutation(len(free))
    chosen = {free[place] for place in order[: max(wanted, 0)]}
    return replace(
        campaign,
        records=tuple(
            replace(item, heldout=bool(heldout[group]) or group in chosen)
            for item, group in zip(campaign.records, groups, strict=True)
        ),
    )


def _said(records: Sequence[GapRecord], groups: Sequence[int]) -> dict[int, bool | None]:
    """Return what the campaign says of every pose, in their order."""
    found: dict[int, bool | None] = {}
    for record, group in zip(records, groups, strict=True):
        before = found.get(group)
        if None not in (before, record.heldout) and before != record.heldout:
            pairs = zip(records, groups, strict=True)
            same = [item.name for item, other in pairs if other == group]
            raise SettingsError(
                'recordings of one pose, some held out and some not',
                where='campaign.yaml: heldout',
                found=', '.join(same),
                expected='one for all recordings of a pose',
            )
        found[group] = before if record.heldout is None else record.heldout
    return found


def pose_groups(campaign: Campaign) -> list[int]:
    """Return the number of the pose of every record."""
    poses: list[np.ndarray] = []
    groups = []
    for record in campaign.records:
        same = [
            number
            for number, pose in enumerate(poses)
            if np.abs(pose - record.pose).max() < PREDICTION.same_pose_rad
        ]
        if not same:
            poses.append(record.pose)
        groups.append(same[0] if same else len(poses) - 1)
    return groups
