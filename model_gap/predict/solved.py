"""How the arm moves in every record under a cell."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from model_gap.campaign import Complex
from model_gap.cell import CellModel, PoseSystem
from model_gap.predict.local_torques import Torques


@dataclass(frozen=True)
class RecordState:
    """Motor motion and deflection of one record under a cell, on bins and their neighbours.

    Parameters
    ----------
    omega : (3 n_bins,) array [rad/s]
        Flattened triples.
    acceleration, shift : (n_joints, 3 n_bins) complex array
        Motor motion behind the inputs' steps.
    deflection : (n_dof, 3 n_bins) complex array
        Of the flexible degrees of freedom.
    end_shift, end_speed : (n_dof,) array
        What the motors leave moving when the record ends, scaled as spectra are: the spectrum of
        x' is that of x times iω, and this beside it.
    """

    omega: NDArray[np.float64]
    acceleration: Complex
    shift: Complex
    deflection: Complex
    end_shift: NDArray[np.float64]
    end_speed: NDArray[np.float64]


@dataclass(frozen=True)
class Solved:
    """How the arm moves in every record under a cell.

    Parameters
    ----------
    cell : CellModel
        Arm, torques and inputs.
    systems : list of PoseSystem
        Per pose.
    torques : Torques
        The nonlinear ones.
    states : list of RecordState
        Per record.
    readings : list of (n_channels, n_bins) complex array
        What the sensors read, before the outputs' steps.
    patterns : list of (n_patterns, n_rows) array
        What free tones can do, per record; none without tones.
    """

    cell: CellModel
    systems: list[PoseSystem]
    torques: Torques
    states: list[RecordState]
    readings: list[Complex]
    patterns: list[NDArray[np.float64]]


def motion_of(cell: CellModel) -> CellModel:
    """Return what of a cell the arm's motion depends on: not what lies behind the sensors.

    Tones, and torques on a measured twist, follow what sensors read.
    """
    return cell if cell.tones or cell.forces else replace(cell, outputs=())
