"""Sensor layouts from files, and which of their channels a recorded name means.

In come a file or names; out go layouts and channels.
"""
