"""Set-ups of roving sensors merged: from the modes of each to those over all points."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import combinations

from autonomous_modal_analysis.identified.results import Identification, SetUps
from modal_core.channel import Channel, SensorLayout
from modal_core.errors import SettingsError
from modal_core.mode import ModeSet
from modal_core.samples import Samples
from oma_identifier.compare import check_references, merge_modes, shared_channels

HIGHEST = 0.4
"""Share of the sample rate up to which modes are read out of samples of a lower rate."""
OTHER_REFERENCE = (
    'only without it are modes like those of the other set-ups; it is dead, or stands elsewhere'
)


@dataclass(frozen=True, slots=True)
class SetUp:
    """One set-up.

    Parameters
    ----------
    name : str
        Of its recording.
    modes : ModeSet
        That it shows.
    parts : tuple of Samples
        What they were identified from, the longest first; empty where only the modes were kept.
    remarks : tuple of str
        What should be known of it.
    """

    name: str
    modes: ModeSet
    parts: tuple[Samples, ...] = ()
    remarks: tuple[str, ...] = ()

    def without(self, name: str) -> 'SetUp':
        """Return the set-up as if a channel had not been recorded; that is a remark of it."""
        kept = [row for row, channel in enumerate(self.modes.channel_names) if channel != name]
        modes = [
            replace(
                mode,
                shape=mode.shape[kept],
                shape_std=None if mode.shape_std is None else mode.shape_std[kept],
            )
            for mode in self.modes
        ]
        names = tuple(self.modes.channel_names[row] for row in kept)
        said = f'{name} takes no part: {OTHER_REFERENCE}'
        return replace(
            self,
            modes=replace(self.modes, modes=tuple(modes), channel_names=names),
            remarks=(*self.remarks, said),
        )

    def samples(self, highest_hz: float) -> Samples | None:
        """Return the longest stretch, channels as in the modes; None where it does not reach."""
        names = self.modes.channel_names
        if not self.parts or highest_hz > HIGHEST * self.parts[0].sample_rate_hz:
            return None
        longest = self.parts[0]
        if not set(names) <= set(longest.channel_names):
            return None
        columns = [longest.channel_names.index(name) for name in names]
        return replace(
            longest,
            acceleration=longest.acceleration[:, columns],
            channels=tuple(longest.channels[column] for column in columns),
        )


def merge_set_ups(
    given: Sequence[SetUp], layout: SensorLayout | None = None
) -> tuple[Identification, SetUps]:
    """Return the modes over the points of all set-ups, and who saw them.

    Parameters
    ----------
    given : sequence of SetUp
        That share reference sensors.
    layout : SensorLayout or None
        Links, places and directions of the channels.

    Raises
    ------
    SettingsError
        There are fewer than two, or two are one recording.
    LayoutError
        They share no channel, or one of them is wired otherwise in a set-up.
    """
    if len(given) < 2:
        raise SettingsError('nothing to merge', found=len(given), expected='two set-ups or more')
    _check_apart(given)
    names = tuple(each.name for each in given)
    references, given = _in_order(given)
    modes = [each.modes for each in given]
    highest_hz = max((mode.frequency_hz for each in modes for mode in each), default=0.0)
    joined = merge_modes(modes, lambda number: given[number].samples(highest_hz))
    numbered = (replace(mode, id=index + 1) for index, mode in enumerate(joined.modes))
    merged = replace(joined.modes, modes=tuple(numbered))
    known = {channel.name: channel for channel in layout.channels} if layout else {}
    set_ups = SetUps(
        names,
        references,
        tuple(tuple(names[k] for k in seen) for seen in joined.seen_in),
        tuple(tuple(names[k] for k in read) for read in joined.read_in),
        joined.frequency_scatter,
        joined.damping_scatter,
    )
    identification = Identification(
        modes=merged,
        channels=tuple(known.get(name, Channel(name)) for name in merged.channel_names),
        settings={'merging': 'PoSER, missing modes by PreGER', 'method': merged.method},
        remarks=tuple(f'{each.name}: {said}' for each in given for said in each.remarks),
        set_ups=set_ups,
    )
    return identification, set_ups


def _check_apart(given: Sequence[SetUp]) -> None:
    """Refuse one recording given twice: it would count as two, and make all look surer."""
    for one, other in combinations(given, 2):
        told = [[mode.frequency_hz for mode in each.modes] for each in (one, other)]
        if told[0] and told[0] == told[1]:
            raise SettingsError(
                'the same recording twice',
                found=f'{one.name}, {other.name}',
                expected='a recording of its own for each set-up',
            )


def _in_order(given: Sequence[SetUp]) -> tuple[tuple[str, ...], list[SetUp]]:
    """Return the references and the set-ups, without references that are others there."""
    given = list(given)
    while True:
        modes = [each.modes for each in given]
        references = shared_channels([each.channel_names for each in modes])
        odd = check_references(modes, [each.name for each in given], references)
        if odd is None:
            return references, given
        given[odd[0]] = given[odd[0]].without(odd[1])
