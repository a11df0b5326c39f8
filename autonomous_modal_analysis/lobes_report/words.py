"""Numbers of a proposed cut as people read them."""

import math

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
