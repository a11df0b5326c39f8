"""Processes that the tests start and that must not outlive them."""

import ctypes
import signal


def end_with_parent():
    """Be told to end when the tests are ended, however that happens (prctl PR_SET_PDEATHSIG)."""
    ctypes.CDLL(None).prctl(1, signal.SIGTERM)
