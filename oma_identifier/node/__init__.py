"""The identifier as a ROS node.

In come topics; out go modal parameters after each window. Nothing is computed here: messages
are decoded and queued, windows are identified in a thread beside.
"""

from oma_identifier.node.cell_topics import cells, is_of_cell

__all__ = ['cells', 'is_of_cell']
