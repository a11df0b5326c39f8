"""A recording of motor and link encoders and motor torques, read from a file of arrays."""

from dataclasses import dataclass
from pathlib import Path
import zipfile

import numpy as np
from numpy.typing import NDArray

from modal_core.errors import RecordingError

Array = NDArray[np.float64]
SUFFIX = '.npz'
TIME, MOTOR, LINK, TORQUE = (
    'time_s',
    'motor_position_rad',
    'link_position_rad',
    'motor_torque_nm',
)
# What every array is needed for.
NEEDED = {
    TIME: 'the rate of all samples comes from their times',
    MOTOR: 'the motion comes from the motor encoders, divided by the gear ratios',
    LINK: 'twists of gears come from the encoders behind them; a joint without one has zeros',
    TORQUE: 'friction, payload and the load that twists the gears come from the torques of the '
    'motors; motor current times its torque constant will do',
}
LARGEST_BYTES = 500_000_000
LEAST_S, LEAST_RATE_HZ = 2.0, 50.0
MOST_JITTER = 0.01
# A gear twists by milliradians; a motor angle that was not divided by its ratio is off by far.
MOST_TWIST_RAD = 0.1


@dataclass(frozen=True)
class EncoderRecording:
    """What the drives and the encoders behind the gears saw.

    Parameters
    ----------
    name : str
        Of the recording.
    sample_rate_hz : float [Hz]
        Of all arrays.
    motor_rad, link_rad : (n, n_joints) array [rad]
        Motor encoders divided by the gear ratios, and encoders behind the gears.
    torque_nm : (n, n_joints) array [N m]
        At the motors.
    encoders : tuple of int
        Joints that have an encoder behind the gear.
    """

    name: str
    sample_rate_hz: float
    motor_rad: Array
    link_rad: Array
    torque_nm: Array
    encoders: tuple[int, ...]

    def part(self, first: float, last: float, name: str) -> 'EncoderRecording':
        """Return a part of it, from one share of its length to another."""
        count = len(self.motor_rad)
        chosen = slice(round(first * count), round(last * count))
        return EncoderRecording(
            name,
            self.sample_rate_hz,
            self.motor_rad[chosen],
            self.link_rad[chosen],
            self.torque_nm[chosen],
            self.encoders,
        )


def has_encoders(path: Path) -> bool:
    """Return whether a file has arrays that only a recording of encoders and torques has."""
    if path.suffix != SUFFIX or not path.is_file():
        return False
    try:
        with zipfile.ZipFile(path) as file:
            names = {name.removesuffix('.npy') for name in file.namelist()}
    except (OSError, ValueError, zipfile.BadZipFile, NotImplementedError):
        return False
    return not names.isdisjoint((MOTOR, LINK, TORQUE))


def read_encoder_recording(path: Path, n_joints: int) -> EncoderRecording:
    """Read and check one file.

    Parameters
    ----------
    path : Path
        ``.npz`` with ``time_s`` (n,), ``motor_position_rad``, ``link_position_rad`` and
        ``motor_torque_nm``, each (n, n_joints); link positions that stay put count as no encoder.
    n_joints : int
        Of the robot.

    Raises
    ------
    RecordingError
        The file is not what it should be; the message says where.
    """
    arrays = _arrays(path)
    time = _checked(arrays[TIME], path, TIME, 1)
    rate = _rate(time, path)
    motor, link, torque = (_checked(arrays[key], path, key, 2) for key in (MOTOR, LINK, TORQUE))
    for key, values in ((MOTOR, motor), (LINK, link), (TORQUE, torque)):
        if values.shape != (len(time), n_joints):
            raise RecordingError(
                'wrong shape', where=f'{path}: {key}', found=values.shape,
                expected=(len(time), n_joints),
            )  # fmt: skip
    encoders = tuple(int(place) for place in np.flatnonzero(np.ptp(link, axis=0) > 0.0))
    _check_twist(motor, link, encoders, path)
    return EncoderRecording(path.stem, rate, motor, link, torque, encoders)


def _arrays(path: Path) -> dict[str, object]:
    """Return the arrays by name; nothing is unpacked that is too large."""
    try:
        with zipfile.ZipFile(path) as file:
            size = sum(item.file_size for item in file.infolist())
        if size > LARGEST_BYTES:
            raise RecordingError(
                'too large', where=path, found=f'{size} bytes', expected=f'<= {LARGEST_BYTES}'
            )
        with np.load(path, allow_pickle=False) as file:
            missing = [key for key in (TIME, MOTOR, LINK, TORQUE) if key not in file]
            if missing:
                raise RecordingError(
                    'arrays missing', where=path, found=', '.join(sorted(file)[:12]) or 'nothing',
                    expected=', '.join(missing),
                    advice='; '.join(NEEDED[key] for key in missing),
                )  # fmt: skip
            return {key: file[key] for key in (TIME, MOTOR, LINK, TORQUE)}
    except (OSError, ValueError, EOFError, zipfile.BadZipFile, NotImplementedError) as error:
        raise RecordingError(f'cannot be read: {error}', where=path) from error
    except (zipfile.LargeZipFile, MemoryError, SyntaxError, TypeError) as error:
        raise RecordingError('not a file of arrays', where=path) from error


def _checked(values: object, path: Path, key: str, dimensions: int) -> Array:
    array = np.asarray(values)
    where = f'{path}: {key}'
    if array.dtype.kind not in 'fiu' or array.ndim != dimensions:
        raise RecordingError(
            'not numbers', where=where, found=f'{array.dtype} {array.shape}',
            expected=f'{dimensions} dimensions of real numbers',
        )  # fmt: skip
    numbers = array.astype(float)
    if not np.isfinite(numbers).all():
        count = int((~np.isfinite(numbers)).sum())
        raise RecordingError('not finite', where=where, found=f'{count} values')
    return numbers


def _rate(time: Array, path: Path) -> float:
    """Return the rate of samples that come evenly."""
    where = f'{path}: {TIME}'
    if len(time) < 2 or time[-1] - time[0] < LEAST_S:
        raise RecordingError('too short', where=where, expected=f'{LEAST_S:g} s at least')
    steps = np.diff(time)
    step = float(np.median(steps))
    if step <= 0.0 or np.abs(steps - step).max() > MOST_JITTER * step:
        raise RecordingError(
            'samples do not come evenly', where=where,
            found=f'steps of {steps.min():.4g} to {steps.max():.4g} s',
        )  # fmt: skip
    if 1.0 / step < LEAST_RATE_HZ:
        raise RecordingError(
            'too slow', where=where, found=f'{1.0 / step:.4g} Hz',
            expected=f'{LEAST_RATE_HZ:g} Hz at least',
        )  # fmt: skip
    return 1.0 / step


def _check_twist(motor: Array, link: Array, encoders: tuple[int, ...], path: Path) -> None:
    for joint in encoders:
        twist = float(np.ptp(motor[:, joint] - link[:, joint]))
        if twist > MOST_TWIST_RAD:
            raise RecordingError(
                'motor and link do not move alike', where=f'{path}: joint {joint + 1}',
                found=f'{twist:.3g} rad apart', expected=f'<= {MOST_TWIST_RAD:g} rad',
                advice='motor positions are those of the encoder divided by the gear ratio',
            )  # fmt: skip
