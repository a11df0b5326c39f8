"""Gives modes ids that stay the same from window to window."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
import math

import numpy as np
from numpy.typing import NDArray

from modal_core.mode import Mode, ModeSet
from modal_core.numbers.assignment import cheapest_pairs
from modal_core.numbers.indicators import mac
from modal_core.window import Pose
from oma_identifier.tracking.checkpoint import restore
from oma_identifier.tracking.prediction import FORBIDDEN, PredictedMode, Prediction, Predictions
from oma_identifier.tracking.thresholds import TRACKING
from oma_identifier.tracking.track import Prior, relative_std, Track


@dataclass(frozen=True, slots=True)
class TrackedModes:
    """One window's modes with ids, and what changed.

    Parameters
    ----------
    modes : ModeSet
        By frequency, each with its id.
    born : tuple of int
        Ids seen for the first time.
    lost : tuple of int
        Ids that have now been missed so often that they are reported lost.
    returned : tuple of int
        Ids that were lost and are back.
    """

    modes: ModeSet
    born: tuple[int, ...] = ()
    lost: tuple[int, ...] = ()
    returned: tuple[int, ...] = ()


class ModeTracker:
    """Links the modes of successive windows by frequency, shape, uncertainty and pose.

    Every window is assigned as a whole (Hungarian algorithm): two modes that cross are told apart
    by their shapes.  A track remembers its modes per pose, so that a robot that returns to a pose
    finds the frequencies it had there.  Where a map of the workspace predicts the modes of a pose
    not seen before, frequency and shape are expected by it.

    Attributes
    ----------
    predictions : Predictions
        Of a map, as the arm moves; empty without one.
    """

    def __init__(self) -> None:
        self.tracks: list[Track] = []
        self.predictions = Predictions()
        self._next_id = 1

    def update(self, modes: ModeSet, pose: Pose | None = None) -> TrackedModes:
        """Assign ids to the modes of the next window.

        Parameters
        ----------
        modes : ModeSet
            Without ids.
        pose : Pose or None
            Where the robot was; None when unknown or when nothing moves.
        """
        joints = None if pose is None else np.asarray(pose.position, dtype=float)
        prediction = self.predictions.at(pose)
        partners = {} if prediction is None else prediction.partners(modes)
        links = self._link(modes, joints, prediction)
        born, returned = [], []
        seen: list[Track] = []
        for row, mode in enumerate(modes):
            track = links.get(row)
            if track is None:
                track = self._birth()
                born.append(track.id)
            elif track.missed >= TRACKING.lost_after:
                returned.append(track.id)
            partner = partners.get(row)
            if partner is not None:
                track.predicted[partner.id] = track.predicted.get(partner.id, 0) + 1
            prior = _prior(_expected_of(track, prediction))
            track.observe(mode, joints, modes.channel_names, prior)
            seen.append(track)
        numbers = {track.id for track in seen}
        for track in seen:
            track.companions.update(
                {other: track.companions.get(other, 0) + 1 for other in numbers - {track.id}}
            )
        lost = self._miss(numbers)
        self._merge_twins(seen)
        numbered = [replace(mode, id=track.id) for mode, track in zip(modes, seen, strict=True)]
        return TrackedModes(
            replace(modes, modes=tuple(numbered)), tuple(born), tuple(lost), tuple(returned)
        )

    def label(self, modes: ModeSet) -> ModeSet:
        """Return the modes with the ids they have here, without learning; new ones get new ids."""
        links = self._link(modes, None, None)
        numbered = []
        for row, mode in enumerate(modes):
            track = links.get(row)
            if track is None:
                track = self._birth()
                track.observe(mode, None, modes.channel_names)
            numbered.append(replace(mode, id=track.id))
        return replace(modes, modes=tuple(numbered))

    def _link(
        self, modes: ModeSet, joints: NDArray[np.float64] | None, prediction: Prediction | None
    ) -> dict[int, Track]:
        if not len(modes) or not self.tracks:
            return {}
        names = modes.channel_names
        closeness = [
            [closeness_of(track, mode, joints, names, prediction) for track in self.tracks]
            for mode in modes
        ]
        cost = np.array([[entry.cost for entry in row] for row in closeness])
        # Of two tracks that fit alike, the one seen more takes the mode: -2 ln of its odds.
        odds = [max(1, track.n_seen) / (1.0 + track.missed) for track in self.tracks]
        surprise = 2.0 * np.log(np.max(odds) / odds)
        rows, columns = cheapest_pairs(np.where(cost <= TRACKING.gate, cost + surprise, FORBIDDEN))
        links = {
            int(row): int(column)
            for row, column in zip(rows, columns, strict=True)
            if cost[row, column] <= TRACKING.gate
        }
        # An outlier of frequency gives no second id to a mode whose shape leaves no doubt.
        free = np.array([[entry.unmistakable for entry in row] for row in closeness])
        free[list(links)] = False
        free[:, list(links.values())] = False
        for row, column in np.argwhere(free):
            if free[row].sum() == 1 and free[:, column].sum() == 1:
                links[int(row)] = int(column)
        return {row: self.tracks[column] for row, column in links.items()}

    def _merge_twins(self, seen: Sequence[Track]) -> None:
        """Give a track the id of an older one that it turns out to continue."""
        for young in seen:
            if young.n_seen < TRACKING.seen_to_judge:
                continue
            for old in self.tracks:
                if old.id < young.id and old.missed and _are_twins(old, young):
                    self.tracks.remove(old)
                    young.id, young.n_seen = old.id, young.n_seen + old.n_seen
                    young.companions = old.companions
                    break
        self.tracks.sort(key=lambda track: track.id)

    def _birth(self) -> Track:
        track = Track(id=self._next_id)
        self._next_id += 1
        self.tracks.append(track)
        return track

    def _miss(self, seen: Iterable[int]) -> list[int]:
        lost = []
        present = set(seen)
        for track in self.tracks:
            if track.id in present:
                continue
            track.missed += 1
            if track.missed == TRACKING.lost_after:
                lost.append(track.id)
        if len(self.tracks) > TRACKING.most_tracks:
            # The least seen and longest gone make room.
            self.tracks.sort(key=lambda track: (track.n_seen, -track.missed), reverse=True)
            del self.tracks[TRACKING.most_tracks :]
            self.tracks.sort(key=lambda track: track.id)
        return lost

    def to_json(self) -> dict[str, object]:
        """Return the state as plain data for a checkpoint."""
        return {
            'next_id': self._next_id,
            'tracks': [track.to_json() for track in self.tracks],
        }

    @classmethod
    def from_json(cls, data: object) -> 'ModeTracker':
        """Rebuild a tracker from :meth:`to_json`.

        Raises
        ------
        SettingsError
            The data is not a checkpoint of a tracker.
        """
        state = restore(data)
        tracker = cls()
        tracker.tracks, tracker._next_id = state.tracks, state.next_id
        return tracker


@dataclass(frozen=True, slots=True)
class Closeness:
    """How well a mode continues a track.

    Parameters
    ----------
    deviation : float
        Distance in frequency in standard deviations of both.
    step : float
        Distance in frequency over the frequency.
    widest : float
        Largest such distance of an outlier.
    alike : float
        MAC.
    loss : float
        1 - MAC to be expected from the uncertainty of the shapes.
    """

    deviation: float
    step: float
    widest: float
    alike: float
    loss: float

    @property
    def cost(self) -> float:
        """Squared distance: (Δf / σ)² plus 1 - MAC over its usual spread."""
        distance = self.deviation**2
        if distance > TRACKING.gate:
            return FORBIDDEN
        return distance + (1.0 - self.alike) / (TRACKING.shape_spread + self.loss)

    @property
    def unmistakable(self) -> bool:
        """The same shape at nearly the same frequency, though not within its deviation."""
        near = self.step <= self.widest and self.deviation <= TRACKING.outlier_deviation
        return near and self.alike >= TRACKING.same_shape


def closeness_of(
    track: Track,
    mode: Mode,
    joints: NDArray[np.float64] | None,
    channel_names: tuple[str, ...],
    prediction: Prediction | None = None,
) -> Closeness:
    """Compare a mode with a track, with the uncertainty of both."""
    expected = _expected_of(track, prediction)
    place = track.expected(joints, _prior(expected))
    step = abs(math.log(mode.frequency_hz / place.frequency_hz))
    deviation = step / math.hypot(relative_std(mode), place.relative_std)
    widest = TRACKING.widest_outlier + TRACKING.outlier_deviation * place.place_std
    alike = 0.0
    if deviation <= TRACKING.outlier_deviation:
        told = None
        if prediction is not None and expected is not None and track.has_moved(joints):
            told = prediction.like(expected, mode, channel_names)
        alike = _alike(track, mode, channel_names) if told is None else told
    # The memory of the track is of modes determined about as well as this one.
    loss = 2.0 * mode.mac_loss if math.isfinite(mode.mac_loss) else 0.0
    return Closeness(deviation, step, widest, alike, loss)


def _expected_of(track: Track, prediction: Prediction | None) -> PredictedMode | None:
    """Return what a map expects of a track's mode where the arm is."""
    return None if prediction is None else prediction.mode(track.predicted_id)


def _prior(expected: PredictedMode | None) -> Prior | None:
    return None if expected is None else Prior(expected.frequency_hz, expected.relative_std)


def _are_twins(old: Track, young: Track) -> bool:
    """Tell whether two tracks are one mode: alike, and hardly ever found beside one another."""
    if young.companions.get(old.id, 0) > TRACKING.twin_company * young.n_seen:
        return False
    spread = math.sqrt(old.drifted + young.drifted)
    near = abs(old.level - young.level) <= TRACKING.twin_deviation * spread
    if not near or old.channel_names != young.channel_names:
        return False
    return float(mac(old.shape, young.shape)[0, 0]) >= TRACKING.same_shape


def _alike(track: Track, mode: Mode, channel_names: tuple[str, ...]) -> float:
    """MAC over the channels both have; 1 when they share none."""
    if track.channel_names == channel_names:
        return float(mac(track.shape, mode.shape)[0, 0])
    shared = [name for name in channel_names if name in track.channel_names]
    if not shared:
        return 1.0
    first = track.shape[[track.channel_names.index(name) for name in shared]]
    second = mode.shape[[channel_names.index(name) for name in shared]]
    return float(mac(first, second)[0, 0])
