"""Universal files: samples, geometry and mode shapes of other programs for modal analysis.

In come the blocks of a file, text or binary; out go arrays with their units, places and lines of a
structure, and shapes.  Their writing is in ``autonomous_modal_analysis.export``.
"""

from modal_recordings.universal.universal_blocks import blocks_of
from modal_recordings.universal.universal_file import KINDS
from modal_recordings.universal.universal_geometry import read_geometry
from modal_recordings.universal.universal_names import direction_of
from modal_recordings.universal.universal_shapes import read_shapes

__all__ = ['KINDS', 'blocks_of', 'direction_of', 'read_geometry', 'read_shapes']
