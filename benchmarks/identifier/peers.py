"""What the peers do with a record, as cases to be timed like ours (see `ours.py`)."""

from collections.abc import Callable
import contextlib
import importlib.util
import logging
import os

import numpy as np
from numpy.typing import NDArray

from benchmarks.identifier.record import (
    BLOCK_ROWS,
    Found,
    N_BLOCKS,
    ORDER,
    ORDERS,
    reference_channels,
)

PEERS = {'pyoma2': 'pyOMA-2', 'koma': 'koma-python', 'strid': 'strid'}
ALL_POLES = {'xi_max': 1e9, 'mpc_lim': None, 'mpd_lim': None, 'CoV_max': None}
"""Hard criteria that let every stable pole pass."""
EFDD_SEGMENT = 2048
"""Twice the default, whose correlation is too short for the lowest mode: it raises an error."""

Call = Callable[[NDArray[np.float64], float], Found]


def installed(module: str) -> bool:
    return importlib.util.find_spec(module) is not None


def missing() -> list[str]:
    """Return the distributions of the peers that are not installed."""
    return [name for module, name in PEERS.items() if not installed(module)]


def pyoma2_ssi(method: str, n_references: int, with_std: bool = False) -> Call:
    """Its uncertainties are right with step 1 only."""
    from pyoma2.algorithms import SSI
    from pyoma2.setup import SingleSetup

    def call(rows: NDArray[np.float64], rate_hz: float) -> Found:
        options = {'br': BLOCK_ROWS, 'ordmin': 0, 'ordmax': ORDER, 'step': 1 if with_std else 2}
        algorithm = SSI(
            name='peer',
            method=method,
            ref_ind=[int(row) for row in reference_channels(n_references)],
            hc={**ALL_POLES, 'xi_max': 0.2} if with_std else ALL_POLES,
            calc_unc=with_std,
            nb=N_BLOCKS,
            **options,
        )
        run_pyoma2(SingleSetup(rows, fs=rate_hz), algorithm)
        poles = algorithm.result.Lambds
        order = np.broadcast_to(np.arange(poles.shape[1]) * options['step'], poles.shape)
        # One of each conjugate pair is kept, whichever comes first.
        there = np.isfinite(poles) & (poles.imag != 0.0)
        poles, order = poles[there], order[there]
        poles = poles.real + 1j * np.abs(poles.imag)
        if not with_std:
            return Found(poles=(order, poles))
        result = algorithm.result
        std = np.column_stack([result.Fn_poles_std[there], result.Xi_poles_std[there]])
        return Found(poles=(order, poles), deviations=std)

    return call


def pyoma2_plscf(order: int) -> Call:
    from pyoma2.algorithms import pLSCF
    from pyoma2.setup import SingleSetup

    def call(rows: NDArray[np.float64], rate_hz: float) -> Found:
        algorithm = pLSCF(name='peer', ordmax=order)
        run_pyoma2(SingleSetup(rows, fs=rate_hz), algorithm)
        result = algorithm.result
        # The highest order, as without a stabilisation diagram.
        frequency, damping = result.Fn_poles[:, -1], result.Xi_poles[:, -1]
        keep = np.isfinite(frequency) & (damping > 0.0) & (damping < 0.15)
        return Found(modes=(frequency[keep], damping[keep]))

    return call


def pyoma2_efdd(wide_bells: bool) -> Call:
    """Peaks picked for it at the true frequencies; bells of 1 Hz by default, or of the mode."""
    from pyoma2.algorithms import EFDD
    from pyoma2.setup import SingleSetup

    from benchmarks.identifier.plant import DAMPING_RATIO, FREQUENCY_HZ

    def call(rows: NDArray[np.float64], rate_hz: float) -> Found:
        algorithm = EFDD(name='peer', nxseg=EFDD_SEGMENT)
        setup = SingleSetup(rows, fs=rate_hz)
        run_pyoma2(setup, algorithm)
        line_hz = rate_hz / EFDD_SEGMENT
        frequency, damping = [], []
        for hz, ratio in zip(FREQUENCY_HZ, DAMPING_RATIO, strict=True):
            bell = {'DF2': 1.0 + 6.0 * ratio * hz} if wide_bells else {}
            with quiet():
                setup.mpe('peer', sel_freq=[hz], DF1=1.5 * line_hz, **bell)
            frequency.append(float(algorithm.result.Fn[0]))
            damping.append(float(algorithm.result.Xi[0]))
        return Found(modes=(np.array(frequency), np.array(damping)))

    return call


def koma_ssi() -> Call:
    from koma.oma import covssi

    def call(rows: NDArray[np.float64], rate_hz: float) -> Found:
        with quiet():
            covssi(rows, rate_hz, BLOCK_ROWS, np.array(ORDERS))
        return Found()

    return call


def strid_ssi(n_references: int) -> Call:
    from strid import CovarianceDrivenStochasticSID

    def call(rows: NDArray[np.float64], rate_hz: float) -> Found:
        used = [int(row) for row in reference_channels(n_references)]
        identifier = CovarianceDrivenStochasticSID(rows.T, rate_hz, used)
        for order in ORDERS:
            transition = identifier.perform(order, BLOCK_ROWS)[0]
            np.linalg.eig(transition)
        return Found()

    return call


def run_pyoma2(setup, algorithm) -> None:
    with quiet():
        setup.add_algorithms(algorithm)
        setup.run_by_name('peer')


@contextlib.contextmanager
def quiet():
    logging.disable(logging.CRITICAL)
    with open(os.devnull, 'w') as nowhere:  # noqa: PTH123
        try:
            with contextlib.redirect_stdout(nowhere), contextlib.redirect_stderr(nowhere):
                yield
        finally:
            logging.disable(logging.NOTSET)
