"""campaign.yaml: which recordings belong to a campaign, at which pose and level."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
import os
from pathlib import Path
from typing import Any

import numpy as np

from modal_core.channel import LAYOUT_FILE
from modal_core.errors import SettingsError
from modal_core.files.real_path import real_path
from modal_core.files.yaml_file import load_yaml
from modal_core.settings.near_names import misspelt, refuse_unknown
from modal_recordings.joint_table import is_table, TABLES
from modal_recordings.open_recording import BAG_SUFFIXES
from modal_recordings.tables import FIELDS

LISTS = ('recordings', 'records')
FILES = ('file', 'path', 'recording', 'bag')
LEVEL_KEYS = ('level', 'amplitude', 'amplitude_level')
NOTES = ('notes', 'note', 'remarks')
HELDOUT = ('heldout', 'held_out')
PARTS = ('part', 'split', 'set')
LAYOUTS = ('sensors', 'layout')
JOINTS = 'joints'
STATED = FIELDS[:3]
"""What a file of columns may not say itself: of the campaign, or of one recording."""
POSES = {'pose': 1.0, 'pose_rad': 1.0, 'pose_deg': np.pi / 180.0}
OF_CAMPAIGN = (
    *LISTS,
    *LAYOUTS,
    *NOTES,
    'robot',
    'conditions',
    'effects',
    'tolerances',
    'start_pose',
    *STATED,
)
OF_RECORDING = (
    *FILES, *LEVEL_KEYS, *NOTES, *HELDOUT, *PARTS, *POSES, 'controller_deg', 'plan_hash',
    JOINTS, *LAYOUTS, *STATED,
)  # fmt: skip
# Texts may be anything: without campaign.yaml none is taken for a recording.
COLUMNS = tuple(suffix for suffix in TABLES if suffix != '.txt')


@dataclass(frozen=True)
class CampaignEntry:
    """One recording of a campaign.

    Parameters
    ----------
    path : Path
        File or folder.
    name : str
        The path from the campaign's folder: no two recordings have the same.
    level : str
        Amplitude level; empty when not said.
    pose : tuple of float [rad] or None
        As the campaign says; the recording's own joint states are what counts.
    heldout : bool or None
        None: the workflow decides.
    joints : Path or None
        File of columns with the joint states, where they are in one of their own.
    stated : dict
        What a file of columns does not say itself: ``sample_rate_hz``, ``unit``, ``channels``.
    layout : Path or None
        Its own sensor layout, where sensors were moved between recordings; None: the campaign's.
    """

    path: Path
    name: str
    level: str = ''
    pose: tuple[float, ...] | None = None
    heldout: bool | None = None
    joints: Path | None = None
    stated: Mapping[str, Any] = field(default_factory=dict)
    layout: Path | None = None


@dataclass(frozen=True)
class CampaignFile:
    """A parsed campaign.yaml, or what the folder holds when there is none.

    Parameters
    ----------
    folder : Path
        Of the campaign.
    entries : tuple of CampaignEntry
        In order.
    layout : mapping or Path or None
        Sensor layout, when the campaign brings its own.
    remarks : tuple of str
        Notes of the campaign and of its recordings.
    effects : tuple of Path
        Folders or files with effects of one's own that it needs; nothing of them is loaded.
    tolerances : dict of str to number
        How roughly the model is known, as far as the campaign says.
    """

    folder: Path
    entries: tuple[CampaignEntry, ...]
    layout: Any = None
    remarks: tuple[str, ...] = ()
    effects: tuple[Path, ...] = ()
    tolerances: Mapping[str, Any] = field(default_factory=dict)


def read_campaign_file(folder: str | Path) -> CampaignFile:
    """Read ``campaign.yaml``; without one every recording of the folder counts.

    Raises
    ------
    SettingsError
        The folder or a named file is missing, or a field is malformed.
    """
    folder = Path(folder)
    if not folder.is_dir():
        raise SettingsError('not a folder', where=folder, expected='a folder of recordings')
    path = folder / 'campaign.yaml'
    if not path.exists():
        found = _recordings(folder)
        if not found:
            raise SettingsError(
                'no campaign.yaml and no recordings',
                where=folder,
                expected='recordings that have joint states: '
                + ', '.join((*BAG_SUFFIXES, *COLUMNS)),
            )
        entries = tuple(CampaignEntry(item, item.name) for item in found)
        return CampaignFile(folder, entries, _own(folder))
    data = load_yaml(path)
    items = next((data[key] for key in LISTS if key in data), None)
    if not isinstance(items, list) or not items:
        raise SettingsError('no recordings', where=path, expected='a list "recordings"')
    common = {key: data[key] for key in STATED if key in data}
    entries = tuple(_entry(item, index, folder, path, common) for index, item in enumerate(items))
    layout = next((data[key] for key in LAYOUTS if data.get(key)), None)
    if isinstance(layout, str):
        layout = _inside(folder, layout, f'{path}: layout')
    elif isinstance(layout, list):
        layout = {'sensors': layout}
    _refuse_doubles(entries, path)
    layout = layout if layout is not None else _own(folder)
    remarks = (*_remarks(data, items), *_not_read(data, items, path))
    return CampaignFile(
        folder, entries, layout, remarks, _effects(data, folder, path), _tolerances(data, path)
    )


def _effects(data: Mapping[str, Any], folder: Path, path: Path) -> tuple[Path, ...]:
    named = data.get('effects') or []
    named = named if isinstance(named, list) else [named]
    for item in named:
        if not isinstance(item, str):
            raise SettingsError(
                'not a folder', where=f'{path}: effects', found=item, expected='a path in quotes'
            )
    return tuple(_inside(folder, item, f'{path}: effects') for item in named)


def _tolerances(data: Mapping[str, Any], path: Path) -> dict[str, Any]:
    stated = data.get('tolerances') or {}
    if not isinstance(stated, Mapping):
        raise SettingsError(
            'not a mapping', where=f'{path}: tolerances', found=stated, expected='stiffness: 0.4'
        )
    return dict(stated)


def _refuse_doubles(entries: tuple[CampaignEntry, ...], path: Path) -> None:
    seen: set[Path] = set()
    for entry in entries:
        if entry.path in seen:
            raise SettingsError('recording named twice', where=path, found=entry.name)
        seen.add(entry.path)


def _remarks(data: Mapping[str, Any], items: list[Any]) -> tuple[str, ...]:
    """Return what people wrote, of one recording with its name before it."""
    found = list(_texts(data))
    for item in items:
        if isinstance(item, Mapping):
            name = next((str(item[key]) for key in FILES if key in item), '')
            found += [f'{name}: {text}' for text in _texts(item)]
    return tuple(found)


def _not_read(data: Mapping[str, Any], items: list[Any], path: Path) -> Iterator[str]:
    """Refuse slips of a known key; tell of others, which tools of others may have written."""
    others: dict[str, None] = {}
    recordings = [(OF_RECORDING, item) for item in items if isinstance(item, Mapping)]
    for known, mapping in ((OF_CAMPAIGN, data), *recordings):
        slips, unknown = misspelt(mapping, known)
        refuse_unknown(slips, known, where=path)
        others |= dict.fromkeys(unknown)
    for key in others:
        yield f'campaign.yaml: {key} is not read'


def _texts(data: Mapping[str, Any]) -> list[str]:
    value: Any = next((data[key] for key in NOTES if data.get(key)), [])
    return [str(item) for item in (value if isinstance(value, list) else [value])]


def _own(folder: Path) -> Path | None:
    for name in (LAYOUT_FILE, 'layout.yaml'):
        if (folder / name).exists():
            return folder / name
    return None


def _recordings(folder: Path) -> list[Path]:
    """Return the bags of a folder; where there are none, its files of columns."""
    items = sorted(folder.iterdir())
    bags = [item for item in items if _is_bag(item)]
    return bags or [item for item in items if item.suffix.lower() in COLUMNS and item.is_file()]


def _is_bag(item: Path) -> bool:
    if item.is_dir():
        return (item / 'metadata.yaml').exists() or any(item.glob('*.mcap'))
    return item.suffix in BAG_SUFFIXES


def _inside(folder: Path, name: str, where: str) -> Path:
    # What is too long for a name, or leads in a circle, is not there either.
    if '\0' in name or not os.path.exists(folder / name):  # noqa: PTH110
        raise SettingsError('file missing', where=where, found=name)
    return real_path(folder / name)


def _name(folder: Path, name: str) -> str:
    return Path(os.path.relpath(folder / name, folder)).as_posix()


def _entry(
    item: object, index: int, folder: Path, path: Path, common: Mapping[str, Any]
) -> CampaignEntry:
    where = f'{path}: recordings[{index}]'
    if isinstance(item, str):
        return CampaignEntry(_inside(folder, item, where), _name(folder, item), stated=common)
    if not isinstance(item, Mapping):
        raise SettingsError('not a mapping', where=where, found=type(item).__name__)
    name = next((item[key] for key in FILES if key in item), None)
    if not isinstance(name, str):
        raise SettingsError('file missing', where=where, expected='file: <recording>')
    level = next((item[key] for key in LEVEL_KEYS if key in item), '')
    return CampaignEntry(
        path=_inside(folder, name, where),
        name=_name(folder, name),
        level=str(level),
        pose=_pose(item, where),
        heldout=_heldout(item, where),
        joints=_joints(item, folder, where),
        stated={**common, **{key: item[key] for key in STATED if key in item}},
        layout=_own_layout(item, folder, where),
    )


def _joints(item: Mapping[str, Any], folder: Path, where: str) -> Path | None:
    if JOINTS not in item:
        return None
    named = item[JOINTS]
    path = _inside(folder, str(named), f'{where}: {JOINTS}')
    if not is_table(path):
        raise SettingsError(
            'not a file of columns',
            where=f'{where}: {JOINTS}',
            found=named,
            expected=', '.join(TABLES),
        )
    return path


def _own_layout(item: Mapping[str, Any], folder: Path, where: str) -> Path | None:
    key = next((key for key in LAYOUTS if item.get(key)), None)
    if key is None:
        return None
    if not isinstance(item[key], str):
        raise SettingsError(
            'not a file', where=f'{where}: {key}', found=item[key], expected='a sensor layout'
        )
    return _inside(folder, item[key], f'{where}: {key}')


def _pose(item: Mapping[str, Any], where: str) -> tuple[float, ...] | None:
    for key, factor in POSES.items():
        value = item.get(key)
        if isinstance(value, list):
            try:
                return tuple(float(angle) * factor for angle in value)
            except (TypeError, ValueError) as error:
                raise SettingsError('bad pose', where=where, found=value) from error
    return None


def _heldout(item: Mapping[str, Any], where: str) -> bool | None:
    for key in HELDOUT:
        if key in item:
            if not isinstance(item[key], bool):
                raise SettingsError('not true or false', where=f'{where}.{key}', found=item[key])
            return bool(item[key])
    part = next((item[key] for key in PARTS if key in item), None)
    if part is None:
        return None
    return str(part).lower().replace('-', '').replace('_', '') in ('heldout', 'test', 'validation')
