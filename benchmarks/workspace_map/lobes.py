"""Limits of chatter against published examples and against simulations in time.

The arm at random poses with two modes of a spindle, random cutters and speeds.  What is predicted
from the true modes is held against growth in time by an integrator of its own; what is predicted
from modes with errors of their σ tells whether the stated band holds.
"""

from collections.abc import Iterator
from dataclasses import dataclass
import math

import numpy as np
from numpy.typing import NDArray

from benchmarks.table import Line
from machining.cut import Coefficients, Cut, Cutter, Engagement
from machining.stability import (
    DepthSearch,
    Limits,
    limits_of_modes,
    limits_of_periods,
    sampled_limits,
)
from modal_core.channel import Channel
from modal_core.tool_modes import ToolModes
from modal_core.work.compiled import compiled
from structural_model import load_robot

Real = NDArray[np.float64]
ROBOT, FIRST_SEED = 'irb6660_205_190', 910_000
POINTS, FEW_POINTS = 50, 8
TIP_M = (0.35, 0.0, 0.0)
HIGHEST_HZ = 50.0
"""Of the arm's modes; above it the spindle's own."""
SIMULATED_S = 4.0
STEPS = 120
SHARES = (0.8, 0.92, 1.0, 1.08, 1.2)
F_STD, ZETA_STD, SHAPE_STD, MATERIAL_STD = 0.003, 0.05, 0.03, 0.05
"""Errors of what is measured: those of a tap test or a map, and of a coefficient."""
N_SAMPLES = 40
WITHIN = 0.10
WIDE = DepthSearch(2e-5, 0.06, 1.12)
SHALLOW, DEEP, RATIO, PRECISION = 0.4, 4.0, 1.25, 0.01
"""Where limits of samples are looked for, by that of the modes as measured."""

STANDARD = {
    'slot': (Engagement.slot(), (0.677, 0.3226, 2.148, 0.387, 0.690, 1.418)),
    'half, up': (Engagement.up(0.5), (0.406, 0.2137, 1.061, 0.259, 0.397, 1.185)),
    'half, down': (Engagement.down(0.5), (0.798, 2.105, 0.613, 2.597, 1.620, 0.720)),
    '5 %, up': (Engagement.up(0.05), (3.496, 1.657, 6.243, 1.887, 4.424, 3.774)),
    '5 %, down': (Engagement.down(0.05), (2.161, 4.088, 1.679, math.inf, 1.295, 2.296)),
}
SPEEDS = (8000, 10000, 12000, 15000, 18000, 20000)
MEAN = (1.419, 1.945, 1.095, 1.339, 4.032, 2.793, 1.958)
MEAN_SPEEDS = (4000, 6000, 8000, 10000, 12000, 14000, 15000)


@dataclass(frozen=True)
class Point:
    """One pose, cutter and speed."""

    modes: ToolModes
    cut: Cut
    speed_rpm: float


def point(seed: int) -> Point:
    """Draw one."""
    rng = np.random.default_rng(seed)
    model = load_robot(ROBOT)
    pose = model.pose('P1') + rng.uniform(-0.5, 0.5, model.n_joints)
    angle = rng.uniform(0.0, 2.0 * np.pi)
    feed = np.array([0.0, np.cos(angle), np.sin(angle)])
    axes = np.array([feed, np.cross([-1.0, 0.0, 0.0], feed), [-1.0, 0.0, 0.0]])
    channels = [
        Channel(name, 'flange', tuple(axis), TIP_M) for name, axis in zip('xyz', axes, strict=True)
    ]
    found, damped = model.modes(pose, channels), model.damped_modes(pose)
    low = found.frequency_hz < HIGHEST_HZ
    hz = np.sort(rng.uniform(500.0, 900.0, 2))
    turn = rng.uniform(0.0, np.pi)
    across = np.array([[np.cos(turn), np.sin(turn), 0.0], [-np.sin(turn), np.cos(turn), 0.0]])
    spindle = across / np.sqrt(rng.uniform(0.5, 3.0, 2))[:, None]
    modes = ToolModes(
        np.concatenate([found.frequency_hz[low], hz]),
        np.concatenate([damped.damping_ratio[low], rng.uniform(0.02, 0.04, 2)]),
        np.vstack([found.channel_shapes.T[low], spindle]),
    )
    way = Engagement.up if rng.random() < 0.5 else Engagement.down
    tangential = rng.uniform(600e6, 900e6)
    cut = Cut(
        Cutter(int(rng.integers(2, 5)), 0.016),
        way(rng.uniform(0.15, 1.0)),
        Coefficients(tangential, rng.uniform(0.2, 0.4) * tangential),
    )
    return Point(modes, cut, float(rng.uniform(4000.0, 16000.0)))


def limit_in_time(at: Point, near_m: float) -> float:
    """Return the depth at which vibration neither grows nor falls in time, near a depth; NaN."""
    found = np.array([_growth(at, share * near_m) for share in SHARES])
    for low in range(len(SHARES) - 1):
        if found[low] < 0.0 <= found[low + 1]:
            part = found[low] / (found[low] - found[low + 1])
            return near_m * (SHARES[low] + part * (SHARES[low + 1] - SHARES[low]))
    return math.nan


def _growth(at: Point, depth_m: float) -> float:
    period_s = at.cut.cutter.tooth_period_s(at.speed_rpm)
    gain = np.array(
        [_gain(at, at.cut.cutter.pitch_rad * i / (2 * STEPS)) for i in range(2 * STEPS + 1)]
    )
    sizes = _simulate(
        2.0 * np.pi * at.modes.frequency_hz,
        at.modes.damping_ratio,
        np.ascontiguousarray(at.modes.shape[:, :2]),
        depth_m * gain,
        period_s / STEPS,
        math.ceil(SIMULATED_S / period_s),
    )
    return float(np.mean(sizes[len(sizes) // 2 :]))


def _gain(at: Point, turned: float) -> Real:
    """Return force over displacement per depth at an angle of the spindle, (2, 2)."""
    found = np.zeros((2, 2))
    material = at.cut.coefficients
    for tooth in range(at.cut.cutter.n_teeth):
        angle = (turned + tooth * at.cut.cutter.pitch_rad) % (2.0 * np.pi)
        if at.cut.engagement.entry_rad <= angle <= at.cut.engagement.exit_rad:
            s, c = np.sin(angle), np.cos(angle)
            t, r = material.tangential_pa, material.radial_pa
            found += np.outer([-t * c - r * s, t * s - r * c], [s, c])
    return found


@compiled
def _simulate(
    omega: Real, ratio: Real, shape: Real, gain: Real, step_s: float, n_periods: int
) -> Real:
    """Integrate by Runge and Kutta; return the log growth of each tooth period."""
    n, n_half = len(omega), len(gain)
    x, v = np.ones(n) / omega, np.zeros(n)
    past = np.zeros((n_half, 2))
    for row in range(n_half):
        past[row] = x @ shape
    sizes = np.zeros(n_periods)
    rate_x, rate_v = np.zeros((4, n)), np.zeros((4, n))
    lag = np.array([0.0, 0.5, 0.5, 1.0])
    for period in range(n_periods):
        new = np.empty_like(past)
        new[0] = x @ shape
        for step in range((n_half - 1) // 2):
            for part in range(4):
                here_x, here_v = x, v
                if part:
                    here_x = x + lag[part] * step_s * rate_x[part - 1]
                    here_v = v + lag[part] * step_s * rate_v[part - 1]
                half = 2 * step + int(2 * lag[part])
                force = gain[half] @ (here_x @ shape - past[half])
                rate_x[part] = here_v
                rate_v[part] = shape @ force - omega**2 * here_x - 2 * ratio * omega * here_v
            old_x, old_v = x, v
            x = x + step_s / 6 * (rate_x[0] + 2 * rate_x[1] + 2 * rate_x[2] + rate_x[3])
            v = v + step_s / 6 * (rate_v[0] + 2 * rate_v[1] + 2 * rate_v[2] + rate_v[3])
            new[2 * step + 1] = ((old_x + x) / 2 + step_s / 8 * (old_v - v)) @ shape
            new[2 * step + 2] = x @ shape
        size = np.sqrt(np.sum((omega * x) ** 2 + v**2))
        x, v, past = x / size, v / size, new / size
        sizes[period] = np.log(size)
    return sizes


def measured(true: ToolModes, rng: np.random.Generator) -> ToolModes:
    """Return modes with errors of the stated σ, and that σ."""
    size = np.linalg.norm(true.shape, axis=1, keepdims=True)
    std = np.hstack(
        [
            np.full_like(size, F_STD),
            np.full_like(size, ZETA_STD),
            np.repeat(SHAPE_STD * size, 3, 1),
        ]
    ).ravel()
    off = true.with_parameters(true.parameters + std * rng.standard_normal(len(std)))
    return ToolModes(off.frequency_hz, off.damping_ratio, off.shape, np.diag(std**2))


def band_of(at: Point, seed: int) -> tuple[float, float]:
    """Return where 95 % of the limits lie by what was measured."""
    rng = np.random.default_rng(seed + 1_000_000)
    modes = measured(at.modes, rng)
    material = at.cut.coefficients
    off = math.exp(MATERIAL_STD * rng.standard_normal())
    known = Coefficients(
        material.tangential_pa * off, material.radial_pa * off, relative_std=MATERIAL_STD
    )
    cut = Cut(at.cut.cutter, at.cut.engagement, known)

    (near,) = limits_of_periods(modes, cut, [at.speed_rpm], WIDE, 0.5).depth_m
    quick = DepthSearch(SHALLOW * near, DEEP * near, RATIO, PRECISION)

    def limits_of(each: ToolModes, other: Cut) -> Limits:
        return limits_of_periods(each, other, [at.speed_rpm], quick, 0.5)

    depth = sampled_limits(modes, cut, limits_of, N_SAMPLES, rng).depth_m[:, 0]
    low, high = np.quantile(depth, [0.025, 0.975], method='inverted_cdf')
    return float(low), float(high)


def standard_rows() -> Iterator[Line]:
    """Yield published examples."""
    mass = np.array([0.03993])
    one = ToolModes(np.array([922.0]), np.array([0.011]), np.array([[1.0, 0, 0]]) / np.sqrt(mass))
    for name, (engagement, expected) in STANDARD.items():
        cut = Cut(Cutter(2, 0.01), engagement, Coefficients(600e6, 200e6))
        found = limits_of_periods(one, cut, SPEEDS, DepthSearch(5e-5, 8e-3)).depth_m * 1e3
        known = np.isfinite(expected)
        error = np.abs(found[known] / np.array(expected)[known] - 1.0).max()
        what, said = f'standard example, {name}: largest error', f'{100 * error:.2f} %'
        yield Line(what, said, reach='1 %', met=bool(error < 0.01))
    stiffness, hz = np.array([5.59e6, 5.715e6]), np.array([603.0, 666.0])
    shape = np.eye(2, 3) / np.sqrt(stiffness / (2 * np.pi * hz) ** 2)[:, None]
    weck = ToolModes(hz, np.array([0.039, 0.035]), shape)
    cut = Cut(Cutter(3, 0.02), Engagement.up(0.5), Coefficients(600e6, 42e6))
    error = np.abs(limits_of_modes(weck, cut, MEAN_SPEEDS).depth_m * 1e3 / MEAN - 1.0).max()
    said = f'{100 * error:.2f} %'
    yield Line('zeroth order, two modes: largest error', said, reach='1 %', met=bool(error < 0.01))


def rows(n_points: int) -> Iterator[Line]:
    """Yield the lines of the table."""
    yield from standard_rows()
    errors, inside, mean_errors = [], [], []
    for seed in range(FIRST_SEED, FIRST_SEED + n_points):
        at = point(seed)
        (limit,) = limits_of_periods(at.modes, at.cut, [at.speed_rpm], WIDE).depth_m
        if not math.isfinite(limit):
            continue
        true = limit_in_time(at, limit)
        (mean,) = limits_of_modes(at.modes, at.cut, [at.speed_rpm]).depth_m
        low, high = band_of(at, seed)
        errors.append(abs(limit / true - 1.0) if math.isfinite(true) else math.inf)
        mean_errors.append(abs(mean / true - 1.0) if math.isfinite(true) else math.inf)
        inside.append(low <= true <= high)
    found, mean_found = np.array(errors), np.array(mean_errors)
    n = len(found)
    yield Line(
        f'limit against simulation in time, {n} poses and speeds: within 10 %',
        ours=f'{int(np.sum(found <= WITHIN))} of {n}',
        reach='all',
        met=bool((found <= WITHIN).all()),
    )
    largest = float(found.max())
    said = f'{100 * largest:.1f} %'
    yield Line('the same: largest error', said, reach='10 %', met=largest <= WITHIN)
    held = f'{int(np.sum(mean_found <= WITHIN))} of {n}'
    yield Line('the same by the zeroth order alone: within 10 %', held)
    held = f'{int(np.sum(inside))} of {n}'
    enough = bool(np.mean(inside) >= 0.9)
    yield Line('true limit inside the 95 % band', held, reach='≥ 90 %', met=enough)
