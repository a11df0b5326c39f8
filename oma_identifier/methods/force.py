"""Identification with a measured force, such as that of a cut, as a method of the catalogue.

The equations are those of `csi`; what the force does not explain, chips that break, floor and
drives, is noise.  Modal masses follow from the same force
(:mod:`oma_identifier.known_force`).

References
----------
Nguyen and Melkote (2020), doi:10.1016/j.promfg.2020.05.034 (milling forces and response);
Reynders and De Roeck (2008), doi:10.1016/j.ymssp.2007.09.004 (reference-based combined
identification).
"""

from oma_identifier.methods.csi import Csi


class Force(Csi):
    """A force is measured; deviations by the jackknife of blocks."""

    name = 'force'
