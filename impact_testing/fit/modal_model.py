"""Maximum likelihood of poles and shapes together: residues that are products of one shape.

The accelerance of channel o to a force at i is Σ_r [ψ_ro ψ_ri / (jω - p_r) + conjugates] and
residual terms that are free for each FRF.  What a structure with symmetric matrices moves at o
when struck at i it moves at i when struck at o, so that a mode has one value per place instead of
one per FRF: modes whose bands overlap come apart by their shapes.

References
----------
El-Kafafy, De Troyer, Peeters and Guillaume (2013), Fast maximum-likelihood identification of modal
parameters with uncertainty intervals: a modal model-based formulation,
doi:10.1016/j.ymssp.2013.01.003.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from impact_testing.fit.arrow import Arrow, Doubted
from impact_testing.fit.places import Places
from impact_testing.responses import (
    apart,
    derivatives,
    functions,
    PointData,
    residual_terms,
)

Complex = NDArray[np.complex128]
Real = NDArray[np.float64]
MOST_STEPS = 60
SETTLED = 1e-2
"""A step that promises so little of the sum of squares is none: a tenth of a deviation."""
LONGEST_STEP = 0.5
"""In distances of poles from the band: they keep their sign and their place."""
MOST_HELD, LEAST_HELD = 8, 1e-5
"""Solutions of one step, and share of the diagonal that first holds a mode that goes too far."""
RIDGE = 1e-12
"""Relative: scales that no FRF ties are left where they are."""
PINNED = 1e8


@dataclass(frozen=True, slots=True)
class Doubts:
    """What unknowns that all FRFs of a point share add to them, in units of the noise.

    Parameters
    ----------
    added : (2 n_lines, n_channels, n) array
        By unknowns with a deviation of one, orthogonal to one another and to residual terms.
    shift : (2 n_lines, n_channels) array
        What the unknowns added that has been taken out already.
    """

    added: Real
    shift: Real

    @classmethod
    def none(cls, data: PointData) -> 'Doubts':
        """Return no unknowns."""
        size = (2 * len(data.course), len(data.level))
        return cls(np.empty((*size, 0)), np.zeros(size))

    def without_likely(self, left: Real) -> Real:
        """Return what is left when the unknowns have explained their likely part."""
        flat, left = self.added.reshape(left.size, -1), left + self.shift
        likely = (flat.T @ left.ravel()) / (1.0 + np.sum(flat**2, axis=0))
        return np.asarray(left - (flat @ likely).reshape(left.shape))


@dataclass(frozen=True, slots=True)
class ModalModel:
    """Poles and shapes with the likelihood's derivatives.

    Parameters
    ----------
    places : Places
    pole : (n_poles,) complex array [rad/s]
    shape : (n_poles, n_places) complex array
        ψ = p φ, whose products are the amplitudes of accelerances.
    information : Arrow
        Real and imaginary parts of all poles' shapes in turn, a slot per place, then the poles.
    score : (n_places + 1, 2 n_poles) array
    shared, doubt : (n_places + 1, 2 n_poles, n) and (n, n) array
        Products of unknowns that all FRFs of a point share with the others, and with themselves.
    cost : tuple of float
        Sums of squares that are left, in units of the noise, by point.
    misfit : float
        The whole over its degrees of freedom: 1 where model and noise are right.
    highest : float [rad/s]
        Line; no half-width exceeds it.
    """

    places: Places
    pole: Complex
    shape: Complex
    information: Arrow
    score: Real
    shared: Real
    doubt: Real
    cost: tuple[float, ...]
    misfit: float
    highest: float

    def factored(self, lift: Real) -> Doubted:
        """Factor the information, with a diagonal added, (n_places + 1, 2 n_poles) array."""
        return Doubted.of(self.information.factored(self.scale, lift), self.shared, self.doubt)

    def diagonal(self) -> Real:
        """Return information on each unknown when shared ones are not known, the others are."""
        own = self.information.diagonal()
        lost = np.einsum('sin,n->si', self.shared**2, 1.0 / np.diag(self.doubt))
        return np.asarray(np.maximum(own - lost, RIDGE * own))

    @property
    def scale(self) -> Real:
        """Sizes of the unknowns: a shape's largest entry, how far poles are from the band."""
        largest = np.repeat(np.abs(self.shape).max(axis=1), 2)
        return np.vstack([np.tile(largest, (self.places.n, 1)), np.repeat(self.apart, 2)])

    @property
    def apart(self) -> Real:
        """Distance of poles from the nearest line [rad/s]: half-widths, beyond the end more.

        It is what bells change by: they are one over the distance.
        """
        beyond = np.maximum(self.pole.imag - self.highest, 0.0)
        return np.asarray(np.hypot(self.pole.real, beyond))

    def moved(self, step: Real) -> tuple[Complex, Complex]:
        """Return poles and shapes a step from here; of two conjugate poles the upper one."""
        both = step.reshape(self.places.n + 1, len(self.pole), 2)
        change = both[..., 0] + 1j * both[..., 1]
        pole, shape = self.pole + change[-1], self.shape + change[:-1].T
        # A half-width keeps its sign.
        pole = np.minimum(pole.real, LONGEST_STEP * self.pole.real) + 1j * pole.imag
        # A broad pole may step across the real axis: its mirror image is the same mode.
        below = pole.imag < 0.0
        # One that decays within a radian of the highest line is flat in the band, as a residual
        # term is: it goes no further, where its exponential has no end.
        pole = np.maximum(pole.real, -self.highest) + 1j * pole.imag
        return np.where(below, pole.conj(), pole), np.where(below[:, None], shape.conj(), shape)

    def amplitude(self, point: int) -> Complex:
        """Return amplitudes of accelerances of a point, (n_poles, n_channels) array."""
        hit = self.shape[:, [self.places.into[point]]]
        return np.asarray(self.shape[:, self.places.out[point]] * hit)

    def covariances(self) -> list[Real]:
        """Return that of each mode's shape by place, then its pole; real and imaginary in turn.

        A misfit above 1 widens it.  Where no driving point ties the scales of channels and points
        hit, the largest channel is held.
        """
        scale = self.scale
        own = self.information.diagonal() * scale**2
        # A pole beyond the band may be told by nothing at all.
        lift = RIDGE * np.maximum(own, RIDGE * own.max())
        if not self.places.tied:
            for mode, shape in enumerate(self.shape[:, : self.places.n_channels]):
                lift[int(np.argmax(np.abs(shape))), 2 * mode : 2 * mode + 2] *= PINNED / RIDGE
        factored = self.factored(lift)
        wider = max(1.0, self.misfit)
        return [
            wider * factored.inverse_of(slice(2 * mode, 2 * mode + 2))
            for mode in range(len(self.pole))
        ]

    def strength(self) -> Real:
        """Return the sum of squares that each mode explains over the misfit, (n_poles,) array.

        By Wald's test of a shape that vanishes; amplitudes are products, so that they follow the
        shape twice as fast.
        """
        found = np.zeros(len(self.pole))
        for mode, covariance in enumerate(self.covariances()):
            parts = np.stack([self.shape[mode].real, self.shape[mode].imag], axis=1).ravel()
            own = np.linalg.pinv(covariance[:-2, :-2], hermitian=True)
            found[mode] = 0.25 * float(parts @ own @ parts)
        return found


def evaluate(
    data: Sequence[PointData],
    places: Places,
    pole: Complex,
    shape: Complex,
    doubts: Sequence[Doubts] = (),
) -> ModalModel:
    """Return cost and derivatives at poles and shapes; residual terms are solved for.

    Parameters
    ----------
    data : sequence of PointData
    places, pole, shape
        See :class:`ModalModel`.
    doubts : sequence of Doubts
        Of each point; none: none.
    """
    information = Arrow(places.n + 1, 2 * len(pole), places.apart)
    score = np.zeros((places.n + 1, 2 * len(pole)))
    cost, shared, own = [], [], []
    for number, (each, into, out) in enumerate(zip(data, places.into, places.out, strict=True)):
        doubt = doubts[number] if doubts else Doubts.none(each)
        part = _Part.of(each, pole, shape[:, out], shape[:, [into]], doubt)
        part.add_to(information, into, out)
        columns = part.by_slot(len(score), into, out)
        # The unknowns are solved for, as residual terms are.
        solved = part.pull / part.doubt
        score += columns[:, :, 0] - columns[:, :, 1:] @ solved
        cost.append(part.cost - float(part.pull @ solved))
        shared.append(columns[:, :, 1:])
        own.append(part.doubt)
    values = sum(2 * len(each.course) * len(each.level) for each in data)
    unknown = score.size + sum(each.n_residual * len(each.level) for each in data)
    misfit = sum(cost) / max(1, values - unknown)
    together = np.concatenate(shared, axis=2)
    return ModalModel(
        places,
        pole,
        shape,
        information,
        score,
        together,
        np.diag(np.concatenate(own)),
        tuple(cost),
        misfit,
        2.0 * np.pi * float(data[0].frequency_hz[-1]),
    )


@dataclass(frozen=True, slots=True)
class _Part:
    """What one point says.

    Parameters
    ----------
    gram : (2, n_poles, 2, 2, n_poles, 2) array
        Products of basis functions, then of their derivatives by the poles.
    seen : (2, n_poles, 2, n_channels, 1 + n) array
        Products of those with what is left, then with what doubtful unknowns do.
    by_channel, by_hit, by_pole : (n_poles, n_channels, 2, 2) array
        How amplitudes move with the shape at the channel, that at the point hit, and the pole.
    doubt, pull : (n,) array
        Information on each of those, with that of its deviation; products with what is left.
    cost : float
        Sum of squares that is left.
    """

    gram: Real
    seen: Real
    by_channel: Real
    by_hit: Real
    by_pole: Real
    doubt: Real
    pull: Real
    cost: float

    @classmethod
    def of(
        cls, data: PointData, pole: Complex, there: Complex, hit: Complex, doubt: Doubts
    ) -> '_Part':
        """Solve for the residual terms."""
        left, functions_of, _ = remainder(data, pole, there * hit)
        n, unit = len(pole), 1.0 / np.sqrt(data.level)
        left = left + doubt.shift
        both = np.concatenate([left[:, :, None], doubt.added], axis=2)
        n_channels, n_seen = both.shape[1:]
        flat = doubt.added.reshape(left.size, n_seen - 1)
        return cls(
            gram=(functions_of.T @ functions_of).reshape(2, n, 2, 2, n, 2),
            seen=(functions_of.T @ both.reshape(len(both), -1)).reshape(
                2, n, 2, n_channels, n_seen
            ),
            by_channel=_form(hit * unit),
            by_hit=_form(there * unit),
            by_pole=_form(there * hit * unit),
            doubt=1.0 + np.sum(flat**2, axis=0),
            pull=flat.T @ left.ravel(),
            cost=float(np.sum(left**2)),
        )

    def add_to(self, information: Arrow, into: int, out: NDArray[np.int64]) -> None:
        """Add information; a block of a slot with itself is added in halves."""
        size, poles = information.size, information.n_slots - 1
        basis, mixed, own = self.gram[0, :, :, 0], self.gram[0, :, :, 1], self.gram[1, :, :, 1]

        def each(first: Real, gram: Real, second: Real) -> Real:
            found = np.einsum('nora,nrms,mosb->onamb', first, gram, second, optimize=True)
            return np.asarray(found.reshape(len(found), size, size))

        channel, hit, pole = self.by_channel, self.by_hit, self.by_pole
        blocks = (
            each(channel, basis, channel),
            each(channel, basis, hit),
            each(channel, mixed, pole),
        )
        for place, alone, with_hit, with_pole in zip(out, *blocks, strict=True):
            information.add(place, place, 0.5 * alone)
            information.add(place, into, with_hit)
            information.add(place, poles, with_pole)
        information.add(into, into, 0.5 * each(hit, basis, hit).sum(axis=0))
        information.add(into, poles, each(hit, mixed, pole).sum(axis=0))
        information.add(poles, poles, 0.5 * each(pole, own, pole).sum(axis=0))

    def by_slot(self, n_slots: int, into: int, out: NDArray[np.int64]) -> Real:
        """Return what was seen as a score by slots, (n_slots, 2 n_poles, 1 + n) array."""
        n_seen = self.seen.shape[-1]
        found = np.zeros((n_slots, 2 * len(self.by_hit), n_seen))
        channel, hit, pole = self.by_channel, self.by_hit, self.by_pole

        def each(form: Real, seen: Real, to: str) -> Real:
            turned = np.einsum(f'nora,nrot->{to}', form, seen, optimize=True)
            return np.asarray(turned.reshape(*turned.shape[:-3], found.shape[1], n_seen))

        found[out] += each(channel, self.seen[0], 'onat')
        found[into] += each(hit, self.seen[0], 'nat')
        found[-1] += each(pole, self.seen[1], 'nat')
        return found


def remainder(data: PointData, pole: Complex, amplitude: Complex) -> tuple[Real, Real, Real]:
    """Return what is left of a point, the poles' functions, and directions of residual terms.

    Parameters
    ----------
    amplitude : (n_poles, n_channels) complex array
        Of accelerances.

    Returns
    -------
    left : (2 n_lines, n_channels) array
    functions : (2 n_lines, 4 n_poles) array
        Basis functions and their derivatives, both without what residual terms explain.
    directions : (2 n_lines, n_residual) array
    """
    basis = functions(data, pole)
    directions = np.linalg.qr(basis[:, -data.n_residual :])[0]
    both = np.concatenate([basis[:, : -data.n_residual], derivatives(data, pole)], axis=1)
    both = both - directions @ (directions.T @ both)
    parts = _parts(amplitude / np.sqrt(data.level))
    left = apart(data.target)
    left = left - directions @ (directions.T @ left) - both[:, : len(parts)] @ parts
    return np.asarray(left), np.asarray(both), directions


def climb(
    data: Sequence[PointData],
    places: Places,
    pole: Complex,
    shape: Complex,
    enough: float = -np.inf,
    doubts: Sequence[Doubts] = (),
    settled: float = SETTLED,
) -> ModalModel:
    """Climb to the maximum of the likelihood, to a cost, or until a step promises too little.

    References
    ----------
    Levenberg and Marquardt; damped by how much of what a step promises it keeps (Nielsen 1999,
    Damping parameter in Marquardt's method, IMM-REP-1999-05).
    """
    now, damping, harder = evaluate(data, places, pole, shape, doubts), 1e-3, 2.0
    held = np.zeros(len(pole))
    for _ in range(MOST_STEPS if len(pole) else 0):
        held, lift, step = _step(now, damping, held / 3.0)
        # By the score here: that of where it leads is against the step when it went too far.
        promised = float(np.sum(step * now.score))
        there = evaluate(data, places, *now.moved(step), doubts)
        kept = (sum(now.cost) - sum(there.cost)) / (
            promised + float(np.sum(lift * (step / now.scale) ** 2)) + 1e-300
        )
        if not kept >= 0.0:  # or no number: a pole far on the other side
            damping, harder = damping * harder, 2.0 * harder
        else:
            now, harder = there, 2.0
            damping = max(damping * max(1.0 / 3.0, 1.0 - (2.0 * kept - 1.0) ** 3), 1e-9)
        if promised < settled or damping > 1e8 or sum(now.cost) < enough:
            break
    return now


def _step(now: ModalModel, damping: float, held: Real) -> tuple[Real, Real, Real]:
    """Return a step, with the diagonal that holds it, and by how much it holds each mode.

    A pole that would go too far is held more until it does not, so that one that wanders does not
    hold up the others.
    """
    scale = now.scale
    diagonal = now.diagonal() * scale**2
    least = damping * diagonal + RIDGE * diagonal.max()
    for _ in range(MOST_HELD):
        lift = least + np.repeat(held, 2) * diagonal
        step = now.factored(lift).solve(now.score)
        longest = np.abs(step[-1] / scale[-1]).reshape(-1, 2).max(axis=1) / LONGEST_STEP
        if (longest <= 1.0).all():
            break
        held = np.where(longest > 1.0, np.maximum(held, damping + LEAST_HELD) * 2 * longest, held)
    return held, lift, step / max(1.0, float(longest.max()))


def synthesised(data: PointData, pole: Complex, amplitude: Complex) -> Complex:
    """Return the model's FRFs in the band [m/s²/N], (n_lines, n_channels) array.

    Without what the ends of segments add: what endless segments would show.
    """
    s = 2j * np.pi * data.frequency_hz
    found = (1.0 / (s[:, None] - pole)) @ amplitude
    found = found + (1.0 / (s[:, None] - pole.conj())) @ amplitude.conj()
    return found + residual(data, pole, amplitude)


def residual(data: PointData, pole: Complex, amplitude: Complex) -> Complex:
    """Return what residual terms explain of a point's FRFs, (n_lines, n_channels) array."""
    basis = functions(data, pole)
    parts = _parts(amplitude / np.sqrt(data.level))
    left = apart(data.target) - basis[:, : -data.n_residual] @ parts
    coefficients = np.linalg.lstsq(basis[:, -data.n_residual :], left, rcond=None)[0]
    return np.asarray(residual_terms(data) @ coefficients * np.sqrt(data.level))


def _parts(values: Complex) -> Real:
    """Return real and imaginary parts of rows in turn."""
    both = np.stack([values.real, values.imag], axis=1)
    return np.asarray(both.reshape(2 * len(values), values.shape[1]))


def _form(values: Complex) -> Real:
    """Return multiplication by complex numbers as real 2 by 2 matrices, in the last two axes."""
    return np.stack(
        [np.stack([values.real, -values.imag], -1), np.stack([values.imag, values.real], -1)], -2
    )
