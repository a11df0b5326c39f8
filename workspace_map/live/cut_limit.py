"""How deep a cut may be at a pose, quickly enough to be asked while the arm moves."""

from dataclasses import replace

from machining.cut_settings import CutSettings
from machining.lobes import Lobes, stability_lobes
from workspace_map.predicted import PredictedModes
from workspace_map.tool_point import tool_modes

THEORY = 'mean'
"""The zeroth order: 0.2 s with 40 samples where semi-discretisation takes half a minute.  Chatter
of doubled period, at small radial depths, is not seen."""


def cut_limit(modes: PredictedModes, settings: CutSettings) -> Lobes:
    """Return limits over spindle speed at a pose, with the chance of chatter by the modes' σ.

    Parameters
    ----------
    modes : PredictedModes
        Of the map, along the tool's axes.
    settings : CutSettings
        The cut; its ``theory`` is not followed, see `THEORY`.
    """
    return stability_lobes(tool_modes(modes), replace(settings, theory=THEORY))
