"""Channels as universal files call them: node and direction, ``12:+Z``."""

import re

NODE = re.compile(r'^(\d+):([+-])([XYZ])$')


def direction_of(name: str) -> tuple[int, tuple[float, float, float]] | None:
    """Return the node of a channel and its unit vector; None of any other name."""
    found = NODE.match(name)
    if found is None:
        return None
    sign = -1.0 if found.group(2) == '-' else 1.0
    x, y, z = (sign * (found.group(3) == axis) for axis in 'XYZ')
    return int(found.group(1)), (x, y, z)
