"""Tests of all rooms; what they share is in ``support``."""
