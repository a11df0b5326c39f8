"""Names and values of a running RAPID module, and what its expressions say."""

from collections.abc import Callable, Mapping
import math
import operator

from abb_emulator.controller import Controller
from abb_emulator.controller_settings import RapidError
from abb_emulator.rapid.rapid_syntax import (
    Assignment,
    Call,
    Constant,
    Function,
    Literal,
    Module,
    Operation,
    SPEED_FIELDS,
    SPEED_NAMES,
    Value,
)
from abb_emulator.rapid.rapid_tokens import refuse

RECORDS = (
    SPEED_FIELDS,
    ('robax', 'extax'),
    tuple(f'rax_{axis}' for axis in range(1, 7)),
    tuple(f'eax_{letter}' for letter in 'abcdef'),
)
OPERATORS: Mapping[str, Callable[[float, float], float | bool]] = {
    '+': operator.add, '-': operator.sub, '<': operator.lt, '<=': operator.le,
    '>': operator.gt, '>=': operator.ge, '=': operator.eq, '<>': operator.ne,
}  # fmt: skip


class RapidMemory:
    """What a module's data hold while it runs.

    Parameters
    ----------
    module : Module
        Read and checked; its data are where the values begin.
    controller : Controller
        Asked where the axes are.

    Attributes
    ----------
    error : RapidError or None
        That is being handled: ``ERRNO``.
    line : int
        Of the statement that runs.
    """

    def __init__(self, module: Module, controller: Controller) -> None:
        self._controller = controller
        self._values = {name: datum.value for name, datum in module.data.items()}
        self.error: RapidError | None = None
        self.line = 0

    def set_number(self, name: str, value: float) -> None:
        """Set a variable to a number: a loop's."""
        self._values[name] = value

    def held(self, name: str) -> Literal:
        """Return what a datum holds."""
        return self._values[name]

    def set_held(self, name: str, value: Literal) -> None:
        """Set a datum from outside the program."""
        self._values[name] = value

    def value(self, value: Value) -> Literal:
        """Return what an expression says now.

        Raises
        ------
        RapidError
            An index is out of bounds.
        """
        if isinstance(value, Constant):
            return value.value
        if isinstance(value, Operation):
            return self._operation(value)
        if isinstance(value, Function):
            return self._function(value)
        if value.name == 'errno':
            return self.error.number if self.error is not None else 0.0
        if value.name in SPEED_NAMES and value.name not in self._values:
            return SPEED_NAMES[value.name]
        held = self._values[value.name]
        if value.index is not None:
            index = int(self.number(value.index))
            rows = held if isinstance(held, tuple) else ()
            if not 1 <= index <= len(rows):
                raise RapidError('ERR_OUTOFBND')
            held = rows[index - 1]
        for field in value.fields:
            held = rows_of(held)[_place(field)]
        return held

    def _operation(self, value: Operation) -> Literal:
        if value.sign == 'or':
            return bool(self.value(value.left) or self.value(value.right))
        if value.sign == 'and':
            return bool(self.value(value.left) and self.value(value.right))
        return OPERATORS[value.sign](self.number(value.left), self.number(value.right))

    def _function(self, value: Function) -> Literal:
        if value.name == 'abs':
            return abs(self.number(value.arguments[0]))
        angles = tuple(self._controller.axes.measured_deg.tolist())
        return (angles, self._controller.external)

    def number(self, value: Value) -> float:
        """Return what an expression says, which must be a number."""
        found = self.value(value)
        if not isinstance(found, float) or not math.isfinite(found):
            raise refuse('not a number', self.line, found)
        return found

    def option(self, call: Call, name: str, default: float) -> float:
        """Return the number of an optional argument."""
        value = call.options.get(name)
        return default if value is None else self.number(value)

    def assign(self, item: Assignment) -> None:
        """Take a value in hand."""
        value = self.value(item.value)
        if item.field:
            held = self._values[item.name]
            parts = list(rows_of(held))
            parts[_place(item.field)] = value
            value = tuple(parts)
        self._values[item.name] = value


def _place(field: str) -> int:
    """Return where a component stands in its record."""
    return next(names.index(field) for names in RECORDS if field in names)


def rapid_text(value: Literal) -> str:
    """Return a value as RAPID writes it."""
    if isinstance(value, tuple):
        return f'[{",".join(map(rapid_text, value))}]'
    if isinstance(value, str):
        doubled = value.replace('"', '""')
        return f'"{doubled}"'
    return f'{value:.9g}'.upper()


def rows_of(value: Literal) -> tuple[Literal, ...]:
    """Return the parts of a record or array."""
    if not isinstance(value, tuple):
        raise RapidError('ERR_ARGVALERR')
    return value


def numbers_of(value: Literal) -> tuple[float, ...]:
    """Return the numbers among the parts."""
    return tuple(item for item in rows_of(value) if isinstance(item, float))
