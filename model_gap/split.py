"""Which poses take no part in the fit."""

from dataclasses import replace

import numpy as np

from model_gap.campaign import Campaign
from model_gap.predict import SAME_POSE_RAD

HELDOUT_SHARE = 0.4


def split(campaign: Campaign, rng: np.random.Generator) -> Campaign:
    """Mark whole poses as held out, as the campaign says or drawn at random.

    Parameters
    ----------
    campaign : Campaign
        Records of one pose stay together.
    rng : numpy.random.Generator
        For the draw.
    """
    if any(record.heldout is not None for record in campaign.records):
        records = tuple(replace(item, heldout=bool(item.heldout)) for item in campaign.records)
        return replace(campaign, records=records)
    groups = pose_groups(campaign)
    count = len(set(groups))
    held = round(HELDOUT_SHARE * count) if count >= 3 else 0
    chosen = set(rng.permutation(count)[:held].tolist())
    return replace(
        campaign,
        records=tuple(
            replace(item, heldout=group in chosen)
            for item, group in zip(campaign.records, groups, strict=True)
        ),
    )


def pose_groups(campaign: Campaign) -> list[int]:
    """Return the number of the pose of every record."""
    poses: list[np.ndarray] = []
    groups = []
    for record in campaign.records:
        same = [
            number
            for number, pose in enumerate(poses)
            if np.abs(pose - record.pose).max() < SAME_POSE_RAD
        ]
        if not same:
            poses.append(record.pose)
        groups.append(same[0] if same else len(poses) - 1)
    return groups
