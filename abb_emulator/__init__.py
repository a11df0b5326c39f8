"""The controller, the drives, the arm and its sensors, to try everything on.

Its physics are its own: it shares no effect with the model gap, which is tried on it.
"""
