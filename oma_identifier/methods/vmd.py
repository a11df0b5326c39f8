"""Variational mode decomposition before subspace identification, as a method of the catalogue."""

from oma_identifier.methods.ssi_data import SsiData
from oma_identifier.methods.without_lines import WithoutLines
from oma_identifier.moving_lines import by_modes

VMD = WithoutLines('vmd', SsiData(), by_modes)
"""Modes of the decomposition that are lines subtracted, then data-driven subspaces."""
