"""Reports of simulated arms: a chain of masses and springs shaken at random, then identified."""

from dataclasses import replace
import math

import numpy as np
import scipy.linalg
import scipy.signal

from autonomous_modal_analysis.identified.results import Identification, IdentifiedWindow
from autonomous_modal_analysis.report import channel_spectra, match_truth, ReportContent
from autonomous_modal_analysis.spectrogram import SpectrogramWatch
from modal_core.channel import Channel
from modal_core.measurements import JointSamples
from modal_core.mode import ModeSet
from modal_core.quality import ChannelQuality, DataQuality
from modal_core.samples import Samples
from modal_core.window import Window
from modal_reports import Geometry, sensor_displacements, Spectrum
from oma_identifier.identify import identify_samples
from oma_identifier.settings import IdentificationSettings

SEED = 20
RATE_HZ = 128.0
STEP_S = 1.0 / RATE_HZ
START_NS = 1_760_000_000_000_000_000


class Chain:
    """A fixed-free chain of masses; each mass moves along x, y or z of an arm in turn."""

    def __init__(self, n_dof=6, stiffness=4.0e4, mass=3.0, damping=0.015):
        self.mass = mass
        springs = np.diag(np.full(n_dof, 2.0)) - np.eye(n_dof, k=1) - np.eye(n_dof, k=-1)
        springs[-1, -1] = 1.0
        eigenvalue, self.shapes = scipy.linalg.eigh(stiffness / mass * springs)
        self.omega = np.sqrt(eigenvalue)
        self.damping_ratio = np.full(n_dof, damping)
        self.frequency_hz = self.omega / (2.0 * math.pi)

    def acceleration(self, duration_s, rng):
        """Return the accelerations under white forces, mode by mode, exact for held inputs."""
        n_dof = len(self.omega)
        n_samples = round(duration_s * RATE_HZ)
        force = rng.standard_normal((n_samples, n_dof)) * 50.0 / self.mass
        out = np.zeros((n_samples, n_dof))
        for index, omega in enumerate(self.omega):
            z = self.damping_ratio[index]
            a = np.array([[0.0, 1.0], [-(omega**2), -2 * z * omega]])
            b = np.array([[0.0], [1.0]])
            c = np.array([[-(omega**2), -2 * z * omega]])
            d = np.array([[1.0]])
            system = scipy.signal.cont2discrete((a, b, c, d), STEP_S)
            _, y, _ = scipy.signal.dlsim(system, force @ self.shapes[:, index])
            out += y * self.shapes[:, index]
        return out + 0.05 * out.std() * rng.standard_normal(out.shape)


def arm_geometry():
    """Return a six-point arm with three two-axis sensors."""
    points = np.array(
        [
            [0, 0, 0],
            [0, 0, 0.8],
            [0.3, 0, 0.8],
            [0.3, 0.0, 1.8],
            [0.9, 0.1, 2.0],
            [1.8, 0.1, 1.9],
            [2.1, 0.1, 1.7],
        ],
        dtype=float,
    )
    return Geometry(points, lines=((0, 1, 2, 3, 4, 5, 6),), sensors=(3, 5, 6))


def turning_joint(n_samples, start_ns):
    """Return angles of a joint that speeds up to 0.5 rad/s and one that rests."""
    time_s = np.arange(n_samples) / RATE_HZ
    angle = 0.25 * time_s**2 / time_s[-1]
    position = np.column_stack([angle, np.zeros(n_samples)])
    stamps = start_ns + np.round(1e9 * time_s).astype(np.int64)
    return JointSamples(stamps, ('joint_1', 'joint_2'), position, np.full(position.shape, np.nan))


def identified(duration_s=120.0, n_windows=6, names=None, seed=SEED):
    """Return (chain, content) of a simulated arm."""
    chain = Chain()
    rng = np.random.default_rng(seed)
    data = chain.acceleration(duration_s, rng)
    names = names or tuple(
        f'{place}.{axis}' for place in ('elbow', 'wrist', 'flange') for axis in 'xy'
    )
    channels = tuple(Channel(name=name) for name in names)
    settings = IdentificationSettings()
    whole = identify_samples(Samples(data, RATE_HZ, channels), settings)
    modes = tuple(replace(mode, id=number) for number, mode in enumerate(whole.modes, 1))
    whole_modes = ModeSet(modes, whole.modes.channel_names)
    length = len(data) // n_windows
    windows = []
    spectra = SpectrogramWatch()
    for index in range(n_windows):
        part = Samples(data[index * length : (index + 1) * length], RATE_HZ, channels)
        found = identify_samples(part, settings).modes
        start = START_NS + round(index * length / RATE_HZ * 1e9)
        joints = turning_joint(length, start)
        spectra.add(Window(index, replace(part, start_ns=start), joints=joints))
        tracked = tuple(
            replace(mode, id=_nearest(mode.frequency_hz, whole_modes)) for mode in found
        )
        windows.append(
            IdentifiedWindow(
                index,
                start,
                start + round(length / RATE_HZ * 1e9),
                ModeSet(tracked, found.channel_names),
            )
        )
    geometry = arm_geometry()
    directions = np.array([[1.0, 0, 0], [0, 1.0, 0]] * 3)
    at = [3, 3, 5, 5, 6, 6]
    quality = DataQuality(
        channels=tuple(
            ChannelQuality(
                name,
                measured_rate_hz=RATE_HZ,
                rms=float(data[:, column].std()),
                jitter_std_s=12e-6,
            )
            for column, name in enumerate(names)
        )
    )
    content = ReportContent(
        title='IRB 6660-205/1.9, emulated cell',
        recording='self_excitation_0007.mcap',
        identification=Identification(whole_modes, tuple(windows), channels, quality, settings),
        poles=whole.poles,
        spectrum=Spectrum(whole.spectrum.frequency_hz, whole.spectrum.singular_value),
        spectrogram=spectra.found(),
        spectra=channel_spectra(Samples(data, RATE_HZ, channels), modes, (1.0, 57.6)),
        truth=match_truth(whole_modes, chain.frequency_hz, chain.damping_ratio, chain.shapes),
        geometry=geometry,
        displacements=tuple(
            sensor_displacements(geometry, mode.shape, directions, at) for mode in whole_modes
        ),
        provenance={'Software': 'autonomous_modal_analysis 0.1.0', 'Seed': str(seed)},
    )
    return chain, content


def _nearest(frequency_hz, modes):
    if not len(modes):
        return 0
    error = np.abs(modes.frequency_hz / frequency_hz - 1.0)
    best = int(np.argmin(error))
    return modes.modes[best].id if error[best] < 0.03 else 0
