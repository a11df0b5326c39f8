"""What Robot Web Services show of the emulated controller.

Both versions show the same things; where a controller of RobotWare 7 spells one differently,
``modern`` says so.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
import time

import numpy as np
import pinocchio as pin

from abb_emulator.controller import Controller
from abb_emulator.controller_settings import NOT_CONNECTED
from abb_emulator.rapid import ProgramTask

MM = 1000.0
TASK = 'T_ROB1'
Fields = dict[str, 'str | list[dict[str, str]]']
# A longer module is not answered but written to a file (assumed).
INLINE_CHARACTERS = 20_000


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
    fields: Fields


@dataclass(frozen=True, slots=True)
class Shown:
    """What stands at one path.

    Parameters
    ----------
    resources : tuple of Resource
        In order.
    collection : bool
        Things with paths of their own: RWS 2.0 embeds them as resources.
    """

    resources: tuple[Resource, ...]
    collection: bool = False


class Resources:
    """Controller and task as resources.

    Parameters
    ----------
    controller : Controller
        Shown.
    task : ProgramTask
        ``T_ROB1``.

    Attributes
    ----------
    active : bool
        The task is selected in the task panel.
    texts : dict of str to bytes
        What long modules were written to.
    """

    def __init__(self, controller: Controller, task: ProgramTask) -> None:
        self._controller, self._task = controller, task
        self.active = True
        self.texts: dict[str, bytes] = {}
        self._unit = controller.settings.unit
        self._fixed: Mapping[str, Callable[[bool], Shown]] = {
            '/rw/system': self._system,
            '/rw/system/options': self._options,
            '/rw/rapid/execution': self._execution,
            '/rw/rapid/tasks': lambda modern: Shown((self._task_state(modern, '-li'),), True),
            f'/rw/rapid/tasks/{TASK}': lambda modern: Shown((self._task_state(modern, ''),)),
            f'/rw/rapid/tasks/{TASK}/pcp': self._pointers,
            f'/rw/rapid/tasks/{TASK}/modules': self._modules,
            '/rw/panel/ctrl-state': self._controller_state,
            '/rw/panel/opmode': self._operating_mode,
            '/rw/panel/speedratio': self._speed_ratio,
            '/rw/motionsystem/mechunits': self._units,
            f'/rw/motionsystem/mechunits/{self._unit}': self._one_unit,
            f'/rw/motionsystem/mechunits/{self._unit}/jointtarget': self._joint_target,
            f'/rw/motionsystem/mechunits/{self._unit}/robtarget': self._robot_target,
            '/rw/iosystem/signals': self._signals,
            '/rw/elog/0': self._events,
            '/ctrl': lambda _: Shown((self._identity('-li'),), True),
            '/ctrl/identity': lambda _: Shown((self._identity(''),)),
            '/ctrl/clock': lambda _: _one('ctrl-clock-info', 'clock', {'datetime': self._now()}),
            '/ctrl/$RAMDISK': lambda _: _one('ctrl-env', '$RAMDISK', {'_value': '$TEMP'}),
            '/ctrl/$HOME': lambda _: _one('ctrl-env', '$HOME', {'_value': '$HOME'}),
            '/ctrl/$TEMP': lambda _: _one('ctrl-env', '$TEMP', {'_value': '$TEMP'}),
            # Whoever is asked at the pendant says yes.
            '/users/rmmp': lambda _: _one('user-rmmp', 'rmmp', {'privilege': 'modify'}),
            '/users/rmmp/poll': lambda _: _one('user-rmmp-poll', 'rmmp', {'status': 'GRANTED'}),
        }

    def shown(self, path: str, modern: bool) -> Shown | None:
        """Return what is shown at a path; None when there is nothing."""
        maker = self._fixed.get(path)
        if maker is not None:
            return maker(modern)
        modules = f'/rw/rapid/tasks/{TASK}/modules/'
        if path.startswith(modules) and path.endswith('/text'):
            return self._module_text(path.removeprefix(modules).removesuffix('/text'))
        if path.startswith('/rw/iosystem/signals/'):
            return self._signal(path.rpartition('/')[2])
        return None

    # -- system and panel ----------------------------------------------------------------------

    def _system(self, modern: bool) -> Shown:
        version = ('7', '21', '7.21.0') if modern else ('6', '16', '6.16.00.00')
        fields: Fields = dict(zip(('major', 'minor', 'rwversion'), version, strict=True))
        return _one('sys-system', 'system', {'name': 'Emulator', **fields})

    def _identity(self, ending: str) -> Resource:
        fields: Fields = {'ctrl-name': 'Emulator', 'ctrl-id': 'Emulator',
                          'ctrl-type': 'Virtual Controller'}  # fmt: skip
        return Resource(f'ctrl-identity-info{ending}', 'identity', fields)

    def _now(self) -> str:
        return _stamp(self._controller.time_s)

    def _options(self, _: bool) -> Shown:
        return Shown(
            tuple(
                Resource('sys-option-li', str(number), {'option': name})
                for number, name in enumerate(self._controller.settings.options)
            )
        )

    def _controller_state(self, modern: bool) -> Shown:
        controller = self._controller
        state = 'motoron' if controller.motors_on else 'motoroff'
        state = 'emergencystop' if controller.e_stopped else state
        return _one('pnl-ctrlstate', _either(modern, 'ctrl-state', 'ctrlstate'),
                    {'ctrlstate': state})  # fmt: skip

    def _operating_mode(self, _: bool) -> Shown:
        return _one('pnl-opmode', 'opmode', {'opmode': self._controller.operating_mode})

    def _speed_ratio(self, _: bool) -> Shown:
        ratio = str(round(100.0 * self._controller.speed_ratio))
        return _one('pnl-speedratio', 'speedratio', {'speedratio': ratio})

    # -- programs ------------------------------------------------------------------------------

    def _execution(self, _: bool) -> Shown:
        state = 'running' if self._controller.running else 'stopped'
        fields: Fields = {'ctrlexecstate': state, 'cycle': self._task.cycle}
        return _one('rap-execution', 'execution', fields)

    def _task_state(self, modern: bool, ending: str) -> Resource:
        state = 'started' if self._controller.running else 'stopped'
        loaded = self._task.module is not None
        fields: Fields = {
            'name': TASK,
            'type': _either(modern, 'normal', 'norm'),
            'taskstate': _either(modern, 'linked' if loaded else 'empty', 'link'),
            'excstate': _either(modern, state, state[:4]),
            'active': 'On' if self.active else 'Off',
            'motiontask': 'TRUE',
        }
        return Resource(f'rap-task{ending}', TASK, fields)

    def _pointers(self, _: bool) -> Shown:
        # The resource itself spells it so.
        names = ('modulemame', 'routinename')
        pointer = self._task.pointer
        fields: Fields = dict(zip(names, pointer, strict=True)) if pointer is not None else {}
        return Shown(
            tuple(
                Resource('pcp-info', title, fields) for title in ('progpointer', 'motionpointer')
            )
        )

    def _modules(self, modern: bool) -> Shown:
        place = _either(modern, f'{TASK}/', '')
        return Shown(
            tuple(
                Resource('rap-module-info-li', f'{place}{name}', {'name': name, 'type': 'ProgMod'})
                for name in self._task.texts
            )
        )

    def _module_text(self, name: str) -> Shown | None:
        texts = {key.casefold(): text for key, text in self._task.texts.items()}
        text = texts.get(name.casefold())
        if text is None:
            return None
        fields: Fields = {'module-length': str(len(text)), 'change-count': '1'}
        if len(text) > INLINE_CHARACTERS:
            self.texts = {f'{name}.modx': text.encode()}
            return _one('rap-module-text', name, {**fields, 'file-path': f'$TEMP/{name}.modx'})
        return _one('rap-module-text', name, {**fields, 'module-text': text})

    # -- motion --------------------------------------------------------------------------------

    def _units(self, _: bool) -> Shown:
        fields: Fields = {'mode': 'Activated', 'activation-allowed': 'false',
                          'drive-module': '1'}  # fmt: skip
        return Shown((Resource('ms-mechunit-li', self._unit, fields),), True)

    def _one_unit(self, _: bool) -> Shown:
        fields: Fields = {
            'mode': 'Activated', 'activation-allowed': 'false', 'drive-module': '1',
            'type': 'TCPRobot', 'task-name': TASK, 'axes': '6', 'axes-total': '6',
            'is-integrated-unit': 'NoIntegratedUnit', 'has-integrated-unit': 'NoIntegratedUnit',
            'tool-name': 'tool0', 'wobj-name': 'wobj0', 'payload-name': 'load0',
            'total-payload-name': '', 'status': 'Synchronized', 'jog-mode': 'AxisGroup1',
            'coord-system': 'Base',
        }  # fmt: skip
        return _one('ms-mechunit', self._unit, fields)

    def _joint_target(self, modern: bool) -> Shown:
        angles = self._controller.axes.measured_deg.tolist()
        fields: Fields = {f'rax_{axis}': f'{angle:.6g}' for axis, angle in enumerate(angles, 1)}
        for letter, place in zip('abcdef', self._controller.external, strict=True):
            # A virtual controller of RobotWare 7 shows 0 for axes that are not there.
            absent = place == NOT_CONNECTED
            fields[f'eax_{letter}'] = _either(modern, '0', '9E+09') if absent else f'{place:g}'
        return _one('ms-jointtarget', self._unit, fields)

    def _robot_target(self, _: bool) -> Shown:
        model = self._controller.model
        robot = model.robot.model
        serial = model.axes.to_serial(np.radians(self._controller.axes.measured_deg))
        data = robot.createData()
        pin.forwardKinematics(robot, data, serial)
        place = pin.updateFramePlacement(robot, data, model.robot.tip_frame)
        turn = pin.Quaternion(place.rotation)
        fields: Fields = dict(zip('xyz', map(_number, MM * place.translation), strict=True))
        turned = (turn.w, turn.x, turn.y, turn.z)
        fields |= {f'q{n}': _number(value) for n, value in enumerate(turned, 1)}
        # How an arm reaches a point is not told apart here.
        fields |= dict.fromkeys(('cf1', 'cf4', 'cf6', 'cfx'), '0')
        fields |= {f'eax{letter}': '9E+09' for letter in 'abcdef'}
        return _one('ms-robtargets', self._unit, fields)

    # -- signals and events --------------------------------------------------------------------

    def _signals(self, _: bool) -> Shown:
        return Shown(tuple(map(self._signal_state, self._controller.signals)), True)

    def _signal(self, name: str) -> Shown | None:
        if name not in self._controller.signals:
            return None
        return Shown((self._signal_state(name),))

    def _signal_state(self, name: str) -> Resource:
        value = f'{self._controller.signals[name]:g}'
        fields: Fields = {'name': name, 'type': 'DO', 'category': '', 'lvalue': value,
                          'lstate': 'not simulated'}  # fmt: skip
        return Resource('ios-signal-li', f'Local/DRV_1/{name}', fields)

    def _events(self, _: bool) -> Shown:
        return Shown(
            tuple(
                Resource(
                    'elog-message-li', f'/rw/elog/0/{event.number}',
                    {
                        'msgtype': str(event.kind), 'code': str(event.code), 'src-name': 'MC0',
                        'tstamp': _stamp(event.time_s),
                        'title': event.title, 'desc': event.title, 'conseqs': '', 'causes': '',
                        'actions': '', 'argc': '0', 'argv': [],
                    },
                )
                for event in reversed(self._controller.log.events)
            ),
            True,
        )  # fmt: skip


def _one(kind: str, title: str, fields: Fields) -> Shown:
    return Shown((Resource(kind, title, fields),))


def _either(modern: bool, new: str, old: str) -> str:
    return new if modern else old


def _stamp(time_s: float) -> str:
    """Return a time as the controller writes it."""
    return time.strftime('%Y-%m-%d T %H:%M:%S', time.localtime(time_s))


def _number(value: float) -> str:
    return f'{value:.6g}'
