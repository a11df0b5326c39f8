"""Model and measurement side by side in every quantity people look at."""

from dataclasses import dataclass

from modal_core.work.progress import Progress
from model_gap.comparison.amplitude import level_changes, LevelChange
from model_gap.comparison.excitation import Excitation, excitation
from model_gap.comparison.harmonics import lines_seen, LineSeen
from model_gap.comparison.spectra_pairs import spectra_pairs, SpectraPair
from model_gap.comparison.transmissibility import sensor_bands, SensorBand
from model_gap.find_gap import GapResult
from model_gap.modes import mode_pairs, ModePair


@dataclass(frozen=True)
class ModelComparison:
    """All of it.

    Parameters
    ----------
    excitation : Excitation
        What shook the arm and how well that is known.
    pairs : tuple of SpectraPair
        Spectra of every recording.
    sensors : tuple of SensorBand
        Transmissibility and spectra by sensor and band.
    modes : tuple of ModePair
        Natural frequencies, damping ratios and shapes.
    levels : tuple of LevelChange
        Amplitude dependence by band.
    lines : tuple of LineSeen
        Harmonics and other lines.
    """

    excitation: Excitation
    pairs: tuple[SpectraPair, ...]
    sensors: tuple[SensorBand, ...]
    modes: tuple[ModePair, ...]
    levels: tuple[LevelChange, ...]
    lines: tuple[LineSeen, ...]


def compare_model(result: GapResult, progress: Progress = lambda _: None) -> ModelComparison:
    """Compare model and measurement, before and after.

    Parameters
    ----------
    result : GapResult
        Of :func:`find_gap`.
    progress : callable
        Takes the fraction done.
    """
    search = result.search
    names = [channel.name for channel in search.campaign.layout.channels]
    pairs = spectra_pairs(search, result.final)
    known = excitation(search.campaign, pairs)
    progress(0.2)
    modes = mode_pairs(
        search, result.calibrated, min(search.settings.band.high_hz, known.highest_hz)
    )
    progress(1.0)
    return ModelComparison(
        excitation=known,
        pairs=pairs,
        sensors=sensor_bands(pairs, names),
        modes=modes,
        levels=level_changes(pairs),
        lines=lines_seen(pairs, search.scene.lines_hz, names),
    )
