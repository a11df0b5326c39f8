"""Figs. 1(b) and 3: shapes over 42 points, measured in three batches of 14 and merged.

The paper's batches belong together by the hammer, whose force is measured in each.  Without it two
further sensors stay in place, as with any set-ups of roving sensors.

Run ``python -m examples.paper.batches``.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
import typer

import autonomous_modal_analysis as ama
from examples.paper.cell import (
    HIGHEST_HZ,
    LOWEST_HZ,
    matched,
    plan_pulses,
    Record,
    ROBOT,
    robot,
    SAMPLE_RATE_HZ,
    shake,
    STILL_NOISE,
    Truth,
    truth,
)
from examples.paper.drawing import COLOURS, GREY, INK, panels, save
from examples.paper.output import Finding, PARTLY, REPRODUCED, show_findings, show_table
from modal_core.channel import Sensor, SensorLayout
from modal_core.mode import Mode, ModeSet
from modal_core.numbers.indicators import mac
from structural_model import load_layout
from structural_model.flexible_joint_model import FlexibleJointModel

Array = NDArray[np.float64]
SEED = 2025
DURATION_S = 60.0
SECTION = '4 Shapes'
REGIONS = ('P1', 'P2', 'P3')
N_BATCHES = 3
# Where all points are measured at once, too.
AT_ONCE = 'P2'
# Link, how many of the 42 points it has (as the paper spreads them), and the line around which
# they wind, with its distance [m]; the paper's own places are not published.
POINTS = (
    ('base_link', 4, (-0.45, 0.0, 0.15), (0.40, 0.0, 0.15), 0.30),
    ('link_1', 7, (0.0, 0.0, -0.35), (0.20, 0.0, 0.10), 0.35),
    ('link_2', 8, (0.0, 0.0, 0.05), (0.0, 0.0, 0.65), 0.15),
    ('link_3', 8, (-0.35, 0.0, 0.22), (0.25, 0.0, 0.28), 0.22),
    ('link_4', 6, (0.20, 0.0, 0.0), (0.80, 0.0, 0.0), 0.12),
    ('link_5', 4, (0.0, -0.08, 0.0), (0.0, 0.08, 0.0), 0.12),
    ('flange', 5, (0.03, 0.0, 0.0), (0.30, 0.0, 0.0), 0.07),
)
GOLDEN_ANGLE = np.pi * (3.0 - np.sqrt(5.0))
STAYING = ('elbow_rear', 'spindle')
N_DRAWN = 4
DRAWN_M = 0.35
# A shape with less is not that of the true mode everywhere (assumed, as is usual).
GOOD_MAC = 0.95


@dataclass(frozen=True)
class Shapes:
    """Modes that one way of measuring found, those seen at all 42 points, and what is true."""

    pose: str
    way: str
    layout: SensorLayout
    modes: ModeSet
    truth: Truth

    @property
    def at_once(self) -> bool:
        """All points in one record."""
        return not self.way.startswith(str(N_BATCHES))

    @property
    def pairs(self) -> dict[int, Mode]:
        """Identified mode of each true one."""
        rows = [self.modes.channel_names.index(c.name) for c in self.layout.channels]
        whole = [replace(mode, shape=mode.shape[rows]) for mode in self.modes]
        return matched(tuple(m for m in whole if np.isfinite(m.shape).all()), self.truth)

    @property
    def likeness(self) -> Array:
        """MAC of each found mode with the true one."""
        return np.array(
            [
                mac(self.truth.channel_shapes[:, [i]], mode.shape[:, None])[0, 0]
                for i, mode in self.pairs.items()
            ]
        )

    @property
    def off(self) -> Array:
        """Frequency of each found mode over the true one, less 1."""
        true_hz = self.truth.mean_hz
        return np.array([mode.frequency_hz / true_hz[i] - 1 for i, mode in self.pairs.items()])


def all_points() -> tuple[Sensor, ...]:
    """Return the 42 points, each link's wound around its line."""
    found = []
    for link, count, start, end, distance_m in POINTS:
        along = np.subtract(end, start)
        across = np.linalg.svd(along[None, :])[2][1:]
        for number in range(count):
            turn = GOLDEN_ANGLE * number
            off = distance_m * (np.cos(turn) * across[0] + np.sin(turn) * across[1])
            x, y, z = (start + along * (number + 0.5) / count + off).tolist()
            found.append(Sensor(f'{link}_{number + 1}', link, (x, y, z)))
    return tuple(found)


def batches() -> list[SensorLayout]:
    """Return the layouts of the three batches: every third point, and those that stay."""
    staying = tuple(s for s in load_layout(ROBOT) if s.name in STAYING)
    points = all_points()
    return [SensorLayout((*staying, *points[k::N_BATCHES])) for k in range(N_BATCHES)]


def measure(
    model: FlexibleJointModel,
    pose: str,
    layout: SensorLayout,
    seed: int,
    duration_s: float = DURATION_S,
) -> tuple[ama.ModalResult, Record]:
    """Shake the arm with sensors at some points, and identify it."""
    plan = plan_pulses(model, pose, 0.0, 0.0, seed, duration_s, **STILL_NOISE)
    record = shake(model, plan, seed, channels=layout.channels)
    names = [channel.name for channel in layout.channels]
    found = ama.identify(
        record.acceleration,
        SAMPLE_RATE_HZ,
        channel_names=names,
        layout=layout,
        window_s=np.floor(duration_s),
        min_frequency_hz=LOWEST_HZ,
        max_frequency_hz=HIGHEST_HZ,
    )
    return found, record


def shapes(
    model: FlexibleJointModel, pose: str, seed: int = SEED, duration_s: float = DURATION_S
) -> list[Shapes]:
    """Measure a pose in three batches, each shaken anew, and, where asked for, at once."""
    parts = [
        measure(model, pose, layout, seed + number, duration_s)
        for number, layout in enumerate(batches(), start=1)
    ]
    points = all_points()
    layout = SensorLayout((*(s for s in load_layout(ROBOT) if s.name in STAYING), *points))
    modes = ama.merge([found for found, _ in parts], layout=layout).modes
    real = truth(model, parts[0][1], n_poses=2, channels=layout.channels)
    found = [Shapes(pose, f'{N_BATCHES} batches of 14', layout, modes, real)]
    if pose == AT_ONCE:
        whole, _ = measure(model, pose, layout, seed, duration_s)
        found.append(Shapes(pose, f'{len(points)} at once', layout, whole.modes, real))
    return found


def tabulate(found: list[Shapes], keep: str) -> None:
    show_table(
        f'Shapes over 42 points, {DURATION_S:g} s a record, seed {SEED}',
        ('pose, points', 'modes', 'not real', 'largest off [%]', 'least MAC', 'median MAC'),
        [
            (
                f'{each.pose}, {each.way}',
                f'{len(each.pairs)} of {len(each.truth.frequency_hz)}',
                len(each.modes) - len(each.pairs),
                f'{100 * np.max(np.abs(each.off)):.2f}',
                f'{np.min(each.likeness):.3f}',
                f'{np.median(each.likeness):.3f}',
            )
            for each in found
        ],
        keep=keep,
    )


def findings(found: list[Shapes]) -> list[Finding]:
    """Return what became of the batches."""
    merged = [each for each in found if not each.at_once]
    n_found, n_true = (
        sum(len(part) for part in parts)
        for parts in ([e.pairs for e in merged], [e.truth.frequency_hz for e in merged])
    )
    least = min(np.min(each.likeness) for each in merged)
    (whole,) = (each for each in found if each.at_once)
    return [
        Finding(
            'Figs. 1, 3: 42 points in three batches of 14 give the shapes of the whole arm',
            f'{n_found} of {n_true} modes at three poses, MAC with the true shape {least:.2f} at'
            f' least; all points at once at {AT_ONCE}: {len(whole.pairs)} of'
            f' {len(whole.truth.frequency_hz)}, {np.min(whole.likeness):.2f}',
            REPRODUCED if least >= GOOD_MAC and n_found >= 0.9 * n_true else PARTLY,
        )
    ]


def draw(model: FlexibleJointModel, found: list[Shapes]) -> None:
    """Draw the first modes of every pose: the arm at rest, the true shape, the identified one."""
    figure, axes = panels(N_DRAWN, len(found), (9.0, 11.0))
    for column, each in enumerate(found):
        for row in range(N_DRAWN):
            _draw_mode(axes[row][column], model, each, row)
    bottom = axes[0][0]
    bottom.plot([], [], color=GREY, lw=3, label='at rest')
    bottom.plot([], [], color=INK, lw=1, ls='--', label='true shape')
    bottom.plot([], [], 'o-', color=COLOURS[0], ms=3, lw=0.8, label='identified, merged')
    figure.legend(loc='outside lower center', ncols=3)
    save(
        figure, 'shapes_drawn', 'Fig. 3 in kind: first four modes at P1, P2 and P3, over 42 points'
    )


def _draw_mode(axis: object, model: FlexibleJointModel, each: Shapes, index: int) -> None:
    q, mode = model.pose(each.pose), each.pairs.get(index)
    true = model.modes(q, each.layout.channels)
    places = [(s.frame_id, np.array(s.position_m)) for s in each.layout]
    rest = model.geometry.positions([q], places)[0]
    moved = _in_base(model, q, each.layout, true.channel_shapes[:, index])
    scale = DRAWN_M / np.max(np.linalg.norm(moved, axis=1))
    axis.plot(*_seen(model.frame_positions(q)), color=GREY, lw=3, solid_capstyle='round')
    bent = model.deflected(q, scale * true.shapes[:, index])
    axis.plot(*_seen(bent), color=INK, lw=1, ls='--')
    likeness = 'not identified'
    if mode is not None:
        shape = mode.shape
        factor = np.vdot(shape, true.channel_shapes[:, index]) / np.vdot(shape, shape)
        found = rest + scale * _in_base(model, q, each.layout, np.real(factor * shape))
        for start, end in zip(rest, found, strict=True):
            axis.plot(*_seen(np.array([start, end])), color=COLOURS[0], lw=0.8)
        axis.plot(*_seen(found), 'o', color=COLOURS[0], ms=2.5)
        likeness = f'MAC {mac(true.channel_shapes[:, [index]], shape[:, None])[0, 0]:.3f}'
    axis.set_title(f'{each.pose}, mode {index + 1}: {true.frequency_hz[index]:.1f} Hz, {likeness}')
    axis.set(aspect='equal', xticks=[], yticks=[], xlim=(-0.7, 2.3), ylim=(-0.2, 2.3))
    axis.grid(visible=False)
    for side in ('left', 'bottom'):
        axis.spines[side].set_visible(False)


def _in_base(model: FlexibleJointModel, q: Array, layout: SensorLayout, motion: Array) -> Array:
    """Return motion of the channels, three a sensor, in axes of the base, (n_sensors, 3)."""
    turned = model.kinematics.motion(q).rotation[0]
    rows = []
    for sensor, local in zip(layout, motion.reshape(-1, 3), strict=True):
        joint, placement = model.assembly.link(sensor.frame_id)
        rows.append(turned[joint] @ placement.rotation @ local)
    return np.array(rows)


def _seen(points: Array) -> tuple[Array, Array]:
    """Return where points are in the picture: seen from the side, y into the picture."""
    return points[:, 0] + 0.45 * points[:, 1], points[:, 2] + 0.3 * points[:, 1]


def main(seed: int = SEED) -> None:
    model = robot()
    found = [each for pose in REGIONS for each in shapes(model, pose, seed)]
    tabulate(found, 'batches' if seed == SEED else '')
    show_findings(SECTION, findings(found), keep=seed == SEED)
    if seed == SEED:
        draw(model, [each for each in found if not each.at_once])


if __name__ == '__main__':
    typer.run(main)
