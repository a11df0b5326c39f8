"""Steps of Fisher scoring: from information and gradient to the next model."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from oma_identifier.likelihood import shape_prior
from oma_identifier.likelihood.band_model import BandData, BandModel
from oma_identifier.likelihood.few_forces import turns
from oma_identifier.likelihood.force_prior import Prior
from oma_identifier.likelihood.whittle import (
    across,
    derivatives_of,
    downhill_gradient,
    evaluated_at,
    Evaluation,
)
from oma_identifier.likelihood.whittle_gradient import pairs
from oma_identifier.likelihood.whittle_information import information as fisher_information

ALIKE = 1.0
"""Distance of nearly equal poles, in half-power half-widths of both."""
LARGEST_LOG_STEP = (0.2, 0.7, 2.0)
"""Of frequency, damping ratio and noise."""

Real = NDArray[np.float64]
Complex = NDArray[np.complex128]


@dataclass(frozen=True, slots=True)
class Quadratic:
    """Fisher information and downhill gradient at one model, and the scale of each parameter.

    Directions across one shape have a common scale, so that it matters not which they are.
    """

    information: Real
    gradient: Real
    scale: Real


def quadratic_at(data: BandData, model: BandModel, prior: Prior, at: Evaluation) -> Quadratic:
    """Return the Fisher information and the gradient, priors included."""
    evaluated = evaluated_at(data, model, at)
    information = fisher_information(evaluated)
    if at.mean is not None and data.known is not None:
        derivatives, modes = derivatives_of(model, at, evaluated)
        own = slice(0, len(modes))
        information[own, own] += at.mean.information(
            data, data.known, at.whitening, derivatives, modes
        )
    weight = prior.weight
    last = np.arange(len(information) - len(weight), len(information))
    information[last, last] += weight
    size, free = 2 * len(model.shapes), model.shapes[:, : model.n_free]
    shapes = [slice(mode * size + 2, (mode + 1) * size) for mode in range(model.n_free)]
    for own, known in zip(shapes, shape_prior.information(free, evaluated.across), strict=True):
        information[own, own] += known
    if model.root is not None:
        _hold_turns(information, model.root, model.n_free * size)
    scale = np.sqrt(np.diag(information))
    for own in shapes:
        scale[own] = np.linalg.norm(scale[own]) / max(1.0, np.sqrt(size - 2))
    return Quadratic(information, downhill_gradient(data, model, prior, at, evaluated), scale)


def _hold_turns(information: Real, root: Complex, first: int) -> None:
    """Say of turns of the root among the forces, which change nothing, that they are none."""
    own = slice(first, first + 2 * root.size)
    turning = turns(root)
    information[own, own] += np.diag(information)[own].max() * (turning @ turning.T)


def scoring_step(quadratic: Quadratic, damping: float) -> Real:
    """Return the Levenberg-damped step; NaN where there is none."""
    scale = quadratic.scale
    scaled = quadratic.information / np.outer(scale, scale)
    scaled[np.diag_indices_from(scaled)] += damping
    try:
        return np.asarray(np.linalg.solve(scaled, quadratic.gradient / scale) / scale)
    except np.linalg.LinAlgError:
        return np.full(len(scale), np.nan)


def moved(model: BandModel, step: Real) -> BandModel:
    """Return the model after a step in the parameters of :func:`downhill_gradient`."""
    frequency, damping = model.frequency_hz.copy(), model.damping_ratio.copy()
    shapes = model.shapes.copy()
    length = np.ones(len(frequency))
    poles = step[: model.n_free * 2 * len(shapes)].reshape(model.n_free, -1)
    free = slice(0, model.n_free)
    frequency[free] *= np.exp(np.clip(poles[:, 0], -LARGEST_LOG_STEP[0], LARGEST_LOG_STEP[0]))
    damping[free] *= np.exp(np.clip(poles[:, 1], -LARGEST_LOG_STEP[1], LARGEST_LOG_STEP[1]))
    turned = across(shapes[:, free]) @ (poles[:, 2::2] + 1j * poles[:, 3::2])[:, :, None]
    shapes[:, free] += turned[:, :, 0].T
    length[free] = np.linalg.norm(shapes[:, free], axis=0)
    n_force = n_force_parameters(model)
    end = poles.size + n_force
    change, root = step[poles.size : end], model.root
    mixing = _mixing(model, shapes)
    if root is None:
        force = _mixed(mixing, model.force, _force_step(model.force, change))
        force *= np.outer(length, length)
    else:
        parts = change.reshape(*root.shape, 2)
        root = root + parts[..., 0] + 1j * parts[..., 1] + mixing @ root
        root = np.asarray(np.linalg.solve(np.eye(len(mixing)) + mixing, root) * length[:, None])
        force = np.asarray(root @ root.conj().T)
    noise = model.noise * np.exp(
        np.clip(step[end + 2 :], -LARGEST_LOG_STEP[2], LARGEST_LOG_STEP[2])
    )
    return replace(
        model,
        frequency_hz=frequency,
        damping_ratio=damping,
        shapes=shapes / length,
        force=force,
        root=root,
        noise=noise,
        slope=model.slope + float(step[end]),
        curvature=model.curvature + float(step[end + 1]),
    )


def _force_step(force: Complex, step: Real) -> Complex:
    first, second = pairs(len(force))
    off = first != second
    change = np.zeros_like(force)
    change[first, second] = step[: len(first)]
    change[first[off], second[off]] += 1j * step[len(first) :]
    return np.asarray(change + np.triu(change, 1).conj().T)


def n_force_parameters(model: BandModel) -> int:
    """Return how many parameters the forces of a model have."""
    return len(model.force) ** 2 if model.root is None else 2 * model.root.size


def _mixing(model: BandModel, shapes: Complex) -> Complex:
    """Return T - 1 of a step that mixes the shapes Φ of modes of nearly the same pole to Φ T.

    They have no shapes of their own: with Φ T for Φ and T⁻¹ S T⁻ᴴ for S the spectra are the same.
    Added to S as it is, a step would leave that curved valley.
    """
    pole = model.frequency_hz * (1j - model.damping_ratio)
    width = model.frequency_hz * model.damping_ratio
    alike = np.abs(pole[:, None] - pole) < ALIKE * (width[:, None] + width)
    mixing = np.zeros_like(model.force)
    for mode in np.flatnonzero(alike[: model.n_free].sum(axis=1) > 1):
        near = alike[mode]
        step = shapes[:, mode] - model.shapes[:, mode]
        mixing[near, mode] = np.linalg.lstsq(model.shapes[:, near], step, rcond=0.1)[0]
    return mixing


def _mixed(mixing: Complex, force: Complex, change: Complex) -> Complex:
    """Return the force after a change of it and of the shapes."""
    if not mixing.any():
        return np.asarray(force + change)
    change = change + mixing @ force + force @ mixing.conj().T
    back = np.linalg.inv(np.eye(len(mixing)) + mixing)
    return np.asarray(back @ (force + change) @ back.conj().T)
