"""The families: what their structures, forces and records are drawn from."""

from dataclasses import dataclass, replace

Range = tuple[float, float]
WHITE, STEADY = 'white', 'steady'
ALL_FORCES = (WHITE, 'coloured', 'banded')
ALL_COURSES = (STEADY, 'growing', 'bursting')


@dataclass(frozen=True)
class Family:
    """Distributions of the parameters of one family; ranges are drawn log-uniformly.

    Parameters
    ----------
    name, what : str
        Of the family; what makes it one.
    n_modes, n_channels : pair of int
        Least and most.
    damping : pair of float
        Damping ratios before coupling.
    pairs : float
        Share of half the modes that are partners 0.3 to 10 % above another.
    coupling : pair of float
        Share of the damping that couples modes, uniform; 0: real shapes.
    rate_hz, duration_s : pair of float [Hz], [s]
        Of the record; a duration is cut where samples x channels or samples are too many.
    noise : pair of float
        Over the standard deviation of the responses.
    rank : pair of float
        Number of independent forces over that of the modes, uniform; at least one.
    forces, courses : tuple of str
        Kinds of spectra and of courses over time.
    n_lines : pair of int
        Harmonics.
    drift : pair of float
        From least to greatest natural frequency over the mean, uniform; none below 0.
    motion : pair of float
        What a moving robot adds to its sensors, over the standard deviation of the responses.
    """

    name: str
    what: str
    n_modes: tuple[int, int] = (2, 25)
    n_channels: tuple[int, int] = (4, 24)
    damping: Range = (0.0005, 0.12)
    pairs: float = 0.2
    coupling: Range = (0.0, 0.0)
    rate_hz: Range = (20.0, 1000.0)
    duration_s: Range = (30.0, 1800.0)
    noise: Range = (0.001, 0.1)
    rank: Range = (1.0, 1.0)
    forces: tuple[str, ...] = (WHITE,)
    courses: tuple[str, ...] = (STEADY,)
    n_lines: tuple[int, int] = (0, 0)
    drift: Range = (0.0, 0.0)
    motion: Range = (0.0, 0.0)


PLAIN = Family('plain', 'anything but white steady forces of full rank, little noise')
FAMILIES = {
    family.name: family
    for family in (
        PLAIN,
        replace(PLAIN, name='light', what='ζ 0.05 to 0.5 %', damping=(0.0005, 0.005)),
        replace(
            PLAIN,
            name='heavy',
            what='ζ 3 to 12 %, many pairs',
            damping=(0.03, 0.12),
            pairs=0.5,
            n_modes=(2, 12),
        ),
        replace(PLAIN, name='complex', what='damping couples the modes', coupling=(0.3, 1.0)),
        replace(PLAIN, name='single', what='one channel', n_channels=(1, 1), n_modes=(2, 12)),
        replace(PLAIN, name='few', what='2 or 3 channels', n_channels=(2, 3)),
        replace(PLAIN, name='many', what='25 to 60 channels', n_channels=(25, 60)),
        replace(
            PLAIN,
            name='slow',
            what='4 to 20 Hz, 5 to 60 min',
            rate_hz=(4.0, 20.0),
            duration_s=(300.0, 3600.0),
        ),
        replace(
            PLAIN,
            name='fast',
            what='1,024 to 4,096 Hz, 10 to 60 s',
            rate_hz=(1024.0, 4096.0),
            duration_s=(10.0, 60.0),
        ),
        replace(PLAIN, name='short', what='10 to 30 s', duration_s=(10.0, 30.0)),
        replace(PLAIN, name='noisy', what='noise 30 to 100 %', noise=(0.3, 1.0)),
        replace(PLAIN, name='low_rank', what='rank 1 to half', rank=(0.0, 0.5)),
        replace(PLAIN, name='coloured', what='coloured or banded forces', forces=ALL_FORCES[1:]),
        replace(
            PLAIN, name='unsteady', what='growing or bursting forces', courses=ALL_COURSES[1:]
        ),
        replace(PLAIN, name='harmonics', what='1 to 6 lines', n_lines=(1, 6)),
        replace(
            PLAIN, name='drifting', what='frequencies drift by 0.3 to 3 %', drift=(0.003, 0.03)
        ),
        replace(
            PLAIN,
            name='moving',
            what='a robot moves: its own accelerations and gravity in the sensors; half drift',
            drift=(-0.03, 0.03),
            motion=(0.3, 10.0),
        ),
        Family(
            'anything',
            'all of these at once',
            n_channels=(1, 60),
            coupling=(0.0, 1.0),
            rate_hz=(4.0, 4096.0),
            duration_s=(10.0, 3600.0),
            noise=(0.001, 1.0),
            rank=(0.0, 1.0),
            forces=ALL_FORCES,
            courses=ALL_COURSES,
            n_lines=(0, 4),
            drift=(-0.03, 0.03),
        ),
    )
}
