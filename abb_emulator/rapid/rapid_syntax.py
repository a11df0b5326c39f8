"""What a RAPID module is made of once it has been read."""

from collections.abc import Mapping
from dataclasses import dataclass

# Predefined speeds: tool speed [mm/s]; all turn at 500 deg/s.
SPEED_NAMES = {
    f'v{speed}': (float(speed), 500.0, 5000.0, 1000.0)
    for speed in (
        *(5, 10, 20, 30, 40, 50, 60, 80, 100, 150, 200, 300, 400, 500, 600, 800),
        *(1000, 1500, 2000, 2500, 3000, 4000, 5000, 6000, 7000),
    )
}
SPEED_FIELDS = ('v_tcp', 'v_ori', 'v_leax', 'v_reax')
NUM, JOINT_ROW, TARGET, SPEED, MIN_MAX = (
    'num',
    'robjoint',
    'jointtarget',
    'speeddata',
    'egm_minmax',
)
IDENT, STRING, BOOL = 'egmident', 'string', 'bool'
KINDS = (NUM, JOINT_ROW, TARGET, SPEED, MIN_MAX, IDENT, STRING)

Literal = float | str | tuple['Literal', ...]


@dataclass(frozen=True, slots=True)
class Constant:
    """A value written where it is used.

    Parameters
    ----------
    value : number, string or nested tuple
        As written.
    """

    value: Literal


@dataclass(frozen=True, slots=True)
class Reference:
    """A name, of data or of an element of an array.

    Parameters
    ----------
    name : str
        In lower case: RAPID does not tell cases apart.
    index : value or None
        Element, counted from 1.
    fields : tuple of str
        Components, outermost first.
    """

    name: str
    index: 'Value | None' = None
    fields: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class Operation:
    """Two values and what is done with them.

    Parameters
    ----------
    line : int
        Where it stands.
    sign : str
        ``+ -`` give a number; ``< <= > >= = <>`` and ``or and`` a truth.
    left, right : value
        Operands.
    """

    line: int
    sign: str
    left: 'Value'
    right: 'Value'


@dataclass(frozen=True, slots=True)
class Function:
    """A function's value.

    Parameters
    ----------
    line : int
        Where it stands.
    name : str
        In lower case.
    arguments : tuple of values
        Positional ones.
    """

    line: int
    name: str
    arguments: tuple['Value', ...]


Value = Constant | Reference | Operation | Function


@dataclass(frozen=True, slots=True)
class Call:
    """One instruction.

    Parameters
    ----------
    line : int
        Where it begins.
    name : str
        In lower case.
    arguments : tuple
        Positional ones.
    options : mapping of str to value or None
        Optional ones in lower case; None is a switch.
    """

    line: int
    name: str
    arguments: tuple[Value, ...]
    options: Mapping[str, Value | None]


@dataclass(frozen=True, slots=True)
class Assignment:
    """``name[.field] := value``.

    Parameters
    ----------
    line : int
        Where it begins.
    name, field : str
        In lower case; field may be empty.
    value : value
        What is assigned.
    """

    line: int
    name: str
    field: str
    value: Value


@dataclass(frozen=True, slots=True)
class Loop:
    """``FOR variable FROM first TO last DO``.

    Parameters
    ----------
    line : int
        Where it begins.
    variable : str
        In lower case.
    first, last : value
        Inclusive.
    body : tuple
        Statements.
    """

    line: int
    variable: str
    first: Value
    last: Value
    body: tuple['Statement', ...]


@dataclass(frozen=True, slots=True)
class Branch:
    """``IF condition THEN``.

    Parameters
    ----------
    line : int
        Where it begins.
    condition : value
        A truth.
    body : tuple
        Statements.
    """

    line: int
    condition: Value
    body: tuple['Statement', ...]


Statement = Call | Assignment | Loop | Branch


@dataclass(frozen=True, slots=True)
class Datum:
    """One declaration.

    Parameters
    ----------
    line : int
        Where it begins.
    kind : str
        RAPID type.
    rows : int
        Elements; 0 is no array.
    value : nested tuple, number, string
        At the start of the program.
    storage : str
        ``const``, ``var`` or ``pers``.
    """

    line: int
    kind: str
    rows: int
    value: Literal
    storage: str

    @property
    def constant(self) -> bool:
        """No program may assign to it."""
        return self.storage == 'const'


@dataclass(frozen=True, slots=True)
class Procedure:
    """A PROC without parameters.

    Parameters
    ----------
    line : int
        Where it begins.
    body, handler : tuple
        Statements, and those after ERROR.
    """

    line: int
    body: tuple[Statement, ...]
    handler: tuple[Statement, ...]


@dataclass(frozen=True, slots=True)
class Module:
    """One RAPID module, read and checked.

    Parameters
    ----------
    name : str
        As written.
    data : mapping of str to Datum
        By name in lower case.
    procedures : mapping of str to Procedure
        By name in lower case; ``main`` is among them.
    """

    name: str
    data: Mapping[str, Datum]
    procedures: Mapping[str, Procedure]
