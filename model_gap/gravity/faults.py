"""What may be wrong with a sensor or an encoder so that gravity reads wrong."""

from dataclasses import dataclass
from enum import Enum

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from modal_reports import with_sigma

Array = NDArray[np.float64]


class Kind(Enum):
    """Of fault."""

    ENCODER = 'encoder_offset'
    TILT = 'tilt'
    ZERO = 'zero_offset'
    UNIT = 'unit_g'
    GAIN = 'gain'
    AXES = 'axes'
    TURNED = 'turned'
    SENSORS = 'sensors_exchanged'
    JOINTS = 'joints_exchanged'
    UNTOLD = 'untold'


# Kinds that model and campaign are put right of before the dynamics.
PUT_RIGHT = frozenset({Kind.ENCODER, Kind.TILT, Kind.UNIT, Kind.SENSORS, Kind.JOINTS})

# What a fault costs in log evidence for each number that it frees: the logarithm of how much
# narrower the means make it than what is possible (10 deg or 1 g, down to some hundredths of it).
COST = {
    Kind.ENCODER: 5.0,
    Kind.TILT: 10.0,
    Kind.ZERO: 5.0,
    Kind.UNIT: 1.0,
    Kind.GAIN: 5.0,
    Kind.AXES: 4.0,
    Kind.TURNED: 15.0,
    Kind.SENSORS: 4.0,
    Kind.JOINTS: 4.0,
}


@dataclass(frozen=True)
class Fault:
    """Something that reads wrong.

    Parameters
    ----------
    kind : Kind
        What.
    place : str
        Joint, sensor or channel; of an exchange both, for people.
    columns : tuple of int
        Channels it changes, of exchanged sensors those of one, then of the other; of an encoder
        the joint's number, of exchanged joints both; none of a tilt.
    values : tuple of float
        Offset [rad] or [m/s²], gain, tilt about x and y [rad], or the matrix that mixes a sensor's
        axes, row by row; of what is untold the root mean square that is left [m/s²].
    sigma : float
        Of an offset or gain.
    gain : float
        Log evidence.
    rival : Fault or None
        What explains the means nearly as well.
    telling : str
        What to record to tell the two apart.
    between : tuple of str
        Of an exchange the names of the two.
    """

    kind: Kind
    place: str
    columns: tuple[int, ...]
    values: tuple[float, ...] = ()
    sigma: float = 0.0
    gain: float = 0.0
    rival: 'Fault | None' = None
    telling: str = ''
    between: tuple[str, ...] = ()

    @classmethod
    def exchange(cls, kind: Kind, between: tuple[str, str], columns: tuple[int, ...]) -> 'Fault':
        """Return that two sensors or two joints are exchanged."""
        return cls(kind, ' and '.join(between), columns, between=between)

    @property
    def matrix(self) -> Array:
        """How it mixes a sensor's axes."""
        return np.array(self.values).reshape(len(self.columns), -1)

    def words(self) -> str:
        """Return it as a plain sentence, without a full stop."""
        if self.kind is Kind.ENCODER:
            size = with_sigma(np.degrees(self.values[0]), np.degrees(self.sigma), 'deg')
            said = f'the encoder of {self.place} reads wrong: the joint stands {size} further'
        elif self.kind is Kind.TILT:
            about_x, about_y = np.degrees(self.values)
            said = (
                f'the robot stands {about_x:+.2f}° about x and {about_y:+.2f}° about y off level'
            )
        elif self.kind is Kind.ZERO:
            said = f'{self.place} has a zero offset of {with_sigma(*self._size(), "m/s²")}'
        elif self.kind is Kind.UNIT:
            said = f'sensor {self.place} reads in g, not in m/s²'
        elif self.kind is Kind.GAIN:
            said = f'{self.place} reads {with_sigma(*self._size())} times what it should'
        elif self.kind is Kind.AXES:
            said = f'sensor {self.place} has its axes exchanged or reversed: {self._axes()}'
        elif self.kind is Kind.SENSORS:
            said = f'sensors {self.place} are exchanged in the recordings'
        elif self.kind is Kind.JOINTS:
            said = f'joints {self.place} are exchanged in the recordings'
        elif self.kind is Kind.UNTOLD:
            said = (
                f'gravity reads otherwise by {self.values[0]:.2g} m/s² rms, most at {self.place},'
                ' and no few faults of sensors, encoders or mounting explain that: are poses,'
                ' model and layout those of the recordings?'
            )
        else:
            angle = np.degrees(Rotation.from_matrix(self.matrix).magnitude())
            said = f'sensor {self.place} is mounted turned by {angle:.1f}°'
        return said + (f' (or {self.rival.words()})' if self.rival else '')

    @property
    def halves(self) -> tuple[list[int], list[int]]:
        """Columns of the one and of the other that are exchanged."""
        half = len(self.columns) // 2
        return list(self.columns[:half]), list(self.columns[half:])

    def exchanged(self, rows: Array) -> Array:
        """Return an array, (n, n_columns), with the columns of both exchanged."""
        one, two = self.halves
        found = rows.copy()
        found[:, one], found[:, two] = rows[:, two], rows[:, one]
        return found

    def _size(self) -> tuple[float, float]:
        return self.values[0], self.sigma

    def _axes(self) -> str:
        names = 'xyz'
        rows = [int(np.argmax(np.abs(row))) for row in self.matrix]
        signs = [
            '-' if row[place] < 0.0 else '' for row, place in zip(self.matrix, rows, strict=True)
        ]
        return ', '.join(
            f'{names[number]} reads {sign}{names[place]}'
            for number, (sign, place) in enumerate(zip(signs, rows, strict=True))
        )
