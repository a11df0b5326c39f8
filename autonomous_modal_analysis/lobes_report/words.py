"""Numbers of a proposed cut as people read them."""

from collections.abc import Mapping
import math
from typing import Any

from machining.lobes import Proposal


def chance_words(proposal: Proposal) -> str:
    """Return the chance of chatter with its deviation; unknown where nothing has a σ."""
    if math.isnan(proposal.chance):
        return 'unknown'
    return f'{100.0 * proposal.chance:.1f} ± {100.0 * proposal.chance_std:.1f} %'


def cut_words(proposal: Proposal) -> tuple[str, str, str, str]:
    """Return speed, depth, feed and chance."""
    return (
        f'{proposal.speed_rpm:.0f}',
        f'{1e3 * proposal.depth_m:.2f}',
        f'{proposal.feed_deg:g}',
        chance_words(proposal),
    )


HEADINGS = ('spindle speed [rpm]', 'depth [mm]', 'feed [°]', 'chance of chatter')

POSE_HEADINGS = ('turn [°]', 'axes [°]', 'spindle speed [rpm]', 'depth [mm]', 'feed [°]')


def pose_words(pose: Mapping[str, Any]) -> tuple[str, ...]:
    """Return turn, controller axes and the cut of a pose, or why there is none."""
    turn = f'{pose["turn_deg"]:+.0f}{" (best)" if pose["best"] else ""}'
    axes = ', '.join(f'{angle:.1f}' for angle in pose['pose_deg'])
    if pose['depth_m'] is None:
        return (turn, axes, pose['reason'], '', '')
    cut = f'{pose["speed_rpm"]:.0f}', f'{1e3 * pose["depth_m"]:.2f}', f'{pose["feed_deg"]:g}'
    return (turn, axes, *cut)
