"""What a person may ask of the planner, with the range of every number."""

from collections.abc import Mapping
from dataclasses import dataclass

from excitation_planner.signals import (
    APPROACH,
    AUTOMATIC,
    HIGHEST_PATH_HZ,
    LONGEST_S,
    MOST_SAMPLES,
    RANDOM_PULSES,
    SIGNALS,
)
from modal_core.errors import SettingsError
from modal_core.settings.schema import check_settings, read_values, setting


@dataclass(frozen=True, slots=True, kw_only=True)
class PlanRequest:
    """One request; every field is a setting with its unit and range.

    Raises
    ------
    SettingsError
        Naming the field, what was given and what it may be.
    """

    seed: int = setting(1, 'seed of all random numbers', 0, 2**63 - 1)
    signal: str = setting(
        AUTOMATIC,
        'kind of motion: sliding_noise (on sweeps that keep joints sliding), band_limited_noise,'
        ' random_pulses, or approach, one slow move; automatic: sliding_noise where the allowed'
        ' range is wide enough, else band_limited_noise',
    )
    joints: tuple[str, ...] = setting(
        (), 'controller axes that move, axis_1 or, for the same, joint_1, ...; empty: all'
    )
    start_position: tuple[float, ...] = setting(
        (), 'serial joint angles the plan starts at [rad]; empty: the first named pose'
    )
    approach_from: tuple[float, ...] = setting(
        (), 'approach: serial joint angles where the arm is now [rad]; it ends at start_position'
    )
    joint_weights: tuple[float, ...] = setting(
        (),
        'relative amplitude of each moving axis, 0..1, or one for all; empty: what modes and'
        ' torques need, all 1 without require_full_rank',
    )
    duration_s: float = setting(30.0, 'length of the trajectory [s]', 2.0, LONGEST_S)
    sample_period_s: float = setting(0.004, 'spacing of the trajectory [s]', 0.001, 0.02)
    band_low_hz: float = setting(5.0, 'lowest frequency of interest [Hz]', 0.5, 100.0)
    band_high_hz: float = setting(60.0, 'highest frequency of interest [Hz]', 1.0, 500.0)
    acceleration_rms: float = setting(
        1.2, 'of each axis, noise [rad/s²]; times its weight; of sliding noise at most', 0.0, 50.0
    )
    fade_s: float = setting(1.0, 'fade at each end of band-limited noise [s]', 0.1, 30.0)
    shape_frequency_hz: tuple[float, ...] = setting(
        (), 'frequencies at which shape_gain is given [Hz]'
    )
    shape_gain: tuple[float, ...] = setting((), 'relative amplitude over frequency; empty: flat')
    half_range: float = setting(
        0.0, 'pulses and sweeps stay within this of the start [rad]; 0: what is allowed', 0.0, 0.6
    )
    frequency_tolerance: float = setting(
        0.02, 'largest relative change of a natural frequency over the motion', 0.0, 1.0
    )
    presliding_rad: float = setting(
        1e-3, 'travel after a turn before a joint slides, assumed [rad]', 1e-6, 0.1
    )
    sliding_share: float = setting(
        0.9, 'part of the time sweeps shall keep joints sliding', 0.5, 0.99
    )
    enforce_tolerance: bool = setting(True, 'refuse a motion whose range breaks the tolerance')
    interval_low_s: float = setting(0.02, 'shortest pause between pulses [s]', 0.0, 10.0)
    interval_high_s: float = setting(1.0, 'longest pause between pulses [s]', 0.0, 10.0)
    acceleration_low: float = setting(
        0.2, 'least part of the acceleration limit a pulse uses', 0.02, 1.0
    )
    acceleration_high: float = setting(
        0.8, 'greatest part of the acceleration limit a pulse uses', 0.02, 1.0
    )
    ramp_low_s: float = setting(0.05, 'shortest build-up of acceleration [s]; 0: step', 0.0, 1.0)
    ramp_high_s: float = setting(0.15, 'longest build-up of acceleration [s]; 0: step', 0.0, 1.0)
    speed_low: float = setting(0.3, 'least part of the speed limits a pulse uses', 0.001, 1.0)
    speed_high: float = setting(0.9, 'greatest part of the speed limits a pulse uses', 0.001, 1.0)
    synchronised: bool = setting(True, 'joints start and stop together, as MoveAbsJ does')
    noise_density: float = setting(1e-3, 'of the accelerometers [m/s²/sqrt(Hz)]', 1e-9, 10.0)
    point_speed_m_s: float = setting(0.25, 'no point of the arm is faster [m/s]', 0.001, 5.0)
    box_m: tuple[float, ...] = setting(
        (), 'two corners in the base frame the arm stays in [m]; empty: none'
    )
    clearance_m: float = setting(0.01, 'least distance between links [m]', 0.0, 1.0)
    require_full_rank: bool = setting(True, 'refuse torques that do not span space')

    def __post_init__(self) -> None:
        """Check every field against its range and against the others."""
        check_settings(self)
        known = (AUTOMATIC, *SIGNALS)
        if self.signal not in known:
            raise SettingsError(
                'unknown signal', where='signal', found=self.signal, expected=' or '.join(known)
            )
        if (self.signal == APPROACH) != bool(self.approach_from):
            raise SettingsError(
                'an approach, and nothing else, begins where the arm is now',
                where='approach_from',
                found=list(self.approach_from) or 'nothing',
            )
        for low, high in (
            ('interval_low_s', 'interval_high_s'),
            ('acceleration_low', 'acceleration_high'),
            ('ramp_low_s', 'ramp_high_s'),
            ('speed_low', 'speed_high'),
            ('band_low_hz', 'band_high_hz'),
        ):
            if getattr(self, low) > getattr(self, high):
                raise SettingsError(
                    f'above {high}',
                    where=low,
                    found=getattr(self, low),
                    expected=f'<= {getattr(self, high)}',
                )
        self._check_samples()
        self._check_path()
        self._check_lists()

    def _check_samples(self) -> None:
        """Refuse more samples than a plan may have."""
        longest_s = (MOST_SAMPLES - 1) * self.sample_period_s
        if self.duration_s > longest_s:
            raise SettingsError(
                'too many samples',
                where='duration_s',
                found=f'{self.duration_s:g} s',
                expected=f'<= {longest_s:g} s at sample_period_s {self.sample_period_s:g}',
            )

    def _check_path(self) -> None:
        """Refuse a band the way to the robot cannot carry."""
        if self.band_low_hz == self.band_high_hz:
            raise SettingsError('the band is empty', where='band_high_hz', found=self.band_high_hz)
        highest = min(HIGHEST_PATH_HZ, 0.4 / self.sample_period_s)
        if self.band_high_hz > highest:
            raise SettingsError(
                'above what the path to the robot can excite',
                where='band_high_hz',
                found=f'{self.band_high_hz:g} Hz',
                expected=f'<= {highest:g} Hz',
                advice='servo, speed filter and 4 ms cycle leave nothing above it',
            )
        if self.ramp_low_s == 0.0 < self.ramp_high_s:
            raise SettingsError(
                'must be above 0 when ramp_high_s is', where='ramp_low_s', found=self.ramp_low_s
            )
        if 2.0 * self.fade_s > 0.8 * self.duration_s:
            raise SettingsError(
                'leaves no steady part',
                where='fade_s',
                found=self.fade_s,
                expected=f'<= {0.4 * self.duration_s:g} s',
            )

    def _check_lists(self) -> None:
        if len(self.shape_gain) != len(self.shape_frequency_hz):
            raise SettingsError(
                'not one gain per frequency',
                where='shape_gain',
                found=len(self.shape_gain),
                expected=len(self.shape_frequency_hz),
            )
        rising = all(
            a < b
            for a, b in zip(self.shape_frequency_hz, self.shape_frequency_hz[1:], strict=False)
        )
        if self.shape_gain and not (
            rising
            and min(self.shape_frequency_hz) > 0.0
            and min(self.shape_gain) >= 0.0
            and max(self.shape_gain) > 0.0
        ):
            raise SettingsError(
                'needs rising positive frequencies and gains >= 0, not all 0', where='shape_gain'
            )
        if any(not 0.0 <= weight <= 1.0 for weight in self.joint_weights):
            raise SettingsError(
                'outside 0..1', where='joint_weights', found=list(self.joint_weights)
            )
        if self.box_m and (
            len(self.box_m) != 6 or any(self.box_m[i] >= self.box_m[i + 3] for i in range(3))
        ):
            raise SettingsError(
                'not two corners',
                where='box_m',
                found=list(self.box_m),
                expected='x, y, z of the lower and x, y, z of the upper corner',
            )

    @property
    def jerk_limited(self) -> bool:
        """False when pulses step their acceleration, as in the paper."""
        return self.signal != RANDOM_PULSES or self.ramp_low_s > 0.0

    @classmethod
    def from_mapping(cls, data: Mapping[str, object], where: str = '') -> 'PlanRequest':
        """Build a request from parsed YAML.

        Raises
        ------
        SettingsError
            An unknown field, or a value that does not fit.
        """
        return cls(**read_values(cls, data, where))
