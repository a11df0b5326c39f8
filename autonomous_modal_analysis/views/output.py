"""What people see of an identification, and the files it leaves."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from rich.markup import escape

from autonomous_modal_analysis.console.terminal import MESSAGES, OUTPUT
from autonomous_modal_analysis.identified.identification import IdentifiedRecording
from autonomous_modal_analysis.identified.mode_tracks import mode_tracks
from autonomous_modal_analysis.identified.results import (
    Identification,
    SetUps,
    write_csv,
    write_json,
)
from autonomous_modal_analysis.report import (
    channel_spectra,
    ReportContent,
    TrueMode,
    write_report,
)
from autonomous_modal_analysis.report.words import band_words
from autonomous_modal_analysis.views.modes_table import modes_table
from modal_core.files.version import software
from modal_core.mode import ModeSet
from modal_reports import ChannelSpectra, Spectrum

if TYPE_CHECKING:
    from autonomous_modal_analysis.api.found_modes import Placed

JSON_NAME, CSV_NAME, REPORT_NAME = 'modes.json', 'modes.csv', 'report.html'


def show_damage(damage: Sequence[str]) -> None:
    """Say on standard error what of a recording could not be read."""
    for statement in damage:
        MESSAGES.print(f'[yellow]damaged[/]: {escape(statement)}', soft_wrap=True)


def show_identification(found: IdentifiedRecording, name: str) -> None:
    """Print the modes of a recording for people."""
    identification = found.identification
    if len(identification.modes):
        OUTPUT.print(modes_table((*identification.modes, *identification.harmonics), name))
    else:
        reason = identification.quality.reason or 'no mode stands out of the noise'
        OUTPUT.print(f'no modes: {escape(reason)}')
    identified = sum(1 for window in identification.windows if len(window.modes))
    OUTPUT.print(f'{identified} of {len(identification.windows)} windows gave modes')
    for track in mode_tracks(identification.windows):
        if track.moves_with_pose:
            OUTPUT.print(track.words())
    if identification.band is not None:
        OUTPUT.print(band_words(identification.band))
    if identification.sliding is not None:
        OUTPUT.print(identification.sliding.words(), soft_wrap=True, markup=False)
    for remark in identification.remarks:
        OUTPUT.print(f'note: {escape(remark)}', soft_wrap=True)


def show_exported(file: Path) -> None:
    """Say which file was written."""
    MESSAGES.print(f'written: {file}', soft_wrap=True, markup=False)


def export_each(files: Iterable[Path] | None, export: Callable[[Path], None]) -> None:
    """Write a result into each file that was asked for, and say so."""
    for file in files or ():
        export(file)
        show_exported(file)


def show_kept(file: Path, n_new: int) -> None:
    """Say how many results a history got."""
    said = f'{n_new} results added' if n_new else 'all results were there already'
    MESSAGES.print(f'history {file}: {said}', soft_wrap=True, markup=False)


def save_results(
    folder: Path,
    found: IdentifiedRecording,
    name: str,
    *,
    title: str = 'Operational modal analysis',
    truth: tuple[TrueMode, ...] | None = None,
    placed: 'Placed | None' = None,
    provenance: Mapping[str, str] | None = None,
) -> None:
    """Write modes.json, modes.csv and report.html into a folder."""
    whole = found.whole.spectrum
    spectrum = Spectrum(whole.frequency_hz, whole.singular_value)
    content = ReportContent(
        title=title,
        recording=name,
        identification=found.identification,
        poles=found.whole.poles,
        spectrum=spectrum,
        truth=truth,
        geometry=placed[0] if placed else None,
        displacements=placed[1] if placed else (),
        spectra=_spectra(found),
        spectrogram=found.spectrogram,
        provenance={'software': software(), **(provenance or {})},
    )
    write_json(folder / JSON_NAME, found.identification, name, spectrum)
    write_csv(folder / CSV_NAME, found.identification)
    write_report(folder / REPORT_NAME, content)


def _spectra(found: IdentifiedRecording) -> ChannelSpectra | None:
    """Return the spectra of the channels over the analysed band."""
    band = found.identification.band
    if not found.parts or band is None:
        return None
    hz = (band.low_hz, band.high_hz)
    return channel_spectra(found.parts[0], tuple(found.identification.modes), hz)


def show_written(folder: Path, names: Sequence[str] = (JSON_NAME, CSV_NAME, REPORT_NAME)) -> None:
    """Say on standard error which files were written."""
    MESSAGES.print(f'written: {folder}/{{{", ".join(names)}}}', soft_wrap=True)


def merged_words(modes: ModeSet, set_ups: SetUps) -> list[str]:
    """Say in a few lines what merging set-ups came to."""
    if not len(modes):
        return ['no modes: no set-up shows one']
    everywhere = sum(len(seen) == len(set_ups.names) for seen in set_ups.seen_in)
    missing = int(np.isnan(modes.shapes).any(axis=0).sum())
    said = [f'{everywhere} of {len(modes)} modes are in all set-ups']
    if n_read := sum(bool(read) for read in set_ups.read_in):
        said[0] += f'; {n_read} are read out of others, too'
    if missing:
        said[0] += f'; {missing} lack points that were not seen'
    said.append(
        f'frequencies scatter by {100.0 * set_ups.frequency_scatter:.2g} % between set-ups,'
        f' damping by {100.0 * set_ups.damping_scatter:.2g} %: their ± contains it'
    )
    return [*said, f'references: {", ".join(set_ups.references)}']


def write_merged(folder: Path, identification: Identification, names: Sequence[str]) -> None:
    """Write modes.json and report.html of merged set-ups into a folder."""
    content = ReportContent(
        title='Operational modal analysis, set-ups merged',
        recording=', '.join(names),
        identification=identification,
        provenance={'software': software()},
    )
    write_json(folder / JSON_NAME, identification, ', '.join(names))
    write_report(folder / REPORT_NAME, content)
