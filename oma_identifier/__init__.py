"""Samples in, tracked modes out: read `pipeline.py` from top to bottom.

In come samples of accelerometers and IMUs, and joint states where there are any; out go natural
frequencies, damping ratios and mode shapes with their standard deviations, window after window.
"""
