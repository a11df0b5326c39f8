"""What we do with a record, as cases to be timed; imports come with the case, not with the file.

A factory imports and returns the function of (rows, sample rate [Hz]) whose cost counts.
"""

from collections.abc import Callable, Sequence
from importlib import import_module

import numpy as np
from numpy.typing import NDArray

from benchmarks.identifier.record import (
    BLOCK_ROWS,
    Found,
    N_BLOCKS,
    names,
    ORDER,
    ORDERS,
    reference_channels,
)

Call = Callable[[NDArray[np.float64], float], Found]


def idle() -> Call:
    return lambda rows, rate_hz: Found()


def ssi_cov(n_references: int) -> Call:
    """The block Hankel matrix of the peer, edges of the record included: equal poles."""
    from oma_identifier.covariance import HankelGram
    from oma_identifier.subspace import poles_of_projection

    def call(rows: NDArray[np.float64], rate_hz: float) -> Found:
        references = rows[:, reference_channels(n_references)]
        gram = HankelGram(rows, references, 2 * BLOCK_ROWS)
        hankel = gram.product(range(BLOCK_ROWS, 2 * BLOCK_ROWS), range(BLOCK_ROWS))
        poles = poles_of_projection(hankel, rows.shape[1], n_references, ORDERS)
        return Found(poles=(poles.model_order, np.log(poles.eigenvalue) * rate_hz))

    return call


def ssi_cov_std(which: str) -> Call:
    """Poles of all orders, step 1, with 6 references; σ of `all`, of one a `mode`, of `none`."""
    from benchmarks.identifier.plant import FREQUENCY_HZ
    from oma_identifier.covariance import CovarianceAccumulator
    from oma_identifier.subspace import (
        deviation_from,
        factorise,
        influence,
        MultiOrder,
        poles_of_orders,
        PoleSensitivity,
    )

    def call(rows: NDArray[np.float64], rate_hz: float) -> Found:
        block = len(rows) // N_BLOCKS
        accumulator = CovarianceAccumulator(
            2 * BLOCK_ROWS - 1, reference_channels(6), block, N_BLOCKS
        )
        accumulator.add(rows)
        covariance = accumulator.result(rate_hz)
        factors = factorise(covariance.mean, BLOCK_ROWS)
        system = MultiOrder(factors, ORDER)
        solutions = {order: system.solve(order) for order in range(2, ORDER + 1)}
        raw = poles_of_orders(tuple(solutions.values()), factors.left[: rows.shape[1]])
        poles = np.log(raw.eigenvalue) * rate_hz
        damping = -poles.real / np.abs(poles)
        wanted = np.flatnonzero((damping > 0.0) & (damping < 0.2))
        if which == 'none':
            return Found(poles=(raw.model_order, poles))
        if which == 'mode':
            wanted = _one_a_mode(raw.model_order, poles, wanted, FREQUENCY_HZ)
        sensitivity = PoleSensitivity(system)
        deviations = []
        for order in np.unique(raw.model_order[wanted]):
            own = wanted[raw.model_order[wanted] == order]
            values = raw.eigenvalue[own]
            gradients = sensitivity.gradients([solutions[int(order)]] * len(own), values)
            series = influence(gradients, values, covariance)
            deviations += [
                deviation_from(each, pole, len(rows) / rate_hz)
                for each, pole in zip(series.T, poles[own], strict=True)
            ]
        std = np.array([[each.frequency_std_hz, each.damping_ratio_std] for each in deviations])
        return Found(poles=(raw.model_order[wanted], poles[wanted]), deviations=std)

    return call


def _one_a_mode(
    order: NDArray[np.int64],
    poles: NDArray[np.complex128],
    wanted: NDArray[np.int64],
    true_hz: Sequence[float],
) -> NDArray[np.int64]:
    """Return the poles of the highest order that are nearest to the modes of the plant."""
    last = wanted[order[wanted] == ORDER]
    hz = np.abs(poles[last]) / (2.0 * np.pi)
    return last[[int(np.argmin(np.abs(hz - truth))) for truth in true_hz]]


def ssi_data(n_references: int) -> Call:
    from oma_identifier.subspace.ssi_data import ssi_data as solve

    def call(rows: NDArray[np.float64], rate_hz: float) -> Found:
        poles = solve(rows, reference_channels(n_references), BLOCK_ROWS, ORDERS)
        return Found(poles=(poles.model_order, np.log(poles.eigenvalue) * rate_hz))

    return call


def plscf_poles(highest: int) -> Call:
    """All channels as references, like the peer, up to its order."""
    from oma_identifier.methods.polyreference import plscf

    def call(rows: NDArray[np.float64], rate_hz: float) -> Found:
        poles = plscf(rows, np.arange(rows.shape[1]), 512, range(2, highest + 1))
        return Found(poles=(poles.model_order, np.log(poles.eigenvalue) * rate_hz))

    return call


def method(name: str) -> Call:
    """A method as a user calls it: modes out, nothing handed over."""
    from modal_core.samples import Samples
    from oma_identifier.methods import identify_by

    # Loaded when first needed, as the peer's are on import: a process pays for them once.
    for module in ('scipy.optimize', 'scipy.signal', 'scipy.stats'):
        import_module(module)

    def call(rows: NDArray[np.float64], rate_hz: float) -> Found:
        modes = identify_by(name, Samples(rows, rate_hz, names(rows.shape[1]))).modes
        return Found(modes=(modes.frequency_hz, modes.damping_ratio))

    return call
