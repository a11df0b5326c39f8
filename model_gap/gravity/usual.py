"""What is usual: how far the means may be off on a healthy arm, as their covariance."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from model_gap.cell import Tolerances
from model_gap.gravity.at_rest import AtRest

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class UsualErrors:
    """How exactly gravity is read.

    Parameters
    ----------
    noise_m_s2 : float [m/s²]
        Of a mean: two milliradians of a link that a model puts elsewhere.
    zero_m_s2 : float [m/s²]
        Usual zero offset of an accelerometer: 25 mg (ADXL355 data sheet, rev. B, table 1).
    encoder_rad : float [rad]
        Usual error of a joint's zero position: 0.1 deg, as of a calibrated robot.
    tilt_rad : float [rad]
        How far off level a robot is set up: 0.2 deg about each axis, as by a machine level.
    """

    noise_m_s2: float = 0.02
    zero_m_s2: float = 0.25
    encoder_rad: float = 1.75e-3
    tilt_rad: float = 3.5e-3


USUAL = UsualErrors()


def covariance(
    rest: AtRest, predicted: Array, slopes: Array, tilts: Array, tolerances: Tolerances
) -> Array:
    """Return Σ of all means: noise, and what usual errors of all kinds make of them.

    Parameters
    ----------
    rest : AtRest
        Sensors.
    predicted : (n_records, n_channels) array [m/s²]
        Means.
    slopes, tilts : (n, n_records, n_channels) array
        Their derivatives by the joints' offsets, and by the tilt of the robot.
    tolerances : Tolerances
        Of gains and mounts.
    """
    columns = [USUAL.encoder_rad * slope.ravel() for slope in slopes]
    columns += [USUAL.tilt_rad * slope.ravel() for slope in tilts]
    for row in np.eye(len(rest.channels)):
        columns.append(USUAL.zero_m_s2 * np.broadcast_to(row, predicted.shape).ravel())
        columns.append(tolerances.gain * (predicted * row).ravel())
    turn = float(np.deg2rad(tolerances.sensor_rotation_deg))
    for own in rest.sensors.values():
        columns += [turn * part for part in _turns(rest, predicted, own)]
    wide = np.array(columns)
    return np.asarray(USUAL.noise_m_s2**2 * np.eye(predicted.size) + wide.T @ wide)


def _turns(rest: AtRest, predicted: Array, own: list[int]) -> Iterator[Array]:
    """Yield how the means change when a sensor is turned about x, y and z of its link."""
    directions = np.array([rest.channels[column].direction for column in own])
    # Gravity in the link, as far as the sensor's axes tell it.
    gravity = predicted[:, own] @ np.linalg.pinv(directions).T
    for axis in np.eye(3):
        change = np.zeros_like(predicted)
        change[:, own] = gravity @ np.cross(axis, directions).T
        yield change.ravel()
