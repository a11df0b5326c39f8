r"""Write a plan as a RAPID module that an operator can read and load by hand.

Two kinds of module.  A plan of random pulses becomes point-to-point moves with the numbers baked
in; a plan of band-limited noise becomes the set-up of an EGM session in which the bridge guides
the joints.  Angles are controller angles in degrees.  Nothing is drawn at run time.

The modules use this subset of RAPID and no more; one statement a line, ``!`` starts a comment::

    module      = "MODULE" name { data } proc "ENDMODULE"
    data        = "CONST num" name ":=" number ";"
                | "CONST num" name "{" rows "}" ":=" "[" number { "," number } "]" ";"
                | "CONST robjoint" name "{" rows "}" ":=" "[" row { "," row } "]" ";"
                | "CONST jointtarget" name ":=" "[" row "," row "]" ";"
                | "CONST egm_minmax" name ":=" "[" number "," number "]" ";"
                | "VAR jointtarget" name ":=" name ";"
                | "VAR speeddata" name ":=" "[" number x 4 "]" ";"
                | "VAR egmident" name ";"
    row         = "[" number x 6 "]"
    proc        = "PROC" name "()" { statement } "ERROR" { statement } "ENDPROC"
    statement   = "FOR" name "FROM" value "TO" value "DO" { statement } "ENDFOR"
                | name "." field ":=" value ";"        field: robax, v_tcp, v_ori
                | "MotionSup" "\On" ";"
                | "AccSet" value "," value ";"
                | "VelSet" value "," value ";"
                | "MoveAbsJ" name "\NoEOffs" "," name "," "fine" "," "tool0" ";"
                | "WaitTime" value ";"
                | "EGMReset" name ";"  | "EGMGetId" name ";"
                | "EGMSetupUC" "ROB_1" "," name "," string "," string { option } ";"
                | "EGMStreamStart" name { option } ";"  | "EGMStreamStop" name ";"
                | "EGMActJoint" name { option } ";"
                | "EGMRunJoint" name "," "EGM_STOP_HOLD" { option } ";"
                | "TPWrite" string { option } ";"  | "StopMove" ";"  | "EXIT" ";"
    option      = "\" name [ ":=" value ]
    value       = number | name | name "{" value "}" | "ERRNO"

Data may run over several lines; a statement ends at its semicolon.  Names of speeds (``v50``) are
the predefined ones.  A move's ``speeddata`` limits tool speed [mm/s] and turning [deg/s];
``AccSet`` scales acceleration (20..100 %) and its build-up (10..100 %); every move ends at a fine
point.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from excitation_planner.moves import Move, moves_of
from excitation_planner.plan import check_plan, ExcitationPlan, RANDOM_PULSES
from modal_core.atomic_file import write_text
from modal_core.errors import PlanError
from structural_model.flexible_joint_model import FlexibleJointModel

Array = NDArray[np.float64]
COMM_TIMEOUT_S = 0.1
# Least percentages AccSet accepts.
LEAST_ACCELERATION, LEAST_RAMP = 20.0, 10.0
SPEED_LIMIT_MM_S = 250.0
LONGEST_LINE = 100
SAFETY = (
    'This program moves the robot.  Read it, run it slowly first, keep everybody out of reach.',
    'A software stop is not a safety function (ISO 10218): guards and e-stop stay in charge.',
)


@dataclass(frozen=True, slots=True)
class RapidOptions:
    """How the module is written.

    Parameters
    ----------
    module_name : str
        Name of the module.
    stream : bool
        Random pulses only: also stream time-stamped joint positions by EGM.
    device : str
        Name of the UDP device in the controller's configuration.
    low_pass_hz : float [Hz]
        EGM guidance only: filter on the speed reference.
    """

    module_name: str = 'AmaExcitation'
    stream: bool = True
    device: str = 'UCdevice'
    low_pass_hz: float = 100.0


def rapid_module(
    plan: ExcitationPlan, model: FlexibleJointModel, options: RapidOptions | None = None
) -> str:
    """Return the RAPID module of a plan.

    Raises
    ------
    PlanError
        The plan contradicts itself, is for another robot, or the robot has not six axes.
    """
    check_plan(plan)
    chosen = options or RapidOptions()
    if len(plan.joint_names) != 6 or not chosen.module_name.isidentifier():
        raise PlanError(
            'RAPID needs six axes and a plain module name',
            where='rapid',
            found=f'{len(plan.joint_names)} axes, {chosen.module_name}',
        )
    body = _pulse_module if plan.signal == RANDOM_PULSES else _guidance_module
    lines = [f'MODULE {chosen.module_name}', *_header(plan), *body(plan, model, chosen)]
    return '\n'.join([*lines, 'ENDMODULE', ''])


def write_rapid(
    path: Path,
    plan: ExcitationPlan,
    model: FlexibleJointModel,
    options: RapidOptions | None = None,
) -> None:
    """Write the RAPID module of a plan to a file, whole or not at all."""
    write_text(path, rapid_module(plan, model, options))


def _header(plan: ExcitationPlan) -> list[str]:
    reach = ' '.join(f'{angle:.4f}' for angle in np.rad2deg(plan.position_range))
    facts = (
        f'Self-excitation of {plan.robot_name} for operational modal analysis, made by ama plan.',
        f'plan_hash {plan.plan_hash}',
        f'seed {plan.seed}, {plan.signal}, {plan.duration_s:.3f} s',
        f'excited band {plan.band_low_hz:.1f} to {plan.band_high_hz:.1f} Hz,'
        f' fastest point {1e3 * plan.peak_point_speed:.0f} mm/s',
        f'range of serial joints 1..6 [deg]: {reach}',
        *SAFETY,
    )
    return [f'  ! {fact}' for fact in facts]


def _pulse_module(
    plan: ExcitationPlan, model: FlexibleJointModel, options: RapidOptions
) -> list[str]:
    moves = moves_of(plan, model)
    data = [
        *_start_data(plan, model),
        f'  CONST num nMoves:={len(moves)};',
        '  ! One row a move: target [deg]; speed [mm/s], turning [deg/s]; AccSet [%]; pause [s].',
        *_rows('aTarget', (np.rad2deg(move.target) for move in moves)),
        *_column('aSpeed', [_tool_speed(move) for move in moves], 1),
        *_column('aTurn', [max(np.rad2deg(m.tool_turning_rad_s), 0.1) for m in moves], 2),
        *_column(
            'aAcc', [_percent(m.acceleration_fraction, LEAST_ACCELERATION) for m in moves], 1
        ),
        *_column('aRamp', [_percent(m.jerk_fraction, LEAST_RAMP) for m in moves], 1),
        *_column('aPause', [move.pause_s for move in moves], 3),
        '  VAR jointtarget jNext:=jStart;',
        '  VAR speeddata vMove:=[1,1,5000,1000];',
        *(['  VAR egmident egmStream;'] if options.stream else []),
    ]
    start = [
        '    EGMReset egmStream;',
        '    EGMGetId egmStream;',
        f'    EGMSetupUC ROB_1,egmStream,"default","{options.device}"\\Joint'
        f'\\CommTimeout:={COMM_TIMEOUT_S};',
        '    EGMStreamStart egmStream\\SampleRate:=4;',
    ]
    stop = ['    EGMStreamStop egmStream;', '    EGMReset egmStream;']
    loop = [
        '    WaitTime 1;',
        '    FOR i FROM 1 TO nMoves DO',
        '      AccSet aAcc{i},aRamp{i};',
        '      jNext.robax:=aTarget{i};',
        '      vMove.v_tcp:=aSpeed{i};',
        '      vMove.v_ori:=aTurn{i};',
        '      MoveAbsJ jNext\\NoEOffs,vMove,fine,tool0;',
        '      WaitTime aPause{i};',
        '    ENDFOR',
    ]
    ending = stop if options.stream else []
    steps = [*_to_start(), *(start if options.stream else []), *loop, *ending]
    return [*data, *_proc(steps, ending)]


def _guidance_module(
    plan: ExcitationPlan, model: FlexibleJointModel, options: RapidOptions
) -> list[str]:
    axis = np.rad2deg(model.to_controller(plan.position))
    speed = np.rad2deg(np.max(np.abs(model.to_controller(plan.velocity))))
    deviation = max(0.2, 1.5 * float(np.max(np.abs(axis - axis[0]))))
    axes = ''.join(f'\\J{number}:=converged' for number in range(1, 7))
    selected = ''.join(f'\\J{number}' for number in range(1, 7))
    data = [
        *_start_data(plan, model),
        '  ! The session ends by itself once all joints stay inside this for CondTime.',
        '  CONST egm_minmax converged:=[-0.001,0.001];',
        '  VAR egmident egmGuide;',
    ]
    steps = [
        *_to_start(),
        '    EGMReset egmGuide;',
        '    EGMGetId egmGuide;',
        f'    EGMSetupUC ROB_1,egmGuide,"default","{options.device}"\\Joint'
        f'\\CommTimeout:={COMM_TIMEOUT_S};',
        f'    EGMActJoint egmGuide{axes}\\LpFilter:={options.low_pass_hz:g}\\SampleRate:=4'
        f'\\MaxPosDeviation:={deviation:.3f}\\MaxSpeedDeviation:={max(1.0, 1.5 * speed):.2f};',
        f'    EGMRunJoint egmGuide,EGM_STOP_HOLD{selected}\\CondTime:={plan.duration_s + 30:.0f}'
        '\\RampInTime:=0.5\\RampOutTime:=0.5;',
        '    EGMReset egmGuide;',
    ]
    return [*data, *_proc(steps, ['    EGMReset egmGuide;'])]


def _start_data(plan: ExcitationPlan, model: FlexibleJointModel) -> list[str]:
    start = _row(np.rad2deg(model.to_controller(plan.start_position)))
    return [f'  CONST jointtarget jStart:=[{start},[9E9,9E9,9E9,9E9,9E9,9E9]];']


def _to_start() -> list[str]:
    return [
        '    MotionSup\\On;',
        f'    VelSet 100,{SPEED_LIMIT_MM_S:g};',
        '    AccSet 20,20;',
        '    MoveAbsJ jStart\\NoEOffs,v50,fine,tool0;',
    ]


def _proc(steps: list[str], ending: list[str]) -> list[str]:
    return [
        '  PROC main()',
        *steps,
        '    AccSet 100,100;',
        '  ERROR',
        '    StopMove;',
        '    TPWrite "Self-excitation stopped, error "\\Num:=ERRNO;',
        *ending,
        '    AccSet 100,100;',
        '    EXIT;',
        '  ENDPROC',
    ]


def _tool_speed(move: Move) -> float:
    return float(np.clip(1e3 * move.tool_speed_m_s, 0.1, SPEED_LIMIT_MM_S))


def _percent(fraction: float, least: float) -> float:
    return float(np.clip(100.0 * fraction, least, 100.0))


def _rows(name: str, rows: Iterable[Array]) -> list[str]:
    texts = [_row(row) for row in rows]
    first = f'  CONST robjoint {name}{{{len(texts)}}}:=['
    return [first, *(f'    {text},' for text in texts[:-1]), f'    {texts[-1]}];']


def _row(angles_deg: Array) -> str:
    return '[' + ','.join(f'{angle + 0.0:.5f}' for angle in np.round(angles_deg, 5)) + ']'


def _column(name: str, values: list[float], decimals: int) -> list[str]:
    lines, line = [], f'  CONST num {name}{{{len(values)}}}:=['
    for index, value in enumerate(values):
        text = f'{value:.{decimals}f}' + (',' if index < len(values) - 1 else '];')
        if len(line) + len(text) > LONGEST_LINE:
            lines.append(line)
            line = '    '
        line += text
    return [*lines, line]
