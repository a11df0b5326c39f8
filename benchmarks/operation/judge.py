"""What is right and wrong about the modes that were found in a record of the milling arm."""

from collections.abc import Sequence
from dataclasses import dataclass, field
import math

import numpy as np

from benchmarks.operation.scene import Scene
from modal_core.mode import Mode
from modal_core.numbers.assignment import cheapest_pairs
from modal_core.numbers.indicators import mac

LEAST_MAC = 0.8
DEVIATIONS = 4.0
"""Of the least standard deviation of a frequency (Au 2014), added to the half-width."""
ON_LINE = 2e-3
"""How near a line a mode is that stands on it, over its frequency; and a line of the record."""


@dataclass
class Verdict:
    """One record, counted.

    Parameters
    ----------
    n_asked, n_found, n_false, n_lines : int
        Modes asked for, those found, modes that are none, and lines reported as modes.
    f_error, z_error : list of float
        Relative errors of the modes found.
    inside : list of (f, ζ)
        Whether the truth is within 2σ; None without σ.
    cpu_s : float [s]
    refused : str
        Why nothing came out.
    """

    n_asked: int = 0
    n_found: int = 0
    n_false: int = 0
    n_lines: int = 0
    f_error: list[float] = field(default_factory=list)
    z_error: list[float] = field(default_factory=list)
    inside: list[tuple[bool | None, bool | None]] = field(default_factory=list)
    cpu_s: float = 0.0
    refused: str = ''


def judge(modes: Sequence[Mode], scene: Scene) -> Verdict:
    """Hold modes against those of the arm.

    A mode found is one of the arm's when its frequency is within the half-width of that one and
    four least deviations, and the MAC of the shapes is 0.8 at least.  Modes of the arm that are
    not asked for are no false ones.
    """
    verdict = Verdict(n_asked=int(scene.asked.sum()))
    hz, zeta = scene.frequency_hz, scene.damping_ratio
    below = [mode for mode in modes if not mode.harmonic]
    partner = _partners(below, scene)
    for mode, true in zip(below, partner, strict=True):
        if true >= 0:
            if scene.asked[true]:
                verdict.n_found += 1
                f_error = mode.frequency_hz - hz[true]
                z_error = mode.damping_ratio - zeta[true]
                verdict.f_error.append(float(f_error / hz[true]))
                verdict.z_error.append(float(z_error / zeta[true]))
                verdict.inside.append(
                    (
                        _within(f_error, mode.frequency_std_hz),
                        _within(z_error, mode.damping_ratio_std),
                    )
                )
        elif _on_line(mode.frequency_hz, scene):
            verdict.n_lines += 1
        else:
            verdict.n_false += 1
    return verdict


def _partners(modes: Sequence[Mode], scene: Scene) -> list[int]:
    found = [-1] * len(modes)
    if not modes:
        return found
    hz, zeta = scene.frequency_hz, scene.damping_ratio
    least = np.sqrt(zeta / (2.0 * np.pi * hz * scene.samples.duration_s))
    reach = hz * np.hypot(zeta, DEVIATIONS * least)
    away = (np.array([mode.frequency_hz for mode in modes])[:, None] - hz) / reach
    alike = mac(np.column_stack([mode.shape for mode in modes]), scene.shapes)
    allowed = (np.abs(away) <= 1.0) & (alike >= LEAST_MAC)
    cost = np.where(allowed, away**2 + (1.0 - alike), 1e6)
    for row, column in zip(*cheapest_pairs(cost), strict=True):
        if allowed[row, column]:
            found[int(row)] = int(column)
    return found


def _within(error: float, std: float) -> bool | None:
    return bool(abs(error) < 2.0 * std) if math.isfinite(std) and std > 0.0 else None


def _on_line(hz: float, scene: Scene) -> bool:
    near = max(ON_LINE * hz, 1.0 / scene.samples.duration_s)
    return any(min(ends) - near < hz < max(ends) + near for ends in scene.lines_hz)
