"""What is no mode by its poles alone, and may be one to the likelihood.

Poles that scatter too much, that peak too little, or whose shapes are complex are left out: what
follows the noise looks alike.  The likelihood can tell, where it describes the data.
"""

from collections.abc import Sequence

from modal_core.mode import Mode
from oma_identifier.selection.average import average
from oma_identifier.selection.distinct import new_among
from oma_identifier.selection.join_bands import mode_of
from oma_identifier.selection.selection import BandSelection


def candidates_among(selections: Sequence[BandSelection]) -> list[Mode]:
    """Return what may be modes beside those selected, by frequency."""
    selected = [pole for each in selections for pole in each.selected]
    poles = [average(each.band, *unsure) for each in selections for unsure in each.unsure]
    return [mode_of(pole) for pole in new_among(poles, selected)]
