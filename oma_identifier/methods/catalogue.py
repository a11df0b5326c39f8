"""The methods by name: the same samples in, the same modes, lines and poles out.

All keep to the band asked for, and decide by the same rules what is a mode and what is a line.
"""

import numpy as np
from numpy.typing import NDArray

from modal_core.errors import SettingsError
from modal_core.samples import Samples
from oma_identifier.identify import check_samples
from oma_identifier.methods.csi import Csi
from oma_identifier.methods.force import Force
from oma_identifier.methods.method import Method
from oma_identifier.methods.notch import NOTCH
from oma_identifier.methods.plscf import Plscf
from oma_identifier.methods.psdtm import Psdtm
from oma_identifier.methods.rvar import RecursiveVar
from oma_identifier.methods.spectral import Efdd, Fdd
from oma_identifier.methods.ssi_cov import SsiCov
from oma_identifier.methods.ssi_data import SsiData
from oma_identifier.methods.var import Var
from oma_identifier.methods.vmd import VMD
from oma_identifier.methods.without_lines import WithoutLines
from oma_identifier.motion import never, PeakTest
from oma_identifier.moving_lines import by_notch
from oma_identifier.one_thread import one_thread
from oma_identifier.selection import Identified
from oma_identifier.settings import IdentificationSettings

CATALOGUE: tuple[Method, ...] = (
    SsiCov(),
    WithoutLines('ssi_data', SsiData(), by_notch),
    Plscf(),
    WithoutLines('var', Var(), by_notch),
    WithoutLines('rvar', RecursiveVar(), by_notch),
    NOTCH,
    VMD,
    Psdtm(),
    Csi(),
    Force(),
    Efdd(),
    Fdd(),
)
METHODS = tuple(method.name for method in CATALOGUE)


def method_named(name: str) -> Method:
    """Return a method of the catalogue.

    Raises
    ------
    SettingsError
        There is none of this name.
    """
    for method in CATALOGUE:
        if method.name == name:
            return method
    raise SettingsError('unknown method', where='method', found=name, expected=', '.join(METHODS))


def identify_by(
    method: str,
    samples: Samples,
    settings: IdentificationSettings | None = None,
    inputs: NDArray[np.float64] | None = None,
    explains: PeakTest = never,
) -> Identified:
    """Identify the modes of one stretch of samples by the named method.

    Parameters
    ----------
    method : str
        One of :data:`METHODS`.
    samples : Samples
        Responses.
    settings : IdentificationSettings or None
        None: the defaults.
    inputs : (n_samples, n_inputs) array or None
        Known inputs on the grid of the samples; ``csi`` and ``force`` need them, the
        others do without.
    explains : callable
        Tells a peak that motion of the robot explains from a mode.

    Raises
    ------
    SettingsError
        Unknown method, or one that needs inputs without them.
    IdentificationError
        The samples cannot be identified.
    """
    by = method_named(method)
    if by.needs_inputs and inputs is None:
        raise SettingsError(f'{method} needs the known inputs', where='inputs')
    check_samples(samples)
    with one_thread():
        return by.identify(samples, settings or IdentificationSettings(), inputs, explains)
