"""Settings of the identifier; every default works without being touched."""

from dataclasses import dataclass

from modal_core.errors import SettingsError
from modal_core.settings.schema import check_settings, setting, within

LARGEST_ORDER = 100
SHORTEST_REFINED_HOP_S = 5.0
MEMORIES = 6.0
"""That a method which forgets looks back: what is older has 0.25 % of the weight of all."""


@dataclass(frozen=True, slots=True)
class IdentificationSettings:
    """What the identifier does; None means "chosen from the data".

    Parameters
    ----------
    window_s : float [s]
        Length of one window.
    hop_s : float [s] or None
        Time from one window to the next; None: half a window.  With hops shorter than a
        sixteenth of a window the frequency bands take turns: each is solved when so much is new.
    min_frequency_hz, max_frequency_hz : float [Hz] or None
        Band that modes are looked for in; None: from the length and rate of the data.
    min_order, max_order : int
        Even model orders from .. to, per frequency band.
    block_rows : int or None
        Block rows of the Hankel matrix; None: from the model order and number of channels.
    n_references : int or None
        Channels kept as references, chosen by their content; None or more than eight: eight,
        beyond which nothing is gained.
    max_damping_ratio : float
        Poles damped more are not modes.
    method : str
        How modes are identified, by name (:data:`oma_identifier.methods.METHODS`); all but
        ``ssi_cov`` and ``rvar`` start afresh with every window, all but ``ssi_cov`` keep the
        samples of a whole record; ``csi`` takes the joints' accelerations as known inputs,
        ``force`` a measured force.
    memory_s : float [s] or None
        Of ``rvar``: weights fall by e in this time; None: half a window, which puts the mean of
        the weights in the middle of the window.
    refine : bool or None
        Refine the modes of a window by maximum likelihood; None: unless the hop is so short that
        speed counts more.
    gyroscopes : bool
        The angular velocities of an Imu take part beside its accelerations.
    known_motion : bool
        With joint states and a robot: the motion of the joints, which is known, takes part in the
        refinement of each band where the data show that it holds.

    Raises
    ------
    SettingsError
        A value out of its range, naming the field, the value and the range.
    """

    window_s: float = setting(60.0, 'length of one window [s]', 1.0, 86400.0)
    hop_s: float | None = setting(
        None, 'time from one window to the next [s]', 0.01, 86400.0, automatic='half a window'
    )
    min_frequency_hz: float | None = setting(
        None, 'lower edge of the band [Hz]', 0.001, 1e5, automatic='from the data'
    )
    max_frequency_hz: float | None = setting(
        None, 'upper edge of the band [Hz]', 0.01, 1e5, automatic='from the plan, or the data'
    )
    min_order: int = setting(2, 'lowest model order', 2, LARGEST_ORDER)
    max_order: int = setting(60, 'highest model order', 2, LARGEST_ORDER)
    block_rows: int | None = setting(
        None, 'block rows of the Hankel matrix', 4, 500, automatic='from order and channels'
    )
    n_references: int | None = setting(
        None, 'number of reference channels', 1, 1000, automatic='eight at most'
    )
    max_damping_ratio: float = setting(0.15, 'poles damped more are no modes', 0.001, 0.5)
    method: str = setting(
        'ssi_cov',
        'identification method: ssi_cov, ssi_data, plscf, var, rvar, notch, vmd, psdtm, csi, '
        'force, efdd or fdd',
    )
    memory_s: float | None = setting(
        None,
        'memory of rvar, which forgets by e in it [s]',
        1.0,
        86400.0,
        automatic='half a window',
    )
    refine: bool | None = setting(
        None, 'refine modes by maximum likelihood', automatic='only with hops of 5 s or more'
    )
    gyroscopes: bool = setting(False, 'angular velocities of IMUs take part')
    known_motion: bool = setting(
        False, "the joints' known motion takes part in the refinement, where it helps"
    )

    def __post_init__(self) -> None:
        """Refuse values out of range."""
        check_settings(self)
        within('max_order', self.max_order, self.min_order, LARGEST_ORDER)
        if self.hop_s is not None:
            within('hop_s', self.hop_s, 0.01, self.window_s)
        low, high = self.min_frequency_hz, self.max_frequency_hz
        if low is not None and high is not None and low >= high:
            raise SettingsError(
                'empty band', where='min_frequency_hz', found=low, expected=f'< {high}'
            )

    @property
    def hop(self) -> float:
        """Time from one window to the next [s]."""
        return self.window_s / 2.0 if self.hop_s is None else self.hop_s

    @property
    def memory(self) -> float:
        """Time in which a method that forgets does so by e [s]."""
        return self.window_s / 2.0 if self.memory_s is None else self.memory_s

    @property
    def reach_s(self) -> float:
        """Time back from the end of a window that takes part in its modes [s]."""
        return MEMORIES * self.memory if self.method == 'rvar' else self.window_s

    @property
    def refines(self) -> bool:
        """Whether the modes of a window are refined."""
        if self.method != 'ssi_cov':
            return False
        return self.hop >= SHORTEST_REFINED_HOP_S if self.refine is None else self.refine

    @property
    def refines_record(self) -> bool:
        """Whether the modes of a whole record are refined: there no hop is too short for it."""
        return self.method == 'ssi_cov' and self.refine is not False
