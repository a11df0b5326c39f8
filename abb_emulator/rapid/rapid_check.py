"""Every name, type and option of a module is checked before anything moves."""

from collections.abc import Iterator, Mapping

from abb_emulator.controller_settings import (
    COLLISION_OPTION,
    ControllerSettings,
    EGM_OPTION,
    names_in,
)
from abb_emulator.rapid.rapid_instructions import (
    CONFIGURED,
    FUNCTIONS,
    INSTRUCTIONS,
    SIGNAL,
    Signature,
    SWITCH,
    SYSTEM_DATA,
    UNIT,
    WORDS,
)
from abb_emulator.rapid.rapid_syntax import (
    Assignment,
    BOOL,
    Branch,
    Call,
    Constant,
    Datum,
    Function,
    IDENT,
    JOINT_ROW,
    Loop,
    MIN_MAX,
    Module,
    NUM,
    Operation,
    Reference,
    SPEED,
    SPEED_FIELDS,
    SPEED_NAMES,
    Statement,
    STRING,
    TARGET,
    Value,
)
from abb_emulator.rapid.rapid_tokens import refuse

FIELDS: Mapping[tuple[str, str], str] = {
    (TARGET, 'robax'): JOINT_ROW,
    (TARGET, 'extax'): JOINT_ROW,
    **{(JOINT_ROW, f'rax_{axis}'): NUM for axis in range(1, 7)},
    **{(JOINT_ROW, f'eax_{letter}'): NUM for letter in 'abcdef'},
    **{(SPEED, name): NUM for name in SPEED_FIELDS},
}
LITERALS = {6: JOINT_ROW, 4: SPEED, 2: MIN_MAX}
EGM_KINDS = (IDENT, MIN_MAX)
ERROR_WORDS = ('retry', 'trynext', 'raise')


def check_module(module: Module) -> None:
    """Refuse what the emulator would not execute.

    Raises
    ------
    BridgeError
        With the line.
    """
    _check_calls(module, 'main', ())
    for procedure in module.procedures.values():
        _Checker(module, set(), False).statements(procedure.body)
        _Checker(module, set(), True).statements(procedure.handler)


def check_configuration(module: Module, settings: ControllerSettings) -> None:
    """Refuse what this controller does not have: options, signals, data of other modules.

    A real one finds it when the module is loaded, too: names it does not know are errors of
    reference, and no task with one starts.

    Raises
    ------
    BridgeError
        With the line, and what is missing.
    """
    for datum in module.data.values():
        if datum.kind in EGM_KINDS:
            _require_option('type', datum.kind, datum.line, EGM_OPTION, settings)
    for procedure in module.procedures.values():
        for call in _calls((*procedure.body, *procedure.handler)):
            if call.name.startswith('egm'):
                _require_option('instruction', call.name, call.line, EGM_OPTION, settings)
            if call.name == 'motionsup':
                _require_option('instruction', call.name, call.line, COLLISION_OPTION, settings)
            _check_names(call, settings)


def _require_option(
    what: str, name: str, line: int, option: str, settings: ControllerSettings
) -> None:
    if option not in settings.options:
        raise refuse(f'unknown {what}', line, name, f'option {option}')


def _check_names(call: Call, settings: ControllerSettings) -> None:
    """Refuse names that neither the configuration nor another module knows."""
    signature = INSTRUCTIONS.get(call.name, Signature())
    known = {
        SIGNAL: names_in(settings.signals),
        UNIT: (settings.unit,),
        **dict.fromkeys(SYSTEM_DATA, names_in(settings.system_data)),
    }
    pairs = [
        *zip(call.arguments, signature.arguments, strict=False),
        *((value, signature.options.get(name, '')) for name, value in call.options.items()),
    ]
    for value, kind in pairs:
        if kind not in known or not isinstance(value, Reference):
            continue
        names = [name.lower() for name in known[kind]]
        if value.name not in names:
            raise refuse(f'unknown {kind}', call.line, value.name, ', '.join(known[kind]))


def _check_calls(module: Module, name: str, callers: tuple[str, ...]) -> None:
    """Refuse procedures that call themselves."""
    procedure = module.procedures[name]
    if name in callers:
        raise refuse('calls itself', procedure.line, name)
    for call in _calls((*procedure.body, *procedure.handler)):
        if call.name in module.procedures:
            _check_calls(module, call.name, (*callers, name))


def _calls(statements: tuple[Statement, ...]) -> Iterator[Call]:
    for statement in statements:
        if isinstance(statement, Call):
            yield statement
        elif isinstance(statement, Branch | Loop):
            yield from _calls(statement.body)


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
            elif isinstance(statement, Branch):
                self._expect(statement.condition, BOOL, statement.line)
                self.statements(statement.body)
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
            return
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
                self._argument(option, wanted, call.line)

    def _argument(self, value: Value, kind: str, line: int) -> None:
        if kind in CONFIGURED:
            # Whether it is known there is asked when the module is loaded into a controller.
            if not (isinstance(value, Reference) and value == Reference(value.name)):
                raise refuse('not a name', line, expected=kind)
        elif kind not in WORDS:
            self._expect(value, kind, line)
        elif value not in [Reference(word) for word in WORDS[kind]]:
            found = value.name if isinstance(value, Reference) else 'a value'
            raise refuse('not executed by the emulator', line, found, ' or '.join(WORDS[kind]))

    def _expect(self, value: Value, kind: str, line: int) -> None:
        found = self._kind(value, line)
        if found != kind:
            raise refuse('wrong type', line, found, kind)

    def _kind(self, value: Value, line: int) -> str:
        if isinstance(value, Constant):
            return _kind_of_literal(value, line)
        if isinstance(value, Function):
            return self._kind_of_function(value)
        if isinstance(value, Operation):
            return self._kind_of_operation(value)
        if value == Reference(value.name) and value.name in (*self._loops, 'errno'):
            return NUM
        if value == Reference(value.name) and value.name in SPEED_NAMES:
            return SPEED
        datum = self._data.get(value.name)
        if datum is None:
            raise refuse('not declared', line, value.name)
        if bool(datum.rows) != (value.index is not None):
            raise refuse('array without index, or index without array', line, value.name)
        if value.index is not None:
            self._expect(value.index, NUM, line)
        kind = datum.kind
        for name in value.fields:
            if (kind, name) not in FIELDS:
                raise refuse(f'{kind} has no such field', line, name)
            kind = FIELDS[kind, name]
        return kind

    def _kind_of_function(self, value: Function) -> str:
        if value.name not in FUNCTIONS:
            raise refuse('function not executed by the emulator', value.line, value.name)
        takes, gives = FUNCTIONS[value.name]
        if len(value.arguments) != len(takes):
            raise refuse(
                f'{value.name}: number of arguments', value.line, len(value.arguments), len(takes)
            )
        for argument, kind in zip(value.arguments, takes, strict=True):
            self._expect(argument, kind, value.line)
        return gives

    def _kind_of_operation(self, value: Operation) -> str:
        takes = BOOL if value.sign in ('or', 'and') else NUM
        for operand in (value.left, value.right):
            self._expect(operand, takes, value.line)
        return NUM if value.sign in ('+', '-') else BOOL


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
