"""Residuals of all records, whitened where torques follow a measured twist."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from model_gap.campaign import Complex
from model_gap.cell import CellModel, joint_vector
from model_gap.predict.error_covariance import error_covariance, ErrorCovariance, whitened
from model_gap.predict.posed_records import PosedRecords
from model_gap.predict.solved import Solved


@dataclass(frozen=True, eq=False)
class Whitening:
    """Covariances of what errors of torques make of the readings.

    Parameters
    ----------
    posed : PosedRecords
        What was recorded.
    covariances : tuple of ErrorCovariance
        Per record; none where no torque sees a measured twist: everything stays as it is.
    """

    posed: PosedRecords
    covariances: tuple[ErrorCovariance, ...]

    @classmethod
    def of(cls, posed: PosedRecords, solved: Solved, cell: CellModel) -> 'Whitening':
        """Return that of a cell's torques behind its outputs."""
        systems = solved.systems
        sources = (*(item.errors for item in cell.held), solved.torques.errors)
        errors = {key: error for source in sources for key, error in source.items()}
        if not errors:
            return cls(posed, ())
        places = {
            joint: joint_vector(posed.model, joint, systems[0].dof_names) for joint, _ in errors
        }
        found = []
        for index, (item, group) in enumerate(zip(posed.records, posed.groups, strict=True)):
            omega = item.omega[:, 1]
            responses, samples = [], []
            for joint, place in places.items():
                responses.append(cell.seen(omega, systems[group].response(omega, place)))
                samples.append(errors[joint, index])
            found.append(error_covariance(responses, samples, item))
        return cls(posed, tuple(found))

    def changes(self, changes: Sequence[Complex]) -> list[Complex]:
        """Return changes of the readings, whitened as residuals are."""
        if not self.covariances:
            return list(changes)
        records = self.posed.records
        count = sum(item.count for item in records)
        growth = np.exp(0.5 * sum(item.log_det for item in self.covariances) / count)
        return [
            growth * whitened(change, covariance, item)
            for change, covariance, item in zip(changes, self.covariances, records, strict=True)
        ]

    def prediction(self, readings: list[Complex]) -> list[Complex]:
        """Return readings such that what is measured beyond them is the whitened residual."""
        if not self.covariances:
            return readings
        measured = [item.measured for item in self.posed.records]
        rest = [one - two for one, two in zip(measured, readings, strict=True)]
        return [one - two for one, two in zip(measured, self.changes(rest), strict=True)]
