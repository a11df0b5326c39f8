"""The cut itself: in come cutter, engagement, material and feed; out go forces.

And how the tool's displacement changes them: the directional matrices of every theory of chatter.
"""

from machining.cut.coefficients import Coefficients
from machining.cut.cutter import Cutter, Engagement
from machining.cut.directional import Cut
from machining.cut.force import cutting_force

__all__ = ['Coefficients', 'Cut', 'Cutter', 'Engagement', 'cutting_force']
