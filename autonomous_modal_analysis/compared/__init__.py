"""Several recordings beside each other: each mode over speed, load, pose and level of motion.

In come modes of each recording; out go tables of what changed, with deviations.
"""
