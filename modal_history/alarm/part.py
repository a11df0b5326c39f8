"""Which part of a robot has changed, by how much, and how sure that is."""

from dataclasses import asdict, dataclass
import json
import math

SURE = 0.95
"""Chance from which one part is named alone; below it all that together reach it are listed."""
MOST_LISTED = 4
WORDS = {
    'drive': ('softer', 'stiffer'),
    'joint': ('softer', 'stiffer'),
    'bearing': ('softer', 'stiffer'),
    'base': ('softer', 'stiffer'),
    'all joints': ('softer', 'stiffer'),
    'load': ('lighter', 'heavier'),
}


@dataclass(frozen=True, slots=True)
class Suspect:
    """One part that may have changed.

    Parameters
    ----------
    kind : str
        ``drive``, ``bearing`` or ``joint`` (one of the two) of a joint, ``base``, ``all joints``,
        ``load``.
    place : str
        Joint; empty where the kind says all.
    change, change_std : float
        Of the stiffness as a share of it; of the load [kg].
    chance : float
        That it is this part, of those that the model has.
    """

    kind: str
    place: str
    change: float
    change_std: float
    chance: float

    @property
    def name(self) -> str:
        """What it is called."""
        return (
            f'{self.kind} of {self.place}' if self.kind == 'bearing' else self.place or self.kind
        )

    def words(self) -> str:
        """Say what, which way, by how much."""
        less, more = WORDS.get(self.kind, ('less', 'more'))
        way = less if self.change < 0.0 else more
        share = self.kind != 'load'
        factor, unit = (100.0, '%') if share else (1.0, 'kg')
        size, std = abs(self.change) * factor, self.change_std * factor
        digits = max(0, -math.floor(math.log10(std))) if 0.0 < std < math.inf else 1
        return f'{self.name} {way} by {size:.{digits}f} ± {std:.{digits}f} {unit}'


@dataclass(frozen=True, slots=True)
class Part:
    """What a change goes back to.

    Parameters
    ----------
    suspects : tuple of Suspect
        By chance, as many as reach :data:`SURE` together; empty where nothing can be told.
    why : str
        Why no single one is named; empty where one is.
    """

    suspects: tuple[Suspect, ...] = ()
    why: str = ''

    @property
    def named(self) -> Suspect | None:
        """The one part, where the data tell."""
        return self.suspects[0] if self.suspects and not self.why else None

    def words(self) -> str:
        """Say which part, or why that is not known."""
        if self.named is not None:
            return self.named.words()
        listed = ' or '.join(each.name for each in self.suspects[:MOST_LISTED])
        more = ' or others' if len(self.suspects) > MOST_LISTED else ''
        return f'{listed}{more}: {self.why}' if listed else self.why

    def to_json(self) -> str:
        """Return it as text."""
        return json.dumps(asdict(self))

    @classmethod
    def from_json(cls, text: str) -> 'Part':
        """Return it from text.

        Raises
        ------
        ValueError, TypeError, KeyError, AttributeError
            No program of the suite has written it.
        """
        data = json.loads(text)
        return cls(tuple(Suspect(**each) for each in data['suspects']), str(data['why']))
