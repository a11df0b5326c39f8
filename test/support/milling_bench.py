"""A cut as equations of motion in time: regenerative, linear, integrated by Runge and Kutta.

Knows nothing of the room under test: its own angles, its own force, its own time steps.
"""

import numpy as np

STEPS = 240
"""Per tooth period: 40 per cycle of the highest mode at least, of fourth order."""


def growth(modes, teeth, engaged, pressures, speed_rpm, depth, periods):
    """Return by what a small vibration is multiplied per tooth period in the long run.

    modes: frequency_hz, damping_ratio, shape (n, 3) at unit modal mass; engaged: entry and exit
    angle; pressures: tangential, radial [N/m²].
    """
    omega, period = 2 * np.pi * modes.frequency_hz, 60.0 / teeth / speed_rpm
    shape, ratio = modes.shape[:, :2], modes.damping_ratio
    n, h = len(omega), period / STEPS
    x, v = np.ones(n), np.zeros(n)
    past = np.zeros((2 * STEPS + 1, 2))
    past[:] = x @ shape
    gains = [
        _gain(2 * np.pi / teeth * i / (2 * STEPS), teeth, engaged, pressures) * depth
        for i in range(2 * STEPS + 1)
    ]

    def rate(x, v, j, past):
        force = gains[j] @ (x @ shape - past[j])
        return v, shape @ force - omega**2 * x - 2 * ratio * omega * v

    sizes = []
    for _ in range(periods):
        new = np.empty_like(past)
        new[0] = x @ shape
        for i in range(STEPS):
            j = 2 * i
            a = rate(x, v, j, past)
            b = rate(x + h / 2 * a[0], v + h / 2 * a[1], j + 1, past)
            c = rate(x + h / 2 * b[0], v + h / 2 * b[1], j + 1, past)
            d = rate(x + h * c[0], v + h * c[1], j + 2, past)
            old_x, old_v = x, v
            x = x + h / 6 * (a[0] + 2 * b[0] + 2 * c[0] + d[0])
            v = v + h / 6 * (a[1] + 2 * b[1] + 2 * c[1] + d[1])
            # The middle of a step by Hermite, for the next period's middle stages.
            new[j + 1] = ((old_x + x) / 2 + h / 8 * (old_v - v)) @ shape
            new[j + 2] = x @ shape
        size = np.sqrt(np.sum((omega * x) ** 2 + v**2) + np.mean((omega.max() * new) ** 2))
        x, v, past = x / size, v / size, new / size
        sizes.append(np.log(size))
    half = len(sizes) // 2
    return float(np.exp(np.mean(sizes[half:])))


def _gain(angle, teeth, engaged, pressures):
    total = np.zeros((2, 2))
    for tooth in range(teeth):
        at = (angle + 2 * np.pi * tooth / teeth) % (2 * np.pi)
        if engaged[0] <= at <= engaged[1]:
            s, c = np.sin(at), np.cos(at)
            t, r = pressures
            total += np.outer([-t * c - r * s, t * s - r * c], [s, c])
    return total
