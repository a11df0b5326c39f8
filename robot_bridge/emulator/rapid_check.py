"""Every name, type and option of a module is checked before anything moves."""

from collections.abc import Mapping

from robot_bridge.emulator.rapid_instructions import INSTRUCTIONS, SWITCH, WORDS
from robot_bridge.emulator.rapid_syntax import (
    Assignment,
    Call,
    Constant,
    Datum,
    JOINT_ROW,
    Loop,
    MIN_MAX,
    Module,
    NUM,
    Reference,
    SPEED,
    SPEED_FIELDS,
    SPEED_NAMES,
    Statement,
    STRING,
    TARGET,
    Value,
)
from robot_bridge.emulator.rapid_tokens import refuse

FIELDS: Mapping[tuple[str, str], str] = {
    (TARGET, 'robax'): JOINT_ROW,
    (TARGET, 'extax'): JOINT_ROW,
    **{(SPEED, name): NUM for name in SPEED_FIELDS},
}
LITERALS = {6: JOINT_ROW, 4: SPEED, 2: MIN_MAX}
ERROR_WORDS = ('retry', 'trynext', 'raise')


def check_module(module: Module) -> None:
    """Refuse what the emulator would not execute.

    Raises
    ------
    BridgeError
        With the line.
    """
    for procedure in module.procedures.values():
        _Checker(module, set(), False).statements(procedure.body)
        _Checker(module, set(), True).statements(procedure.handler)


class _Checker:
    """Checks statements with the loop variables they can see."""

    def __init__(self, module: Module, loops: set[str], handler: bool) -> None:
        self._data: Mapping[str, Datum] = module.data
        self._procedures = module.procedures
        self._loops, self._handler = loops, handler

    def statements(self, statements: tuple[Statement, ...]) -> None:
        """Check them in turn."""
        for statement in statements:
            if isinstance(statement, Loop):
                self._loop(statement)
            elif isinstance(statement, Assignment):
                self._assignment(statement)
            else:
                self._call(statement)

    def _loop(self, loop: Loop) -> None:
        for value in (loop.first, loop.last):
            self._expect(value, NUM, loop.line)
        if loop.variable in self._loops:
            raise refuse('loop variable in use', loop.line, loop.variable)
        self._loops.add(loop.variable)
        self.statements(loop.body)
        self._loops.discard(loop.variable)

    def _assignment(self, item: Assignment) -> None:
        datum = self._data.get(item.name)
        if datum is None or datum.rows:
            raise refuse('cannot be assigned to', item.line, item.name)
        if datum.constant:
            raise refuse('is a constant', item.line, item.name)
        kind: str | None = datum.kind
        if item.field:
            kind = FIELDS.get((datum.kind, item.field))
        if kind is None:
            raise refuse(f'{datum.kind} has no such field', item.line, item.field)
        self._expect(item.value, kind, item.line)

    def _call(self, call: Call) -> None:
        if call.name in self._procedures and not call.arguments and not call.options:
            raise refuse('procedure calls are not executed by the emulator', call.line, call.name)
        signature = INSTRUCTIONS.get(call.name)
        if signature is None:
            raise refuse('instruction not executed by the emulator', call.line, call.name)
        if call.name in ERROR_WORDS and not self._handler:
            raise refuse('only in an ERROR handler', call.line, call.name.upper())
        if len(call.arguments) != len(signature.arguments):
            raise refuse(
                f'{call.name}: number of arguments', call.line, len(call.arguments),
                len(signature.arguments),
            )  # fmt: skip
        for value, kind in zip(call.arguments, signature.arguments, strict=True):
            self._argument(value, kind, call.line)
        for name, option in call.options.items():
            wanted = signature.options.get(name)
            if wanted is None:
                raise refuse(f'{call.name}: option not executed', call.line, f'\\{name}')
            if (wanted == SWITCH) != (option is None):
                raise refuse(f'{call.name}: wrong use of option', call.line, f'\\{name}')
            if option is not None:
                self._expect(option, wanted, call.line)

    def _argument(self, value: Value, kind: str, line: int) -> None:
        if kind not in WORDS:
            self._expect(value, kind, line)
        elif not isinstance(value, Reference) or value.index or value.name not in WORDS[kind]:
            found = value.name if isinstance(value, Reference) else 'a value'
            raise refuse('not executed by the emulator', line, found, ' or '.join(WORDS[kind]))

    def _expect(self, value: Value, kind: str, line: int) -> None:
        found = self._kind(value, line)
        if found != kind:
            raise refuse('wrong type', line, found, kind)

    def _kind(self, value: Value, line: int) -> str:
        if isinstance(value, Constant):
            return _kind_of_literal(value, line)
        if value.name in self._loops or value.name == 'errno':
            return NUM
        if value.name in SPEED_NAMES and value.index is None:
            return SPEED
        datum = self._data.get(value.name)
        if datum is None:
            raise refuse('not declared', line, value.name)
        if bool(datum.rows) != (value.index is not None):
            raise refuse('array without index, or index without array', line, value.name)
        if value.index is not None:
            self._expect(value.index, NUM, line)
        return datum.kind


def _kind_of_literal(value: Constant, line: int) -> str:
    literal = value.value
    if isinstance(literal, float):
        return NUM
    if isinstance(literal, str):
        return STRING
    if all(isinstance(item, float) for item in literal) and len(literal) in LITERALS:
        return LITERALS[len(literal)]
    rows = [item for item in literal if isinstance(item, tuple) and len(item) == 6]
    if len(literal) == 2 and len(rows) == 2:
        flat = [number for row in rows for number in row]
        if all(isinstance(number, float) for number in flat):
            return TARGET
    raise refuse('not a value of any known type', line)
