"""Every colour of the reports, light and dark: the one file to touch for another look.

Text stands out of its ground by 4.5 : 1 and what a chart draws by 3 : 1 (WCAG 2.1, 1.4.3 and
1.4.11), except the poles that were turned down, which are to stay in the background.  Colours
that are to be told apart stay apart for readers without red or green cones.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
import math

# Role -> (light, dark).
ROLES: Mapping[str, tuple[str, str]] = {
    'paper': ('#ffffff', '#12171d'),
    'ink': ('#17212c', '#e4e9ee'),
    'soft': ('#5a6875', '#9aa7b4'),
    'faint': ('#9aa6b1', '#6b7884'),
    'rule': ('#e2e7ec', '#28313a'),
    'panel': ('#f6f8fa', '#1a2129'),
    'accent': ('#1c5d99', '#6aaee6'),
    'accent-soft': ('#c9dcee', '#264a69'),
    'bad': ('#b3382c', '#ec7a6c'),
    'harmonic': ('#8a4fa3', '#c08ad8'),
    'candidate': ('#a06414', '#dba04a'),
    'unstable': ('#a9b4be', '#5d6a76'),
    'unphysical': ('#c6ced6', '#424d57'),
    'spectrum': ('#47545f', '#a7b3be'),
    'measured': ('#334155', '#cbd5e1'),
    'before': ('#c2410c', '#fb923c'),
    'after': ('#0f766e', '#2dd4bf'),
    'shadow': ('#0000002e', '#00000080'),
    'edge': ('#00000055', '#ffffff66'),
}
# From little to much, even in lightness: ColorBrewer's YlOrRd, and its mirror on dark ground.
HEAT = (
    ('#ffffcc', '#232a33'),
    ('#ffeda0', '#3d2b3f'),
    ('#fed976', '#5f2a4e'),
    ('#feb24c', '#862f50'),
    ('#fd8d3c', '#ad3f4b'),
    ('#fc4e2a', '#d25a3d'),
    ('#e31a1c', '#ee8535'),
    ('#b10026', '#f9bd4b'),
)
HEAT_INK = ('#0b1218', '#ffffff')
# What matplotlib draws where it is told no colour.
BLACK = '#000000'
# Curves of pictures of which no one has a role, (light, dark); the first three are told apart by
# everyone.
SERIES = (
    ('#1c5d99', '#6aaee6'),
    ('#c2410c', '#fb923c'),
    ('#0f766e', '#2dd4bf'),
    ('#a06414', '#dba04a'),
    ('#8a4fa3', '#c08ad8'),
    ('#7f5539', '#c8a27c'),
    ('#5a6875', '#9aa7b4'),
)


@dataclass(frozen=True, slots=True)
class HeatScale:
    """Which step of the heat colours a value has.

    Parameters
    ----------
    low, high : float
        First and last step.
    logarithmic : bool
        Steps of equal ratio instead of equal difference.
    """

    low: float
    high: float
    logarithmic: bool = False

    def step(self, value: float) -> int:
        """Return the step, 0 to 7; values outside have the step at the end."""
        inside = min(max(value, self.low), self.high)
        if self.logarithmic:
            share = math.log(inside / self.low) / math.log(self.high / self.low)
        else:
            share = (inside - self.low) / (self.high - self.low)
        return min(int(share * len(HEAT)), len(HEAT) - 1)


def style_sheet() -> str:
    """Return the colours as CSS variables, and a class for each step of the heat colours.

    The reader's system chooses between light and dark, ``data-theme`` of the root overrules it,
    and paper is always light.
    """
    light, dark = (''.join(_variables(side)) for side in (0, 1))
    heat = ''.join(
        f'.heat-{step}{{fill:var(--heat-{step})}}svg text.on-heat-{step}'
        f'{{fill:var(--heat-ink-{step})}}'
        for step in range(len(HEAT))
    )
    return (
        f':root{{{light}}}\n'
        '@media screen and (prefers-color-scheme: dark)'
        f"{{:root:not([data-theme='light']){{{dark}}}}}\n"
        f"@media screen{{:root[data-theme='dark']{{{dark}}}}}\n{heat}"
    )


def on_white(role: str) -> str:
    """Return the colour of a role for pictures that are on white paper everywhere."""
    return ROLES[role][0]


def contrast(one: str, other: str) -> float:
    """Return the contrast ratio of two colours, 1 to 21 (WCAG 2.1)."""
    low, high = sorted((_luminance(one), _luminance(other)))
    return (high + 0.05) / (low + 0.05)


def _variables(side: int) -> Iterator[str]:
    for name, colours in ROLES.items():
        yield f'--{name}:{colours[side]};'
    for step, colours in enumerate(HEAT):
        ink = max(HEAT_INK, key=lambda ink: contrast(ink, colours[side]))
        yield f'--heat-{step}:{colours[side]};--heat-ink-{step}:{ink};'


def _luminance(colour: str) -> float:
    channels = (int(colour[at : at + 2], 16) / 255.0 for at in (1, 3, 5))
    red, green, blue = (
        share / 12.92 if share <= 0.04045 else ((share + 0.055) / 1.055) ** 2.4
        for share in channels
    )
    return 0.2126 * red + 0.7152 * green + 0.0722 * blue
