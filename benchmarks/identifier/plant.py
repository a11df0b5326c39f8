"""A chain of modes with known truth, shaken by independent white forces."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.signal import firwin, lfilter, upfirdn

from modal_core.channel import Channel
from modal_core.samples import Samples

SIMULATION_RATE_HZ = 4096.0
HALF_TAPS = 40
FREQUENCY_HZ = (8.6, 11.9, 14.2, 21.5, 33.8, 37.1, 54.9, 66.3, 92.4, 107.2, 148.5, 196.0)
DAMPING_RATIO = (0.035, 0.028, 0.042, 0.021, 0.018, 0.030, 0.015, 0.024, 0.012, 0.019, 0.010, 0.05)


@dataclass(frozen=True)
class Plant:
    """Modes and the participation of the forces in them.

    Parameters
    ----------
    frequency_hz, damping_ratio : (n_modes,) array [Hz], [-]
        Truth.
    shapes : (n_channels, n_modes) array
        Truth; complex where damping couples the modes.
    participation : (n_modes, n_forces) array
        Modal force per unit force; complex ones are of the equations of first order.
    """

    frequency_hz: NDArray[np.float64]
    damping_ratio: NDArray[np.float64]
    shapes: NDArray[np.float64] | NDArray[np.complex128]
    participation: NDArray[np.float64] | NDArray[np.complex128]


def chain_plant(n_channels: int = 42, highest_hz: float = 250.0) -> Plant:
    """Return the arm-like chain: 14 tri-axial sensors, or two of them (elbow and flange)."""
    generator = np.random.default_rng(20)
    frequency = np.array(FREQUENCY_HZ)
    n_modes = len(frequency)
    place = np.linspace(0.1, 1.0, 14)
    shapes = np.empty((42, n_modes))
    for index in range(n_modes):
        wave = np.sin((index // 3 + 0.5) * np.pi * place + 0.3 * generator.standard_normal())
        direction = generator.standard_normal(3)
        rough = 0.25 * generator.standard_normal((14, 3))
        shapes[:, index] = (np.outer(wave, direction / np.linalg.norm(direction)) + rough).ravel()
    participation = generator.standard_normal((n_modes, 6))
    # Higher modes would swamp the lower ones under white force accelerations.
    participation *= (frequency[:, None] / 40.0) ** -0.35
    rows = slice(None) if n_channels == 42 else np.r_[18:21, 39:42][:n_channels]
    keep = frequency < highest_hz
    return Plant(
        frequency[keep], np.array(DAMPING_RATIO)[keep], shapes[rows][:, keep], participation[keep]
    )


def random_plant(generator: np.random.Generator, n_channels: int = 6) -> Plant:
    """Return eight modes between 6 and 95 Hz, two of them 1 % apart, damping 0.5 to 6 %."""
    n_modes = 8
    place = np.arange(n_modes - 1) + generator.uniform(-0.3, 0.3, n_modes - 1)
    single = 6.0 * (94.0 / 6.0) ** (np.clip(place, 0.0, n_modes - 2) / (n_modes - 2))
    twin = single[generator.integers(n_modes - 1)]
    frequency = np.sort(np.append(single, 1.01 * twin))
    damping = 0.005 * 12.0 ** generator.uniform(size=n_modes)
    shapes = generator.standard_normal((n_channels, n_modes))
    participation = generator.standard_normal((n_modes, 6))
    participation /= np.linalg.norm(participation, axis=1, keepdims=True)
    participation *= (frequency[:, None] / 40.0) ** -0.35
    return Plant(frequency, damping, shapes, participation)


def with_uneven_damping(plant: Plant, generator: np.random.Generator, n_dampers: int) -> Plant:
    """Return the plant with dampers in a few places, as in joints: its shapes are complex.

    Parameters
    ----------
    n_dampers : int
        The fewer, the more the modes are coupled: one makes imaginary parts of 8 to 30 % of the
        chain's shapes, three of 3 to 20 %.
    """
    omega = 2.0 * np.pi * plant.frequency_hz
    n_modes = len(omega)
    reach = generator.standard_normal((n_modes, n_dampers))
    reach *= np.sqrt(2.0 * plant.damping_ratio * omega / np.sum(reach**2, axis=1))[:, None]
    damping = reach @ reach.T
    zero, one = np.zeros((n_modes, n_modes)), np.eye(n_modes)
    values, vectors = np.linalg.eig(np.block([[zero, one], [-np.diag(omega**2), -damping]]))
    left = np.linalg.inv(vectors)[:, n_modes:]
    upper = np.flatnonzero(values.imag > 0.0)
    upper = upper[np.argsort(np.abs(values[upper]))]
    size = np.abs(values[upper])
    return Plant(
        size / (2.0 * np.pi),
        -values[upper].real / size,
        plant.shapes @ vectors[:n_modes, upper],
        left[upper] @ plant.participation,
    )


def simulate(
    plant: Plant,
    generator: np.random.Generator,
    duration_s: float,
    sample_rate_hz: float = 512.0,
    noise: float = 0.05,
    colour: float = 0.0,
    lines: tuple[tuple[float, float], ...] = (),
    simulation_rate_hz: float = SIMULATION_RATE_HZ,
) -> Samples:
    """Return accelerations: exact zero-order-hold modes at a high rate, then FIR decimation.

    Parameters
    ----------
    colour : float
        Each force is x_t = colour · x_(t-1) + white noise at the rate of the simulation; at 4,096
        Hz 0.99 falls by 6 dB per octave above 6.5 Hz.
    lines : tuple of (frequency_hz, rms)
        Harmonics added to the forces, in units of a force's RMS.
    simulation_rate_hz : float [Hz]
        Forces are held for one step: at 4,096 Hz that bends the spectrum of a mode at 196 Hz by
        0.2 of the deviation that 120 s allow.
    """
    step = round(simulation_rate_hz / sample_rate_hz)
    settle = int(3.0 * simulation_rate_hz)
    n_samples = round(duration_s * sample_rate_hz) * step + settle + HALF_TAPS * step
    force = generator.standard_normal((n_samples, plant.participation.shape[1]))
    if colour:
        force = lfilter((1.0,), (1.0, -colour), force, axis=0)
    modal_force = force @ plant.participation.T
    taps = firwin(2 * HALF_TAPS * step + 1, 0.92 / step)
    modal = []
    for index in range(len(plant.frequency_hz)):
        response = modal_acceleration(plant, index, modal_force[:, index], simulation_rate_hz)
        modal.append(upfirdn(taps, response[settle - HALF_TAPS * step :], down=step))
    n_kept = round(duration_s * sample_rate_hz)
    response = np.array(modal).T[2 * HALF_TAPS : 2 * HALF_TAPS + n_kept] @ plant.shapes.T
    if np.iscomplexobj(response):
        response = 2.0 * response.real
    if lines:
        response += _lines(lines, response, sample_rate_hz, generator)
    response += noise * response.std(axis=0) * generator.standard_normal(response.shape)
    names = tuple(
        Channel(name=f's{row // 3:02d}.{"xyz"[row % 3]}') for row in range(response.shape[1])
    )
    return Samples(response, sample_rate_hz, names)


def modal_acceleration(
    plant: Plant,
    index: int,
    force: NDArray[np.float64] | NDArray[np.complex128],
    rate_hz: float,
) -> NDArray[np.float64] | NDArray[np.complex128]:
    omega = 2.0 * np.pi * plant.frequency_hz[index]
    zeta = plant.damping_ratio[index]
    dt = 1.0 / rate_hz
    pole = omega * (-zeta + 1j * np.sqrt(1.0 - zeta**2))
    z = np.exp(pole * dt)
    if np.iscomplexobj(force):
        # x' = pole x + f, and its second derivative; that of f itself cancels over all modes.
        state = lfilter([0.0, (z - 1.0) / pole], [1.0, -z], force)
        return np.asarray(pole**2 * state + pole * force)
    a = np.array([1.0, -2.0 * z.real, abs(z) ** 2])
    # q'' = f - 2ζω q' - ω² q; with zero-order hold, q = c·Re-part recursion of the pole pair.
    residue = 1.0 / (2j * pole.imag)  # q = 2 Re(residue ∫ e^{s(t-τ)} f)
    gain = residue * pole**2 * (z - 1.0) / pole  # second derivative of q without the direct term
    b = np.array([0.0, 2.0 * gain.real, -2.0 * (gain * np.conj(z)).real])
    return np.asarray(force + lfilter(b, a, force))


def _lines(
    lines: tuple[tuple[float, float], ...],
    response: NDArray[np.float64],
    sample_rate_hz: float,
    generator: np.random.Generator,
) -> NDArray[np.float64]:
    time = np.arange(len(response)) / sample_rate_hz
    scale = response.std(axis=0)
    added = np.zeros_like(response)
    for frequency, level in lines:
        shape = generator.uniform(0.5, 1.5, response.shape[1]) * generator.choice(
            (-1.0, 1.0), response.shape[1]
        )
        phase = generator.uniform(0.0, 2.0 * np.pi)
        added += (
            np.sqrt(2.0)
            * level
            * np.outer(np.sin(2.0 * np.pi * frequency * time + phase), shape * scale)
        )
    return added
