"""What Robot Web Services read and change of the emulated controller."""

from collections.abc import Callable
from dataclasses import dataclass
import re
import threading

from abb_emulator.controller import Controller
from abb_emulator.rapid import CYCLES, LARGEST_BYTES, ProgramTask
from modal_core.errors import BridgeError

MOST_FILES = 32
_NAME = re.compile(r'[A-Za-z0-9_][A-Za-z0-9_.-]{0,63}')
_HOME = re.compile(r'/?(?:\$HOME|HOME:)/', re.IGNORECASE)
# A longer module is not answered but written to a file (assumed).
INLINE_CHARACTERS = 20_000
MODULES = '/rw/rapid/modules'


@dataclass(frozen=True, slots=True)
class Resource:
    """One resource: its RWS class, title and fields.

    Parameters
    ----------
    kind, title : str
        For example ``rap-execution`` and ``execution``.
    fields : dict of str to str
        RWS gives every value as text.
    """

    kind: str
    title: str
    fields: dict[str, str]


class Station:
    """Controller, task and the files of $HOME, which are held in memory and nowhere else.

    Parameters
    ----------
    controller : Controller
        Shown and operated.
    task : ProgramTask
        T_ROB1.
    lock : threading.Lock
        Held while either is touched.
    """

    def __init__(self, controller: Controller, task: ProgramTask, lock: threading.Lock) -> None:
        self._controller, self._task, self._lock = controller, task, lock
        self._files: dict[str, bytes] = {}
        self._texts: dict[str, bytes] = {}

    def resource(self, path: str) -> tuple[Resource, ...] | None:
        """Return what is shown at a path; None when there is nothing."""
        if path.startswith(f'{MODULES}/'):
            return self._module_text(path.removeprefix(f'{MODULES}/'))
        makers: dict[str, Callable[[], Resource | tuple[Resource, ...]]] = {
            '/rw/rapid/execution': self._execution,
            '/rw/rapid/tasks': self._tasks,
            '/rw/rapid/tasks/T_ROB1/pcp': self._pointers,
            MODULES: self._modules,
            '/rw/panel/ctrlstate': self._controller_state,
            '/rw/panel/opmode': self._operating_mode,
            '/rw/panel/speedratio': self._speed_ratio,
            '/rw/motionsystem/mechunits/ROB_1/jointtarget': self._joint_target,
        }
        maker = makers.get(path)
        if maker is None:
            return None
        with self._lock:
            found = maker()
        return found if isinstance(found, tuple) else (found,)

    def _tasks(self) -> Resource:
        state = 'started' if self._controller.running else 'stopped'
        fields = {
            'name': 'T_ROB1', 'type': 'norm', 'taskstate': 'load', 'excstate': state,
            'active': 'On', 'motiontask': 'TRUE',
        }  # fmt: skip
        return Resource('rap-task-li', 'T_ROB1', fields)

    def _pointers(self) -> tuple[Resource, ...]:
        pointer = self._task.pointer
        # The resource itself spells it so.
        names = ('modulemame', 'routinename')
        fields = dict(zip(names, pointer, strict=True)) if pointer is not None else {}
        return tuple(
            Resource('pcp-info', title, fields) for title in ('progpointer', 'motionpointer')
        )

    def _modules(self) -> tuple[Resource, ...]:
        return tuple(
            Resource('rap-module-info-li', name, {'name': name, 'type': 'ProgMod'})
            for name in self._task.texts
        )

    def _module_text(self, name: str) -> tuple[Resource, ...] | None:
        with self._lock:
            texts = {key.casefold(): text for key, text in self._task.texts.items()}
            text = texts.get(name.casefold())
            if text is None:
                return None
            fields = {'module-length': str(len(text)), 'module-text': text}
            if len(text) > INLINE_CHARACTERS:
                self._texts = {f'{name}.modx': text.encode()}
                fields = {'module-length': str(len(text)), 'file-path': f'$TEMP/{name}.modx'}
        return (Resource('rap-module-text', name, fields),)

    def _execution(self) -> Resource:
        state = 'running' if self._controller.running else 'stopped'
        fields = {'ctrlexecstate': state, 'cycle': self._task.cycle}
        return Resource('rap-execution', 'execution', fields)

    def _controller_state(self) -> Resource:
        controller = self._controller
        state = 'motoron' if controller.motors_on else 'motoroff'
        state = 'emergencystop' if controller.e_stopped else state
        return Resource('pnl-ctrlstate', 'ctrlstate', {'ctrlstate': state})

    def _operating_mode(self) -> Resource:
        return Resource('pnl-opmode', 'opmode', {'opmode': self._controller.operating_mode})

    def _speed_ratio(self) -> Resource:
        ratio = str(round(100.0 * self._controller.speed_ratio))
        return Resource('pnl-speedratio', 'speedratio', {'speedratio': ratio})

    def _joint_target(self) -> Resource:
        angles = self._controller.measured_deg.tolist()
        fields = {f'rax_{axis}': f'{angle:.6g}' for axis, angle in enumerate(angles, 1)}
        fields |= {f'eax_{letter}': '9E9' for letter in 'abcdef'}
        return Resource('ms-jointtarget', 'ROB_1', fields)

    # -- files ---------------------------------------------------------------------------------

    def store(self, path: str, data: bytes) -> bool:
        """Keep a file; True when it is new.

        Raises
        ------
        BridgeError
            Not a plain name in $HOME, too large, or too many of them.
        """
        name = self._name(path)
        new = name not in self._files
        if len(data) > LARGEST_BYTES or (new and len(self._files) >= MOST_FILES):
            raise BridgeError('no room', where=name)
        self._files[name] = data
        return new

    def read(self, path: str) -> bytes | None:
        """Return a file, or what a long module was written to; None when there is none."""
        if path.startswith('$TEMP/'):
            return self._texts.get(path.removeprefix('$TEMP/'))
        return self._files.get(self._name(path))

    def _name(self, path: str) -> str:
        found = _HOME.match(path)
        name = path[found.end() :] if found else ''
        if not _NAME.fullmatch(name):
            raise BridgeError('not a file of $HOME', found=path[:80])
        return name

    def load(self, path: str) -> None:
        """Load a stored module beside the others (loadmod).

        Raises
        ------
        BridgeError
            No such file, a program running, or a module that is not executed, by line.
        """
        name = self._name(path)
        if name not in self._files:
            raise BridgeError('no such file', where='$HOME', found=name)
        try:
            text = self._files[name].decode('utf-8')
        except UnicodeDecodeError as error:
            raise BridgeError('not text', where=name) from error
        with self._lock:
            self._task.load(text, beside=True)

    def unload(self, module: str) -> None:
        """Unload a module (unloadmod).

        Raises
        ------
        BridgeError
            No such module, or a program running.
        """
        with self._lock:
            self._task.unload(module)

    # -- execution -----------------------------------------------------------------------------

    def execute(self, action: str, cycle: str = 'asis') -> None:
        """Do ``resetpp``, ``start``, ``stop`` or ``setcycle``; ``asis`` keeps the run mode.

        Raises
        ------
        BridgeError
            Not now.
        """
        if cycle not in ('asis', *CYCLES):
            raise BridgeError('unknown run mode', found=cycle[:40], expected=CYCLES)
        with self._lock:
            if action in ('start', 'setcycle') and cycle != 'asis':
                self._require(not self._task.running, 'program is running')
            if action == 'stop':
                self._task.stop('RWS')
            elif action == 'resetpp':
                self._require(self._task.reset(), 'program is running')
            elif action == 'start':
                self._require(self._controller.automatic, 'not in automatic mode')
                self._require(self._task.module is not None, 'no module loaded')
                self._set_cycle(cycle)
                self._require(self._task.start(), 'motors off, already running, or PP lost')
            elif action == 'setcycle':
                self._set_cycle(cycle)
            else:
                raise BridgeError('unknown action', found=action[:40])

    def _set_cycle(self, cycle: str) -> None:
        if cycle != 'asis':
            self._task.cycle = cycle

    def set_motors(self, state: str) -> None:
        """Switch motors on or off (setctrlstate).

        Raises
        ------
        BridgeError
            Not now, or unknown.
        """
        with self._lock:
            if state == 'motoroff':
                self._controller.motors_off('RWS')
            elif state == 'motoron':
                self._require(self._controller.automatic, 'not in automatic mode')
                self._require(self._controller.switch_motors_on(), 'emergency stop')
            else:
                raise BridgeError('unknown state', found=state[:40])

    def set_speed_ratio(self, percent: str) -> None:
        """Set the speed ratio in percent.

        Raises
        ------
        BridgeError
            Not 1 to 100.
        """
        ratio = int(percent) / 100.0 if percent.isdecimal() and len(percent) < 4 else 0.0
        with self._lock:
            self._require(self._controller.set_speed_ratio(ratio), 'not 1 to 100')

    @staticmethod
    def _require(right: bool, otherwise: str) -> None:
        if not right:
            raise BridgeError(otherwise)
