"""A map as a ROS node.

In come joint states; out go the modes at the present pose, and how deep a cut may be there.
"""

__all__: list[str] = []
