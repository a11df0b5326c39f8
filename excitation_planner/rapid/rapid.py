r"""Write a plan as a RAPID module that an operator can read and load by hand.

Two kinds of module.  A plan of moves (random pulses, or an approach) becomes point-to-point moves
with the numbers baked in; a plan of band-limited noise becomes the set-up of an EGM session in
which the bridge guides the joints.  Angles are controller angles in degrees.  Nothing is drawn at
run time.

No module goes to its own start.  Before every move the module compares where the arm stands with
where that move begins, and ends without moving when they differ: it may have been started by
hand, from anywhere, at any line.  It ends by ``EXIT``, so that run mode continuous does not begin
it anew.

External axes keep the places they have when it begins, and it ends likewise when one has left its
place since.  A module needs no more options than it has instructions of: without the stream none
of EGM, without motion supervision none of Collision Detection.

The modules use this subset of RAPID and no more; one statement a line, ``!`` starts a comment::

    module      = "MODULE" name { data } proc { proc } "ENDMODULE"
    data        = "LOCAL" ( "CONST num" name ":=" number ";"
                | "CONST num" name "{" rows "}" ":=" "[" number { "," number } "]" ";"
                | "CONST robjoint" name "{" rows "}" ":=" "[" row { "," row } "]" ";"
                | "CONST jointtarget" name ":=" "[" row "," row "]" ";"
                | "CONST speeddata" name ":=" "[" number x 4 "]" ";"
                | "CONST egm_minmax" name ":=" "[" number "," number "]" ";"
                | "VAR robjoint" name ":=" row ";"
                | "VAR jointtarget" name ":=" name ";"
                | "VAR egmident" name ";" )
    row         = "[" number x 6 "]"
    proc        = [ "LOCAL" ] "PROC" name "()" { statement } [ "ERROR" { statement } ] "ENDPROC"
    statement   = "FOR" name "FROM" value "TO" value "DO" { statement } "ENDFOR"
                | "IF" away { "OR" away } "THEN" { statement } "ENDIF"
                | name [ "." field ] ":=" value ";"                   field: robax, extax
                | name ";"                                            a procedure of the module
                | "MotionSup" "\On" ";"
                | "AccSet" value "," value ";"
                | "MoveAbsJ" name "\NoEOffs" "," name "\T" ":=" value "," "fine" ","
                  name { option } ";"
                | "SetDO" name "," value ";"
                | "WaitTime" value ";"
                | "EGMReset" name ";"  | "EGMGetId" name ";"
                | "EGMSetupUC" name "," name "," string "," string { option } ";"
                | "EGMStreamStart" name { option } ";"  | "EGMStreamStop" name ";"
                | "EGMActJoint" name { option } ";"
                | "EGMRunJoint" name "," "EGM_STOP_HOLD" { option } ";"
                | "TPWrite" string { option } ";"  | "StopMove" ";"  | "EXIT" ";"
    away        = "Abs(" name "." field "." field "-" name "." field [ "." field ] ")>" name
    option      = "\" name [ ":=" value ]
    value       = number | name | name "{" value "}" | name "." field | "CJointT()" | "ERRNO"

Data may run over several lines; a statement ends at its semicolon.  ``\T`` is the time the way
takes at full speed: it bounds the speed of every axis, and so of every point of the arm, where a
tool speed says nothing of an arm that turns about its tool.  ``AccSet`` scales acceleration
(20..100 %) and its build-up (10..100 %); every move ends at a fine point.
"""

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from excitation_planner.plan import check_plan, ExcitationPlan
from excitation_planner.rapid.programmed_move import programmed_moves
from excitation_planner.rapid_options import is_name, LONGEST_NAME, RapidOptions
from excitation_planner.signals import APPROACH, NOISES
from modal_core.errors import PlanError
from modal_core.words.printable import printable
from structural_model.flexible_joint_model import FlexibleJointModel

Array = NDArray[np.float64]
COMM_TIMEOUT_S = 0.1
SESSION_SPARE_S = 30.0
# How near to the beginning of a move an axis must stand [deg]: at most this, and a twentieth of
# the plan's own range, but not less than what encoders and a hand at the pendant can tell apart.
NEAR_DEG, NEAREST_DEG, PART_OF_RANGE = 0.05, 0.02, 0.05
# A place of an external axis [mm or deg]: what a hand on a pendant moves is more.
NEAR_EXTERNAL = 0.5
LONGEST_LINE = 100
HASH_DIGITS = 8
SAFETY = (
    'This program moves the robot.  Read it, run it slowly first, keep everybody out of reach.',
    'A software stop is not a safety function (ISO 10218): guards and e-stop stay in charge.',
)


def rapid_module(
    plan: ExcitationPlan, model: FlexibleJointModel, options: RapidOptions | None = None
) -> str:
    """Return the RAPID module of a plan.

    Raises
    ------
    PlanError
        The plan contradicts itself, is for another robot, the robot has not six axes, or a name
        is none of RAPID.
    """
    check_plan(plan)
    chosen = options or RapidOptions()
    chosen.check()
    name = module_name(plan, chosen)
    if len(plan.joint_names) != 6 or not is_name(name):
        raise PlanError(
            'RAPID needs six axes and a plain, short module name',
            where='rapid',
            found=f'{len(plan.joint_names)} axes, {name[:80]}',
        )
    body = _guidance_module if plan.signal in NOISES else _pulse_module
    lines = [f'MODULE {name}', *_header(plan), *body(plan, model, chosen)]
    return '\n'.join([*lines, 'ENDMODULE', ''])


def module_name(plan: ExcitationPlan, options: RapidOptions | None = None) -> str:
    """Return the name of a plan's module: no two plans share one."""
    return f'{(options or RapidOptions()).module_name}_{plan.plan_hash[:HASH_DIGITS]}'


def start_tolerance_deg(plan: ExcitationPlan) -> float:
    """Return how far any axis may stand from the beginning of a move of the plan [deg]."""
    part = PART_OF_RANGE * float(np.rad2deg(np.max(plan.position_range)))
    return min(max(part, NEAREST_DEG), NEAR_DEG)


def session_s(duration_s: float) -> float:
    """Return how long an exported guidance session waits for its motion [s]: its CondTime."""
    return float(round(duration_s + SESSION_SPARE_S))


def _header(plan: ExcitationPlan) -> list[str]:
    reach = ' '.join(f'{angle:.4f}' for angle in np.rad2deg(plan.position_range))
    speed = ' '.join(f'{value:.2f}' for value in np.rad2deg(plan.peak_velocity))
    acceleration = ' '.join(f'{value:.0f}' for value in np.rad2deg(plan.peak_acceleration))
    what = 'Slow approach to a pose' if plan.signal == APPROACH else 'Self-excitation'
    facts = (
        f'{what} of {_told(plan.robot_name)} for operational modal analysis, made by ama plan.',
        f'plan_hash {plan.plan_hash}',
        f'seed {plan.seed}, {plan.signal}, {plan.duration_s:.3f} s',
        f'excited band {plan.band_low_hz:.1f} to {plan.band_high_hz:.1f} Hz,'
        f' fastest point {1e3 * plan.peak_point_speed:.0f} mm/s',
        f'range of serial joints 1..6 [deg]: {reach}',
        f'peak speed of them [deg/s]: {speed}; peak acceleration [deg/s2]: {acceleration}',
        'It starts at jStart and nowhere else: jog there, or release and run an approach plan.',
        *SAFETY,
    )
    return [f'  ! {fact}' for fact in facts]


def _told(name: str) -> str:
    """Return a name as a comment may hold it: one line of ASCII, whatever the name has.

    What follows the end of a comment's line is played; letters beyond ASCII come back from a
    controller as others, and a module that is not the released one is not started.
    """
    return printable(name, LONGEST_NAME).encode('ascii', 'backslashreplace').decode()


def _pulse_module(
    plan: ExcitationPlan, model: FlexibleJointModel, options: RapidOptions
) -> list[str]:
    moves = programmed_moves(plan, model)
    data = [
        *_start_data(plan, model),
        f'  LOCAL CONST num nMoves:={len(moves)};',
        '  ! One row a move: target [deg]; way at full speed [s]; AccSet [%]; pause [s].',
        *_rows('aTarget', (np.rad2deg(move.target) for move in moves)),
        *_column('aTime', [move.full_speed_s for move in moves], 4),
        *_column('aAcc', [move.acceleration_percent for move in moves], 2),
        *_column('aRamp', [move.ramp_percent for move in moves], 2),
        *_column('aPause', [move.pause_s for move in moves], 3),
        '  ! Holds where \\T should not: slow in turning too.',
        '  LOCAL CONST speeddata vSlow:=[5,1,5,1];',
        *(['  LOCAL VAR egmident egmStream;'] if options.stream else []),
    ]
    start = [
        *_session('egmStream', options),
        '    EGMStreamStart egmStream\\SampleRate:=4;',
    ]
    loop = [
        '    WaitTime 1;',
        *options.mark(1),
        '    FOR i FROM 1 TO nMoves DO',
        '      CheckPlace;',
        '      AccSet aAcc{i},aRamp{i};',
        '      jNext.robax:=aTarget{i};',
        f'      MoveAbsJ jNext\\NoEOffs,vSlow\\T:=aTime{{i}},fine,{options.moving};',
        '      rHere:=aTarget{i};',
        '      WaitTime aPause{i};',
        '    ENDFOR',
        *options.mark(0),
    ]
    reset = ['    EGMReset egmStream;'] if options.stream else []
    stop = ['    EGMStreamStop egmStream;', *reset] if options.stream else []
    steps = [*(start if options.stream else []), *loop, *stop]
    return [*data, *_procedures(options, steps, reset)]


def _guidance_module(
    plan: ExcitationPlan, model: FlexibleJointModel, options: RapidOptions
) -> list[str]:
    axis = np.rad2deg(model.to_controller(plan.position))
    longest_s = session_s(plan.duration_s)
    speed = np.rad2deg(np.max(np.abs(model.to_controller(plan.velocity))))
    deviation = max(0.2, 1.5 * float(np.max(np.abs(axis - axis[0]))))
    axes = ''.join(f'\\J{number}:=converged' for number in range(1, 7))
    selected = ''.join(f'\\J{number}' for number in range(1, 7))
    data = [
        *_start_data(plan, model),
        '  ! The session ends by itself once all joints stay inside this for CondTime.',
        '  LOCAL CONST egm_minmax converged:=[-0.001,0.001];',
        '  LOCAL VAR egmident egmGuide;',
    ]
    steps = [
        *_session('egmGuide', options),
        f'    EGMActJoint egmGuide{axes}\\LpFilter:={options.low_pass_hz:g}\\SampleRate:=4'
        f'\\MaxPosDeviation:={deviation:.3f}\\MaxSpeedDeviation:={max(1.0, 1.5 * speed):.2f};',
        '    CheckPlace;',
        *options.mark(1),
        f'    EGMRunJoint egmGuide,EGM_STOP_HOLD{selected}\\CondTime:={longest_s:g}'
        '\\RampInTime:=0.5\\RampOutTime:=0.5;',
    ]
    reset = ['    EGMReset egmGuide;']
    return [*data, *_procedures(options, [*steps, *options.mark(0), *reset], reset)]


def _session(name: str, options: RapidOptions) -> list[str]:
    return [
        f'    EGMReset {name};',
        f'    EGMGetId {name};',
        f'    EGMSetupUC {options.mechanical_unit},{name},"default","{options.udp_device}"'
        f'\\Joint\\CommTimeout:={COMM_TIMEOUT_S};',
    ]


def _start_data(plan: ExcitationPlan, model: FlexibleJointModel) -> list[str]:
    start = _row(np.rad2deg(model.to_controller(plan.start_position)))
    return [
        f'  LOCAL CONST jointtarget jStart:=[{start},[9E9,9E9,9E9,9E9,9E9,9E9]];',
        '  ! Nothing moves unless every axis is this near to where the next move begins [deg].',
        f'  LOCAL CONST num nNear:={start_tolerance_deg(plan):.3f};',
        '  ! Nor unless every external axis is this near to where it was at the beginning.',
        f'  LOCAL CONST num nNearExternal:={NEAR_EXTERNAL:g};',
        f'  LOCAL VAR robjoint rHere:={start};',
        '  LOCAL VAR jointtarget jNow:=jStart;',
        '  LOCAL VAR jointtarget jNext:=jStart;',
    ]


def _procedures(options: RapidOptions, steps: list[str], reset: list[str]) -> list[str]:
    apart = [
        *(f'Abs(jNow.robax.rax_{axis}-rHere.rax_{axis})>nNear' for axis in range(1, 7)),
        *(f'Abs(jNow.extax.eax_{x}-jNext.extax.eax_{x})>nNearExternal' for x in 'abcdef'),
    ]
    ending = [*options.mark(0), *reset, '    AccSet 100,100;', '    EXIT;']
    return [
        '  PROC main()',
        *options.mark(0),
        '    rHere:=jStart.robax;',
        '    jNow:=CJointT();',
        '    jNext.extax:=jNow.extax;',
        '    CheckPlace;',
        *(['    MotionSup\\On;'] if options.collision_detection else []),
        *steps,
        '    AccSet 100,100;',
        '    EXIT;',
        '  ERROR',
        '    StopMove;',
        '    TPWrite "Self-excitation stopped, error "\\Num:=ERRNO;',
        *ending,
        '  ENDPROC',
        '  LOCAL PROC CheckPlace()',
        '    jNow:=CJointT();',
        f'    IF {apart[0]}',
        *(f'      OR {item}' for item in apart[1:-1]),
        f'      OR {apart[-1]} THEN',
        '      TPWrite "An axis is away from where the plan goes on: nothing moves.";',
        *(f'  {line}' for line in ending),
        '    ENDIF',
        '  ENDPROC',
    ]


def _rows(name: str, rows: Iterable[Array]) -> list[str]:
    texts = [_row(row) for row in rows]
    first = f'  LOCAL CONST robjoint {name}{{{len(texts)}}}:=['
    return [first, *(f'    {text},' for text in texts[:-1]), f'    {texts[-1]}];']


def _row(angles_deg: Array) -> str:
    return '[' + ','.join(f'{angle + 0.0:.5f}' for angle in np.round(angles_deg, 5)) + ']'


def _column(name: str, values: list[float], decimals: int) -> list[str]:
    lines, line = [], f'  LOCAL CONST num {name}{{{len(values)}}}:=['
    for index, value in enumerate(values):
        text = f'{value:.{decimals}f}' + (',' if index < len(values) - 1 else '];')
        if len(line) + len(text) > LONGEST_LINE:
            lines.append(line)
            line = '    '
        line += text
    return [*lines, line]
