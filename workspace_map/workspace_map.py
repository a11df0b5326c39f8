"""A modal map: measured poses of one arm, and what they say of every other pose."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from modal_core.errors import MapError
from workspace_map.arm import (
    Arm,
    damping_slopes,
    frequency_slopes,
    local_modes,
    LocalModes,
    PAYLOAD_NUMBERS,
    shape_slopes,
    State,
)
from workspace_map.fit import Centres, fit, Fitted, log_evidence, rows_at
from workspace_map.measured_pose import MeasuredPose
from workspace_map.predicted import PredictedModes
from workspace_map.prior import damping_parts, FREQUENCY, SHAPE, state_of, structure_parts
from workspace_map.regression import Scales
from workspace_map.rows import damping_structure, stacked_slopes

Array = NDArray[np.float64]
LARGEST_STD = 0.08
"""Of log f: half of the 16 to 20 % between neighbouring modes of the shipped arms (medians over
poses). Beyond it a frequency no longer says which mode it is, and a prediction is refused."""


@dataclass(frozen=True)
class WorkspaceMap:
    """What is known of an arm's modes over its workspace.

    Parameters
    ----------
    arm : Arm
        The robot, its sensors and its tool.
    highest_hz : float [Hz]
        Modes below it are predicted.
    measured : tuple of MeasuredPose
        So far.
    scales : tuple of Scales or None
        Of structure and dampers, of a fit; None: sought when first asked.
    centres : Centres or None
        Of an earlier fit to the same poses.
    prior : tuple of Scales or None
        Medians of these; None: those of arms in general.
    before : WorkspaceMap or None
        Map of another arm of the same kind, or of this one with another tool, which is what is
        known before measuring.
    """

    arm: Arm
    highest_hz: float
    measured: tuple[MeasuredPose, ...] = ()
    scales: tuple[Scales, Scales] | None = None
    centres: Centres | None = None
    prior: tuple[Scales, Scales] | None = None
    before: 'WorkspaceMap | None' = None

    def with_measured(self, *poses: MeasuredPose) -> 'WorkspaceMap':
        """Return the map with further poses."""
        return replace(self, measured=(*self.measured, *poses), scales=None, centres=None)

    @cached_property
    def fitted(self) -> Fitted:
        """What the measured poses say; computed once."""
        return fit(
            self.arm,
            self.measured,
            self.highest_hz,
            self._known,
            self.scales,
            self.prior,
            self.centres,
            None if self.before is None else self.before.fitted,
            self.same_tool,
        )

    @property
    def same_tool(self) -> bool:
        """Whether the arm before has the same tool point, and the same masses fixed to it.

        Else what its map found of the payload is the other tool's, and tells nothing of this one.
        """
        return self.before is None or self.arm.same_tool(self.before.arm)

    @property
    def found_scales(self) -> tuple[Scales, Scales]:
        """Scales of the fit."""
        return self.fitted.structure.scales, self.fitted.dampers.scales

    def state(self, q: ArrayLike) -> State:
        """Return the most probable departure of the arm from its model at a pose."""
        angles = np.asarray(q, dtype=float)
        found = self.fitted
        own = state_of(
            self.arm, found.structure.functions(angles), found.dampers.functions(angles)
        )
        return own if self.before is None else self._known(angles).plus(own)

    def predict(self, q: ArrayLike) -> PredictedModes:
        """Return the modes at a pose, measured or not, with their covariance.

        Parameters
        ----------
        q : (n_joints,) array [rad]
            Serial joint angles.

        Raises
        ------
        ModelError
            The pose is outside the robot's range.
        """
        angles = self.arm.model.check_pose(q)
        state = self.state(angles)
        modes = local_modes(self.arm.at(angles), state, self.highest_hz)
        return PredictedModes(
            angles,
            modes.frequency_hz,
            modes.damping_ratio,
            modes.tool_shapes,
            modes.channel_shapes,
            self._covariance(modes),
            modes.residual,
        )

    @property
    def log_evidence(self) -> float:
        """How probable the measured modes are by the map's prior; modes not explained count."""
        return log_evidence(self.fitted, self.measured)

    def worth_of_transfer(self) -> float:
        """Return by how much the map of the other arm explains this one better than the model.

        Returns
        -------
        float
            Difference of log evidence; below 0 the arms are not of the same make.
        """
        alone = replace(self, before=None, scales=None, centres=None)
        return self.log_evidence - alone.log_evidence

    def _covariance(self, modes: LocalModes) -> Array:
        """Return the covariance that `PredictedModes` describes."""
        n, q, tool = modes.n, modes.arm.q, modes.arm.tool[:3]
        of = np.tile(np.eye(3), (n, 1, 1))
        slopes = (frequency_slopes(modes), damping_structure(modes), shape_slopes(modes, of, tool))
        structure, dampers = self.fitted.structure, self.fitted.dampers
        rows = rows_at(structure_parts(self.arm, stacked_slopes(*slopes)), q)
        whole = structure.covariance(rows, rows)
        rows = rows_at(damping_parts(self.arm, damping_slopes(modes)), q)
        factor = np.repeat(self.fitted.factors[0], 5 * n)
        factor[n : 2 * n] = self.fitted.factors[1]
        whole[n : 2 * n, n : 2 * n] += dampers.covariance(rows, rows)
        size = np.linalg.norm(modes.channel_shapes, axis=0)
        white = np.concatenate(
            [
                np.full(n, structure.scales.white[FREQUENCY]),
                np.full(n, dampers.scales.white[0]),
                np.repeat(structure.scales.white[SHAPE] * size, 3),
            ]
        )
        whole[np.diag_indices_from(whole)] += white**2
        return np.asarray(whole * np.outer(factor, factor))

    def predict_surely(self, q: ArrayLike) -> PredictedModes:
        """Return `predict`, or refuse where the map does not know.

        Raises
        ------
        MapError
            The standard deviation of a frequency is beyond `LARGEST_STD`.
        ModelError
            The pose is outside the robot's range.
        """
        found = self.predict(q)
        std = found.frequency_std_hz / found.frequency_hz
        worst = int(np.argmax(std))
        if std[worst] > LARGEST_STD:
            raise MapError(
                'too far from every measured pose',
                where=f'mode at {found.frequency_hz[worst]:.2f} Hz',
                found=f'{100 * std[worst]:.1f} % standard deviation',
                expected=f'<= {100 * LARGEST_STD:g} %',
                advice='measure nearer to it',
            )
        return found

    def _known(self, q: Array) -> State:
        if self.before is None:
            return State.none(self.arm.n_dof, self.arm.n_masses)
        known = self.before.state(q)
        return known if self.same_tool else known.without(PAYLOAD_NUMBERS)
