"""What links a mode to a track, in one place, with source or measure."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class TrackingThresholds:
    """Limits of tracking, in the order in which a mode meets them.

    Together they gave every mode of three simulated structures its right id over 500 windows with
    drift, crossings and misses, in one pose and in eight, and one id to 91 % of the modes of one
    kind of a measured mast (``make bench``).
    """

    # How surely a mode is known.
    least_std: float = 0.0005
    """Least relative standard deviation a mode is taken to have: of less it would never link."""
    most_std: float = 0.01
    """Largest one: of more it would link to anything."""
    unknown_std: float = 0.005
    """That of a mode that states none."""

    # How far a mode may have moved.
    wander: float = 0.01
    """Share of its frequency a mode may drift from one window to the next, before any is measured.
    """
    least_wander: float = 0.002
    """Least share that measuring it may come to."""
    most_wander: float = 0.02
    """Largest share that measuring it may come to."""
    forget_wander: float = 0.05
    """Weight of the newest window in the measured drift."""
    longest_drift: int = 25
    """Windows after which an unseen mode is not searched for any wider."""
    forget: float = 0.2
    """Weight of the newest window in the running mean of the shape."""

    # Poses.
    same_pose_rad: float = 0.05
    """Poses closer than this in every joint are the same place."""
    most_places: int = 500
    """Poses a track remembers."""
    pose_wander_per_rad: float = 0.15
    """Share of the frequency per radian of the largest joint change, in a pose not seen before."""

    most_predictions: int = 600
    """Poses of which a map's prediction is kept: a minute of motion at 10 Hz."""

    # Whether a mode continues a track.
    gate: float = 16.0
    """Largest cost of a link: four standard deviations, or that much in shape."""
    shape_spread: float = 0.05
    """1 - MAC, beside what uncertainty explains, that costs as much as one standard deviation
    squared: shapes change a little with pose and load."""
    same_shape: float = 0.9
    """MAC of an outlier of frequency that is linked all the same, and of two tracks of a mode."""
    outlier_deviation: float = 8.0
    """Largest deviation of such an outlier."""
    widest_outlier: float = 0.03
    """Largest distance of such an outlier, as a share of the frequency."""

    # Ends and joins of tracks.
    lost_after: int = 3
    """Windows in a row a mode is missed before it is reported lost; its id is kept."""
    most_tracks: int = 400
    """Tracks kept; the least seen and longest gone make room."""
    twin_deviation: float = 2.0
    """Deviation of two tracks of one mode."""
    twin_company: float = 0.2
    """Share of windows in which a method may find one mode twice."""
    seen_to_judge: int = 3
    """Windows a younger track must be seen in before it can be taken for an older one."""


TRACKING = TrackingThresholds()
