"""Demonstrations: the emulated arm shakes itself, is tapped, or mills, beside what is true.

In come a length, a fault, a seed; out go what was found, the truth beside it, and a verdict.
"""
