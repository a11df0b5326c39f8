"""True modes of a plant as an identification would list them."""

from benchmarks.identifier.plant import Plant
from modal_core.mode import Mode, ModeSet
from modal_core.samples import Samples


def modes_of(plant: Plant, samples: Samples, chosen: list[int]) -> ModeSet:
    modes = tuple(
        Mode(
            float(plant.frequency_hz[index]),
            float(plant.damping_ratio[index]),
            plant.shapes[:, index].astype(complex),
        )
        for index in chosen
    )
    return ModeSet(modes, samples.channel_names)
