"""Numbers the rooms share: indicators of shapes, pairings, chances, peaks and tapers.

In come arrays; out go numbers.
"""
