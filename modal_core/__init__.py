"""The vocabulary every room shares: samples, windows, poles, modes, indicators, errors.

Needs numpy only.  Samples run along axis 0 and channels along axis 1; mode shapes are columns.
"""
