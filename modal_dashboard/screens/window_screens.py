"""What the screens say of a window: health of the data, modes, MAC, trends."""

from collections.abc import Sequence
import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from modal_core.measurements import NANOSECONDS_PER_SECOND
from modal_core.mode import Mode, ModeSet
from modal_core.numbers.indicators import mac_where_seen
from modal_core.quality import ChannelQuality
from modal_core.window import Pose
from modal_dashboard.screens.board import Update
from modal_dashboard.screens.plain_tables import plain_table
from modal_history.kept import KeptWindow
from modal_reports import (
    Cell,
    channel_words,
    DAMPING,
    duration,
    fixed,
    FREQUENCY,
    Geometry,
    heading,
    HeatScale,
    mark,
    measured,
    mode_shapes_data,
    MPC,
    MPD,
    number,
    quality_words,
    Row,
    significant,
    Table,
    text,
    tracks_data,
    UNKNOWN,
)

MAC_COLOURS = HeatScale(0.0, 1.0)


def window_updates(window: KeptWindow, before: KeptWindow | None, now_s: float) -> list[Update]:
    """Return what a result changes on the page.

    Parameters
    ----------
    window : KeptWindow
        The result.
    before : KeptWindow or None
        The one before it, of the same channels.
    now_s : float [s]
        Time of the calendar when it came.
    """
    told = {
        'index': window.index,
        'received_s': now_s,
        'facts': _facts(window),
        'identifiable': window.quality.identifiable,
        'sentences': quality_words(window.quality),
        'channels': plain_table(_channels(window.quality.channels)),
        'modes': plain_table(_modes(window.modes)),
        'n_modes': sum(not mode.harmonic for mode in window.modes),
        'mac': _macs(window, before),
    }
    return [Update.of('window', told), Update.of('track', _track(window))]


def shapes_update(
    window: KeptWindow,
    geometry: Geometry | None = None,
    displacements: Sequence[NDArray[np.complex128]] = (),
) -> Update:
    """Return the shapes of a window's modes, on the arm where it is known."""
    return Update.of('shapes', mode_shapes_data(window.modes, geometry, displacements))


def _facts(window: KeptWindow) -> list[list[str]]:
    length_s = (window.end_ns - window.start_ns) / NANOSECONDS_PER_SECOND
    found = [
        ['Window', str(window.index)],
        ['Length', duration(length_s)],
        ['Method', window.modes.method or UNKNOWN],
        ['Channels', str(len(window.modes.channel_names))],
    ]
    return found if window.pose is None else [*found, ['Pose', _pose(window.pose)]]


def _pose(pose: Pose) -> str:
    angles = zip(pose.joint_names, np.degrees(pose.position), strict=True)
    return ', '.join(f'{name} {fixed(angle, 1)}°' for name, angle in angles)


def _channels(channels: Sequence[ChannelQuality]) -> Table:
    heads = (
        text('Channel'),
        number('Rate [Hz]'),
        number('RMS [SI unit]'),
        number('Kurtosis'),
        number('Noise'),
        number('Lost'),
        number('Filled in'),
        text('Health'),
    )
    return Table('Channels', heads, [_channel(each) for each in channels])


def _channel(channel: ChannelQuality) -> Row:
    cells = (
        text(channel.name),
        number(significant(channel.measured_rate_hz or None, 5)),
        number(significant(channel.rms)),
        number(significant(channel.kurtosis)),
        number(significant(channel.noise_rms)),
        number(str(channel.n_lost)),
        number(str(channel.n_interpolated)),
        Cell(channel_words(channel), 'free'),
    )
    return Row(cells, 'bad' if channel.excluded else '')


def _modes(modes: ModeSet) -> Table:
    heads = (
        text('Mode'),
        heading(FREQUENCY),
        heading(DAMPING),
        number(MPC.heading),
        number(MPD.heading),
        text('Remark'),
    )
    return Table('Modes', heads, [_mode(mode) for mode in modes], empty='No modes were found.')


def _mode(mode: Mode) -> Row:
    damping = math.nan if mode.harmonic else mode.damping_ratio
    cells = (
        text(str(mode.id) if mode.id else UNKNOWN),
        *measured(FREQUENCY, mode.frequency_hz, mode.frequency_std_hz),
        *measured(DAMPING, damping, mode.damping_ratio_std),
        number(fixed(mode.mpc, 3)),
        number(fixed(math.degrees(mode.mpd), 1)),
        text(mark(mode)),
    )
    return Row(cells, 'aside' if mode.harmonic else '')


def _macs(window: KeptWindow, before: KeptWindow | None) -> list[dict[str, object]]:
    """Return the MAC between a window's modes, and with those of the window before."""
    own = _structural(window)
    if not own:
        return []
    found = [plain_table(_mac('Between the modes of this window', own, own))]
    if before is not None and before.modes.channel_names == window.modes.channel_names:
        others = _structural(before)
        caption = f'Against window {before.index} (columns)'
        found += [plain_table(_mac(caption, own, others))] if others else []
    return found


def _structural(window: KeptWindow) -> list[Mode]:
    return [mode for mode in window.modes if not mode.harmonic]


def _mac(caption: str, rows: Sequence[Mode], columns: Sequence[Mode]) -> Table:
    values = mac_where_seen(_shapes(rows), _shapes(columns))
    lines = [
        Row((text(_name(mode)), *(_mac_cell(value) for value in line)))
        for mode, line in zip(rows, values.tolist(), strict=True)
    ]
    heads = (text('Mode'), *(number(_name(mode)) for mode in columns))
    return Table(f'MAC: {caption}', heads, lines, caption)


def _shapes(modes: Sequence[Mode]) -> NDArray[np.complex128]:
    return np.array([mode.shape for mode in modes]).T


def _mac_cell(value: float) -> Cell:
    return Cell(fixed(value, 2), f'number step-{MAC_COLOURS.step(value)}')


def _name(mode: Mode) -> str:
    return f'{mode.id or UNKNOWN} ({significant(mode.frequency_hz)} Hz)'


def _track(window: KeptWindow) -> dict[str, object]:
    """Return a window of the trends; its times are of the calendar of its samples."""
    told: Any = tracks_data([window], ())['windows']
    start_s = window.start_ns / NANOSECONDS_PER_SECOND
    pose = window.pose
    where = None
    if pose is not None and np.isfinite(pose.position).all():
        angles = np.round(np.degrees(pose.position), 1).tolist()
        where = {'angles': angles, 'words': _pose(pose)}
    return {**told[0], 'start_s': start_s, 'end_s': start_s + told[0]['end_s'], 'pose': where}
