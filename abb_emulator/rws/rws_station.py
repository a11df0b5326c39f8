"""What Robot Web Services do with the emulated controller, whatever the version.

Paths are those of version 2.0, where every action is a path of its own; the paths of version 1.0
are translated to them first (:mod:`rws_dialect`).
"""

from collections import deque
from collections.abc import Callable, Mapping
import re
import threading

from abb_emulator.controller import Controller
from abb_emulator.rapid import CYCLES, ProgramTask
from abb_emulator.rws.rws_files import Files
from abb_emulator.rws.rws_refusal import (
    FORBIDDEN,
    HELD,
    NO_MASTERSHIP,
    NO_QUEUE,
    not_now,
    QUEUE_EXISTS,
    RwsRefusalError,
    SIGNAL,
    SYMBOL,
    unknown,
)
from abb_emulator.rws.rws_resources import Fields, Resource, Resources, Shown, TASK
from abb_emulator.rws.rws_sessions import Session, Sessions
from modal_core.errors import BridgeError

Form = Mapping[str, str]
Action = Callable[[Form], Shown | None]
PROGRAM_DOMAINS = {False: 'rapid', True: 'edit'}
"""Mastership that a change of programs needs, by version."""
DOMAINS = {False: ('cfg', 'motion', 'rapid'), True: ('edit', 'motion')}
START = '/rw/rapid/execution/start'
MOST_QUEUES, LONGEST_QUEUE, LONGEST_MESSAGE = 16, 64, 444
CHANGES = ('loadmod', 'unloadmod', 'resetpp', 'data', 'activate', 'deactivate')
"""Actions that need the mastership."""
_SYMBOL = re.compile(rf'/rw/rapid/symbol/RAPID/{TASK}/(?:\w+/)?(\w+)(?:/data)', re.ASCII)


class Station:
    """Controller, task and files, shown and operated.

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
        self._resources = Resources(controller, task)
        self.files = Files()
        self._queues: dict[str, deque[Fields]] = {}
        tasks = '/rw/rapid/tasks'
        self._actions: Mapping[str, Action] = {
            START: self._start,
            '/rw/rapid/execution/stop': self._stop,
            '/rw/rapid/execution/resetpp': self._reset,
            '/rw/rapid/execution/cycle': self._set_cycle,
            f'{tasks}/{TASK}/loadmod': self._load,
            f'{tasks}/{TASK}/unloadmod': self._unload,
            f'{tasks}/activate': lambda form: self._select(form.get('task', TASK), True),
            f'{tasks}/deactivate': lambda form: self._select(form.get('task', TASK), False),
            '/rw/panel/ctrl-state': self._set_motors,
            '/rw/panel/speedratio': self._set_speed_ratio,
            '/rw/rapid/symbols/search': self._search,
            '/rw/dipc/dipc-create': self._make_queue,
            '/users/rmmp': lambda _: None,
            '/users/rmmp/cancel': lambda _: None,
        }

    # -- what is shown -------------------------------------------------------------------------

    def shown(self, path: str, modern: bool) -> Shown:
        """Return what is shown at a path.

        Raises
        ------
        RwsRefusalError
            There is nothing.
        """
        if path.startswith('/rw/dipc/'):
            return self._received(path.rpartition('/')[2])
        with self._lock:
            symbol = _SYMBOL.fullmatch(path)
            found = self._symbol(symbol[1]) if symbol else self._resources.shown(path, modern)
        if found is None:
            raise unknown(path)
        return found

    def file(self, path: str) -> bytes | Shown:
        """Return a file, or what a volume holds.

        Raises
        ------
        RwsRefusalError
            There is no such file.
        """
        listed = self.files.listed(path)
        if listed is not None:
            return Shown(
                tuple(
                    Resource('fs-file', name, {'fs-size': str(len(file.data)),
                                               'fs-readonly': 'false'})
                    for name, file in listed.items()
                )
            )  # fmt: skip
        written = self._resources.texts.get(path.rpartition('/')[2])
        if path.startswith('$TEMP/') and written is not None:
            return written
        return self.files.read(path)

    # -- what is done --------------------------------------------------------------------------

    def act(
        self, path: str, form: Form, session: Session, sessions: Sessions, modern: bool
    ) -> Shown | None:
        """Do what a path asks for; return what there is to show of it.

        Raises
        ------
        RwsRefusalError
            Unknown, not possible now, or without the mastership it needs.
        """
        if path.startswith('/rw/mastership'):
            _master(path, session, sessions, DOMAINS[modern])
            return None
        if modern and path == START and PROGRAM_DOMAINS[modern] in session.domains:
            # So clients of real controllers report it.
            raise RwsRefusalError('Requested resource is held by someone else', FORBIDDEN, HELD)
        if path.rpartition('/')[2] in CHANGES:
            self._check_mastership(form, session, sessions, modern)
        with self._lock:
            action = self._actions.get(path) or self._named(path)
            try:
                return action(form)
            except RwsRefusalError:
                raise
            except BridgeError as error:
                raise RwsRefusalError(str(error)) from error

    def _named(self, path: str) -> Action:
        """Return an action on a symbol or a signal."""
        symbol = _SYMBOL.fullmatch(path)
        if symbol:
            return lambda form: self._set_symbol(symbol[1], form.get('value', ''))
        front, _, action = path.rpartition('/')
        if action == 'set-value' and front.startswith('/rw/iosystem/signals/'):
            return lambda form: self._set_signal(front.rpartition('/')[2], form)
        if action == 'dipc-send':
            return lambda form: self._send(front.rpartition('/')[2], form)
        if front in self._actions or self._resources.shown(front, True) is not None:
            raise RwsRefusalError('unknown action', found=action[:40])
        raise unknown(path)

    def _check_mastership(
        self, form: Form, session: Session, sessions: Sessions, modern: bool
    ) -> None:
        domain = PROGRAM_DOMAINS[modern]
        sessions.check(session, domain)
        # RobotWare 6 takes it on behalf of the client, RobotWare 7 when it is asked to.
        implicit = not modern or form.get('mastership') == 'implicit'
        if not implicit and domain not in session.domains:
            raise RwsRefusalError(
                'The user does not have required mastership', FORBIDDEN, NO_MASTERSHIP
            )

    # -- programs ------------------------------------------------------------------------------

    def _load(self, form: Form) -> Shown:
        path = form.get('modulepath', '')
        data = self.files.read(path)
        _require(not self._task.running, 'program is running')
        try:
            module = self._task.load(data.decode('utf-8'), beside=True)
        except UnicodeDecodeError as error:
            raise RwsRefusalError('not text', found=path[:80]) from error
        fields = {'name': module.name}
        return Shown((Resource('rap-task-module-li', module.name, {**fields}),))

    def _unload(self, form: Form) -> None:
        _require(not self._task.running, 'program is running')
        self._task.unload(form.get('module', ''))

    def _select(self, name: str, active: bool) -> None:
        if name != TASK:
            raise unknown(f'Task {name}')
        _require(not self._task.running, 'program is running')
        self._resources.active = active

    def _start(self, form: Form) -> None:
        cycle = _cycle_of(form)
        if cycle != 'asis':
            _require(not self._task.running, 'program is running')
        _require(self._controller.automatic, 'not in automatic mode')
        _require(self._resources.active, 'no task is selected')
        _require(self._task.module is not None, 'no module loaded')
        self._keep_cycle(cycle)
        _require(self._task.start(), 'motors off, already running, or PP lost')

    def _stop(self, _: Form) -> None:
        self._task.stop('RWS')

    def _reset(self, _: Form) -> None:
        _require(self._task.reset(), 'program is running')

    def _set_cycle(self, form: Form) -> None:
        cycle = _cycle_of(form)
        _require(not self._task.running, 'program is running')
        self._keep_cycle(cycle)

    def _keep_cycle(self, cycle: str) -> None:
        if cycle != 'asis':
            self._task.cycle = cycle

    def _search(self, form: Form) -> Shown:
        wanted = form.get('symtyp', 'any')
        return Shown(
            tuple(
                Resource(f'rap-symprop{kind}-li', name, {
                    'name': name, 'symburl': f'RAPID/{TASK}/{name}', 'symtyp': kind,
                    'dattyp': datum.kind,
                })
                for name, datum in self._task.data.items()
                for kind in (datum.storage[:3],)
                if wanted in ('any', kind)
            )
        )  # fmt: skip

    def _symbol(self, name: str) -> Shown:
        text = self._task.data_text(name)
        if text is None:
            raise unknown(name, SYMBOL)
        return Shown((Resource('rap-data', name, {'value': text}),))

    def _set_symbol(self, name: str, text: str) -> None:
        if self._task.data_text(name) is None:
            raise unknown(name, SYMBOL)
        self._task.set_data(name, text)

    # -- messages between processes ------------------------------------------------------------

    def _make_queue(self, form: Form) -> None:
        name = form.get('dipc-queue-name', '')
        if name in self._queues or len(self._queues) >= MOST_QUEUES or not name:
            raise RwsRefusalError('the queue exists, or there are too many', code=QUEUE_EXISTS)
        self._queues[name] = deque(maxlen=LONGEST_QUEUE)

    def _send(self, name: str, form: Form) -> None:
        if name not in self._queues:
            raise unknown(f'Queue {name}', NO_QUEUE)
        self._queues[name].append({key: value[:LONGEST_MESSAGE] for key, value in form.items()})

    def _received(self, name: str) -> Shown:
        if name not in self._queues:
            raise unknown(f'Queue {name}', NO_QUEUE)
        queue = self._queues[name]
        messages = tuple(Resource('dipc-read-li', name, fields) for fields in queue)
        queue.clear()
        return Shown(messages)

    # -- panel and signals ---------------------------------------------------------------------

    def _set_motors(self, form: Form) -> None:
        state = form.get('ctrl-state', '')
        if state == 'motoroff':
            self._controller.motors_off('RWS')
        elif state == 'motoron':
            _require(self._controller.automatic, 'not in automatic mode')
            _require(self._controller.switch_motors_on(), 'emergency stop')
        else:
            raise RwsRefusalError('unknown state', found=state[:40])

    def _set_speed_ratio(self, form: Form) -> None:
        percent = form.get('speed-ratio', '')
        ratio = int(percent) / 100.0 if percent.isdecimal() and len(percent) < 4 else 0.0
        if not self._controller.set_speed_ratio(ratio):
            raise RwsRefusalError('not 1 to 100', found=percent[:40])

    def _set_signal(self, name: str, form: Form) -> None:
        if name not in self._controller.signals:
            raise unknown(name, SIGNAL)
        value = form.get('lvalue', '')
        if value not in ('0', '1'):
            raise RwsRefusalError('not 0 or 1', code=SIGNAL, found=value[:40])
        self._controller.signals[name] = float(value)


def _master(path: str, session: Session, sessions: Sessions, domains: tuple[str, ...]) -> None:
    """Request or release the mastership of one domain, or of all."""
    parts = path.removeprefix('/rw/mastership').strip('/').split('/')
    wanted = parts[:1] if len(parts) > 1 else list(domains)
    if parts[-1] not in ('request', 'release') or not set(wanted) <= set(domains):
        raise unknown(path)
    for domain in wanted:
        if parts[-1] == 'request':
            sessions.check(session, domain)
    for domain in wanted:
        if parts[-1] == 'request':
            sessions.take(session, domain)
        else:
            sessions.check(session, domain)
            session.domains.discard(domain)


def _cycle_of(form: Form) -> str:
    cycle = form.get('cycle', 'asis')
    if cycle not in ('asis', *CYCLES):
        raise RwsRefusalError('unknown run mode', found=cycle[:40])
    return cycle


def _require(right: bool, otherwise: str) -> None:
    if not right:
        raise not_now(otherwise)
