"""The verdict in words."""

from collections.abc import Mapping
import math

from modal_reports import capital, percent, with_sigma
from model_gap.decide import Verdict
from model_gap.find_gap import GapResult
from model_gap.gap_json import accepted_effects
from structural_model.spec import KnownEffect

NO_GAP = 'Model and robot agree: what differs is noise and known tolerance'
TOO_LITTLE = 'No gap shows in what was recorded, which is too little to say that there is none'
STRANGE = 'There is a gap, and nothing in the catalogue explains it'
# What each effect says of the robot, in a plain sentence; {place} and the parameters by name.
SENTENCES: Mapping[str, str] = {
    'payload': '{place} carries {mass:+.3g} kg that the model does not have',
    'joint_damping': '{place} is damped {factor:.3g} times as much as the model says',
    'base_compliance': 'The base gives way: the robot rocks on its foundation',
    'link_flexibility': '{place} bends, and the model has it stiff',
    'rod_spring': 'A rod couples joints 2 and 3 that the model does not have',
    'coulomb_friction': '{place} has dry friction of {torque:.3g} N m',
    'backlash': '{place} has play: {half_gap:.2g} rad to either side',
    'cubic_stiffness': 'The stiffness of {place} changes with its twist',
    'speed_dependent_stiffness': 'The stiffness of {place} changes with its speed',
    'transmission_error': 'The gear of {place} runs unevenly',
    'tonal_disturbance': 'Something shakes {place} steadily at {frequency:.4g} Hz',
    'servo_compliance': 'The drives give way: they do not hold their motors still',
    'tuned_mass': 'A mass of {mass:.3g} kg swings on {place} at {frequency:.3g} Hz',
    'command_delay': 'All sensors show the recorded motion {milliseconds:.3g} ms {late}',
    'sensor_gain': '{place} reads {gain:.3g} times what is there',
    'sensor_polarity': '{place} is connected the wrong way round',
    'sensor_axis_swap': 'Two axes of {place} are exchanged',
    'sensor_rotation': '{place} is mounted turned by {degrees:.3g}°',
    'sensor_delay': '{place} is {milliseconds:.3g} ms {late}',
    'sensor_mount_resonance': 'The mount of {place} is soft and resonates at {frequency:.3g} Hz',
    'sensor_mass': '{place} weighs {mass:.3g} kg itself',
}


def headline(result: GapResult) -> str:
    """Return the verdict as one plain sentence."""
    verdict = result.decision.verdict
    if verdict is Verdict.NONE:
        return TOO_LITTLE if result.decision.reasons else NO_GAP
    if verdict is Verdict.UNEXPLAINED:
        return STRANGE
    found = '; '.join(sentence(effect) for effect in accepted_effects(result))
    if verdict is Verdict.NAMED:
        return found
    return f'Perhaps: {found[:1].lower()}{found[1:]}. This is not certain yet'


def sentence(effect: KnownEffect) -> str:
    """Return what an effect says of the robot."""
    numbers = {item.name: item.value for item in effect.parameters}
    turn = [value for name, value in numbers.items() if name.startswith('rotation_')]
    delay = numbers.get('delay', math.nan)
    place = place_words(effect)
    if effect.type == 'joint_stiffness':
        change = 100.0 * (numbers['factor'] - 1.0)
        kind = 'softer' if change < 0.0 else 'stiffer'
        text = f'{place} is {abs(change):.0f} % {kind} than the model says'
    else:
        text = SENTENCES.get(
            effect.type, effect.type.replace('_', ' ') + ' at {place}'
        ).format_map(
            _Numbers(
                numbers,
                place=place,
                milliseconds=1e3 * abs(delay),
                late='early' if delay < 0.0 else 'late',
                degrees=math.degrees(math.hypot(*turn)) if turn else math.nan,
            )
        )
    return capital(text)


class _Numbers(dict):  # type: ignore[type-arg]
    def __missing__(self, name: str) -> float:
        return math.nan


def place_words(effect: KnownEffect) -> str:
    """Return where an effect is, as people say it."""
    place = effect.location or 'the robot'
    if place.startswith('sensor:'):
        axis = f'axis {effect.variant} of ' if effect.variant in ('x', 'y', 'z') else ''
        return f'{axis}sensor {place.removeprefix("sensor:")}'
    return place.replace('_', ' ')


def effect_words(result: GapResult) -> list[str]:
    """Return one line per effect: what, where, how much."""
    lines = []
    for effect in accepted_effects(result):
        place = f' at {effect.location}' if effect.location else ''
        variant = f' ({effect.variant})' if effect.variant else ''
        numbers = ', '.join(
            f'{item.name.replace("_", " ")} {with_sigma(item.value, item.sigma, item.unit)}'
            for item in effect.parameters
        )
        name = effect.type.replace('_', ' ')
        lines.append(f'{name}{place}{variant}' + (f': {numbers}' if numbers else ''))
    return lines


def summary_lines(result: GapResult) -> list[str]:
    """Return what the command line prints."""
    lines = [f'{result.decision.verdict.value}: {headline(result)}']
    lines += [f'  {line}' for line in effect_words(result)]
    lines += [f'  because {line}' for line in result.decision.reasons]
    lines += [f'  next: {line}' for line in result.decision.experiments]
    lines.append(
        f'gap, held-out poses: {percent(result.gap_before_heldout)} before, '
        f'{percent(result.gap_after_heldout)} after, noise {percent(result.noise_floor)}'
    )
    lines.append(
        f'gap, fitted poses: {percent(result.gap_before)} before, '
        f'{percent(result.gap_after)} after'
    )
    lines += [f'note: {line}' for line in result.search.notes]
    return lines
