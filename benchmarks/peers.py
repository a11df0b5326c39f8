"""The peers, imported lazily; each runs the same arrays at the same orders as ours."""

import contextlib
import importlib.util
import io
import logging

import numpy as np
from numpy.typing import NDArray

from modal_core.samples import Samples

PEERS = {'pyoma2': 'pyOMA-2', 'koma': 'koma-python'}


def missing() -> list[str]:
    """Return the distributions of the peers that are not installed."""
    return [name for module, name in PEERS.items() if importlib.util.find_spec(module) is None]


def installed(module: str) -> bool:
    return importlib.util.find_spec(module) is not None


def pyoma2_ssi(
    samples: Samples,
    method: str,
    block_rows: int,
    order: int,
    references: list[int] | None,
    with_std: bool = False,
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Run pyOMA2's SSI; return frequencies and damping ratios of the highest order."""
    from pyoma2.algorithms import SSI
    from pyoma2.setup import SingleSetup

    step = 1 if with_std else 2
    options = {'br': block_rows, 'ordmin': 0, 'ordmax': order, 'step': step, 'method': method}
    if references is not None:
        options['ref_ind'] = references
    if with_std:
        options.update(calc_unc=True, nb=50)
    setup = SingleSetup(samples.acceleration, fs=samples.sample_rate_hz)
    algorithm = SSI(name='peer', **options)
    with _quiet():
        setup.add_algorithms(algorithm)
        setup.run_by_name('peer')
    result = algorithm.result
    # The hard criteria leave NaN; what is compared here is cost and poles.
    return np.asarray(result.Fn_poles), np.asarray(result.Xi_poles)


def pyoma2_plscf(samples: Samples, order: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    from pyoma2.algorithms import pLSCF
    from pyoma2.setup import SingleSetup

    setup = SingleSetup(samples.acceleration, fs=samples.sample_rate_hz)
    algorithm = pLSCF(name='peer', ordmax=order)
    with _quiet():
        setup.add_algorithms(algorithm)
        setup.run_by_name('peer')
    return np.asarray(algorithm.result.Fn_poles), np.asarray(algorithm.result.Xi_poles)


def pyoma2_efdd(
    samples: Samples, frequencies_hz: list[float]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    from pyoma2.algorithms import EFDD
    from pyoma2.setup import SingleSetup

    setup = SingleSetup(samples.acceleration, fs=samples.sample_rate_hz)
    algorithm = EFDD(name='peer', nxseg=1024)
    with _quiet():
        setup.add_algorithms(algorithm)
        setup.run_by_name('peer')
        setup.mpe('peer', sel_freq=frequencies_hz)
    return np.asarray(algorithm.result.Fn).ravel(), np.asarray(algorithm.result.Xi).ravel()


def koma_ssi(samples: Samples, block_rows: int, order: int) -> tuple[list, list]:
    from koma.oma import covssi

    with _quiet():
        poles, shapes, _ = covssi(
            samples.acceleration, samples.sample_rate_hz, block_rows, np.arange(2, order + 1, 2)
        )
    return poles, shapes


@contextlib.contextmanager
def _quiet():
    logging.disable(logging.CRITICAL)
    try:
        with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):
            yield
    finally:
        logging.disable(logging.NOTSET)
