"""Residuals and their derivatives, as real rows weighted by the noise."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from model_gap.hypothesis import Hypothesis
from model_gap.predict import Predictor
from model_gap.spectra import Complex

Array = NDArray[np.float64]
Rows = NDArray[np.float32]
TOLERANCE_STEP = 0.05
EFFECT_STEP = 0.002


@dataclass(frozen=True)
class Weighting:
    """How spectra become rows: real and imaginary parts over the noise.

    Parameters
    ----------
    scale : list of (n_channels, 1) array
        One over the root of half the noise power, per record.
    measured : (n_rows,) array
        Measured spectra as rows.
    """

    scale: list[Array]
    measured: Rows

    @classmethod
    def of(cls, predictor: Predictor) -> 'Weighting':
        """Weight the records of a predictor."""
        scale = [np.sqrt(1.0 / item.noise_power)[:, None] for item in predictor.records]
        measured = _rows([item.measured for item in predictor.records], scale)
        return cls(scale, measured)

    def rows(self, spectra: list[Complex]) -> Rows:
        """Return spectra as one weighted real vector."""
        return _rows(spectra, self.scale)

    @property
    def count(self) -> int:
        """Number of complex data."""
        return len(self.measured) // 2


def _rows(spectra: list[Complex], scale: list[Array]) -> Rows:
    parts = []
    for item, weight in zip(spectra, scale, strict=True):
        scaled = (item * weight).ravel()
        parts += [scaled.real, scaled.imag]
    return np.concatenate(parts).astype(np.float32)


def misfit(weighting: Weighting, rows: Rows) -> float:
    """Return χ, the mean of |measured - predicted|² / noise power."""
    residual = (weighting.measured - rows).astype(float)
    return float(residual @ residual) / weighting.count


def effect_columns(
    hypothesis: Hypothesis, predictor: Predictor, weighting: Weighting, base: Rows
) -> Rows:
    """Return derivatives by the inner parameters, in prior standard deviations, as rows."""
    tolerant = hypothesis.tolerant_setup()
    setups, factors = [], []
    for number, scale in enumerate(hypothesis.prior_scale):
        inner = hypothesis.inner.copy()
        step = EFFECT_STEP * scale
        item = hypothesis.parameters[number]
        if item.inner(item.high) - inner[number] < step:
            step = -step
        inner[number] += step
        moved = hypothesis.moved(hypothesis.tolerance_values, inner)
        setups.append(moved.add_effects(tolerant))
        factors.append(np.float32(scale / step))
    found = predictor.predict_many(setups) if setups else []
    columns = [
        (weighting.rows(spectra) - base) * factor
        for spectra, factor in zip(found, factors, strict=True)
    ]
    return np.array(columns, dtype=np.float32).reshape(len(columns), len(base))


def tolerance_columns(hypothesis: Hypothesis, predictor: Predictor, weighting: Weighting) -> Rows:
    """Return derivatives by the tolerances, per prior standard deviation, as rows.

    Nonlinear forces are held at their present values.
    """
    setup = hypothesis.setup()
    systems = predictor.systems(setup.spec, setup.channels)
    states, forces = predictor.states_and_forces(setup, systems)
    readings = predictor.readings(systems, states)
    base = weighting.rows(predictor.outputs(setup, readings))
    columns = []
    gain_row = 0
    for number, item in enumerate(hypothesis.tolerances):
        if item.kind == 'gain':
            masked = []
            for reading in readings:
                part = np.zeros_like(reading)
                part[gain_row] = reading[gain_row] * item.sigma
                masked.append(part)
            gain_row += 1
            columns.append(weighting.rows(predictor.outputs(setup, masked)))
            continue
        values = hypothesis.tolerance_values.copy()
        values[number] += TOLERANCE_STEP
        moved = hypothesis.add_effects(hypothesis.tolerant_setup(values))
        if item.kind == 'position':
            other = predictor.sensors_moved(moved, systems)
            found = predictor.readings(other, states)
        else:
            other = predictor.systems(moved.spec, moved.channels)
            found = predictor.readings(other, predictor.states(moved, other, forces))
        rows = weighting.rows(predictor.outputs(moved, found))
        columns.append((rows - base) / np.float32(TOLERANCE_STEP))
    return np.array(columns, dtype=np.float32)
