"""Arms that have what their model lacks, for the map of the workspace.

Every arm has springs, masses and dampers of its own within tolerances, two drives that are
stiffer or softer, two whose stiffness changes with the angle, more damping in two joints, and one
thing more: a payload, a floor that gives way, a link that bends, or a spring over two joints.
"""

from dataclasses import dataclass
import math

import numpy as np
from numpy.typing import NDArray

from abb_emulator.mechanics import ArmEffect, with_effects, with_tolerances
from modal_core.channel import Channel
from modal_core.numbers.indicators import rotate_to_real
from structural_model import FlexibleJointModel, load_layout, load_robot
from workspace_map import Arm, MeasuredPose, ToolPoint

Array = NDArray[np.float64]
ROBOT, TOOL = 'irb6660_205_190', ToolPoint('flange', (0.2, 0.0, 0.0))
HIGHEST_HZ, RECORD_S = 60.0, 60.0
# Of twice the least σ that a record of 60 s allows; and of each entry of a shape of unit length.
BOUNDS, SHAPE_STD = 2.0, 0.01
MORE = ('payload', 'base_compliance', 'link_flexibility', 'rod_spring')


@dataclass(frozen=True)
class HiddenArm:
    """One arm.

    Parameters
    ----------
    model : FlexibleJointModel
        With what does not change with the pose.
    changing : tuple of (joint, size, phase)
        Drives whose stiffness has the factor exp(size sin(angle + phase)).
    kind : str
        The one thing more.
    channels : tuple of Channel
        Sensors.
    seed : int
        Of the measurements' noise.
    """

    model: FlexibleJointModel
    changing: tuple[tuple[str, float, float], ...]
    kind: str
    channels: tuple[Channel, ...]
    seed: int

    def at(self, q: Array) -> FlexibleJointModel:
        """Return the arm as it is at a pose."""
        own, joints = self.model.parameters(), self.model.joint_names
        return self.model.with_parameters(
            {
                name: own[name] * math.exp(size * math.sin(q[joints.index(joint)] + phase))
                for joint, size, phase in self.changing
                for name in (f'joints.{joint}.drive.spring.stiffness',)
            }
        )

    def modes(self, q: Array) -> tuple[Array, Array, Array]:
        """Return frequencies [Hz], damping ratios and unit shapes at the sensors, below 60 Hz."""
        found = self.at(q).damped_modes(q, self.channels)
        below = found.frequency_hz < HIGHEST_HZ
        shapes = rotate_to_real(found.channel_shapes[:, below]).real
        return (
            found.frequency_hz[below],
            found.damping_ratio[below],
            shapes / np.linalg.norm(shapes, axis=0),
        )

    def frf(self, q: Array, frequency_hz: Array) -> NDArray[np.complex128]:
        """Return the receptance of the tool point, (n_frequencies, 3, 3) [m/N]."""
        tool = TOOL.channels()[:3]
        return self.at(q).frf(q, tool, tool, frequency_hz, 'receptance')

    def measured(self, q: Array, number: int = 0) -> MeasuredPose:
        """Return the modes as an identification of a minute finds them, with its noise."""
        frequency, damping, shapes = self.modes(q)
        noise = np.random.default_rng([self.seed, number])
        cycles = frequency * RECORD_S
        # Of Gaussian noise through one mode, at the resolution of the record.
        f_std = BOUNDS * frequency * np.sqrt(damping / (2.0 * np.pi * cycles))
        z_std = BOUNDS * damping / np.sqrt(2.0 * np.pi * damping * cycles)
        off = SHAPE_STD * noise.standard_normal(shapes.shape)
        return MeasuredPose(
            np.asarray(q),
            frequency + f_std * noise.standard_normal(len(frequency)),
            f_std,
            np.abs(damping + z_std * noise.standard_normal(len(frequency))),
            z_std,
            shapes + off,
            np.full_like(shapes, SHAPE_STD),
            RECORD_S,
        )


def known_arm() -> Arm:
    """Return what is known of every hidden arm: the model."""
    return Arm(load_robot(ROBOT), load_layout(ROBOT).channels, TOOL)


def hidden_arm(seed: int, sibling: int | None = None) -> HiddenArm:
    """Draw an arm; one with a sibling is of the same make: other tolerances, all else alike."""
    rng = np.random.default_rng(seed)
    model, channels = load_robot(ROBOT), load_layout(ROBOT).channels
    joints = model.joint_names
    factors = np.exp(rng.choice([-1, 1], 2) * rng.uniform(0.15, 0.5, 2))
    effects: list[dict[str, object]] = [
        {'type': 'joint_stiffness', 'joint': str(name), 'factor': float(factor)}
        for name, factor in zip(rng.choice(joints, 2, replace=False), factors, strict=True)
    ]
    effects += [
        {'type': 'joint_damping', 'joint': str(name), 'factor': float(np.exp(size))}
        for name, size in zip(
            rng.choice(joints[:3], 2, replace=False), rng.uniform(0.3, 1.0, 2), strict=True
        )
    ]
    kind = str(rng.choice(MORE))
    effects.append({'type': kind, **_more(kind, rng)})
    changing = tuple(
        (str(name), float(rng.uniform(0.05, 0.25)), float(rng.uniform(0.0, 2.0 * np.pi)))
        for name in rng.choice(joints, 2, replace=False)
    )
    own = [ArmEffect.from_mapping(effect) for effect in effects]
    made = rng if sibling is None else np.random.default_rng([seed, sibling])
    arm = with_tolerances(with_effects(model, own, channels), 1.0, made)
    return HiddenArm(arm, changing, kind, channels, seed if sibling is None else sibling)


def _more(kind: str, rng: np.random.Generator) -> dict[str, object]:
    if kind == 'payload':
        com = rng.uniform(-0.15, 0.15, 3).tolist()
        return {'link': 'flange', 'mass': float(rng.uniform(8.0, 40.0)), 'com': com}
    if kind == 'base_compliance':
        return {'compliance': float(np.exp(rng.uniform(np.log(5e-9), np.log(1e-7))))}
    if kind == 'link_flexibility':
        compliance = float(rng.uniform(5e-8, 4e-7))
        place = {'position': [0.0, 0.0, 0.35], 'axis': [0.0, 1.0, 0.0]}
        return {'link': 'link_2', 'compliance': compliance, **place}
    return {'stiffness': float(rng.uniform(2e5, 2e6)), 'sign': -1.0}
