"""Settings of the identifier; every default works without being touched."""

from dataclasses import dataclass
import math

from modal_core.errors import SettingsError

LARGEST_ORDER = 100
SHORTEST_REFINED_HOP_S = 5.0


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
        ``ssi_cov`` start afresh with every window, and keep the samples of a whole record; ``csi``
        takes the joints' accelerations as known inputs.
    refine : bool or None
        Refine the modes of a window by maximum likelihood; None: unless the hop is so short that
        speed counts more.

    Raises
    ------
    SettingsError
        A value out of its range, naming the field, the value and the range.
    """

    window_s: float = 60.0
    hop_s: float | None = None
    min_frequency_hz: float | None = None
    max_frequency_hz: float | None = None
    min_order: int = 2
    max_order: int = 60
    block_rows: int | None = None
    n_references: int | None = None
    max_damping_ratio: float = 0.15
    method: str = 'ssi_cov'
    refine: bool | None = None

    def __post_init__(self) -> None:
        """Refuse values out of range."""
        _within('window_s', self.window_s, 1.0, 86400.0)
        _within('hop_s', self.hop_s, 0.01, self.window_s)
        _within('min_frequency_hz', self.min_frequency_hz, 0.001, 1e5)
        _within('max_frequency_hz', self.max_frequency_hz, 0.01, 1e5)
        _within('min_order', self.min_order, 2, LARGEST_ORDER)
        _within('max_order', self.max_order, self.min_order, LARGEST_ORDER)
        _within('block_rows', self.block_rows, 4, 500)
        _within('n_references', self.n_references, 1, 1000)
        _within('max_damping_ratio', self.max_damping_ratio, 0.001, 0.5)
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
    def refines(self) -> bool:
        """Whether the modes of a window are refined."""
        if self.method != 'ssi_cov':
            return False
        return self.hop >= SHORTEST_REFINED_HOP_S if self.refine is None else self.refine


def _within(field: str, value: float | None, low: float, high: float) -> None:
    if value is None:
        return
    if not math.isfinite(value) or not low <= value <= high:
        raise SettingsError(
            'out of range', where=field, found=value, expected=f'{low:g} to {high:g}'
        )
