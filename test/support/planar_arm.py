"""The arm of the simulated months as a robot folder: three joints about z, springs, masses."""

from structural_model import load_robot
from test.support.months import ARM_KG, LINK_M, MASS_KG, STIFFNESS

LINK = """<link name="l{n}"><inertial><origin xyz="{length} 0 0"/><mass value="{mass}"/>
<inertia ixx="{i}" iyy="{i}" izz="{i}" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="j{n}" type="revolute"><parent link="l{before}"/><child link="l{n}"/>
<origin xyz="{offset} 0 0"/><axis xyz="0 0 1"/>
<limit lower="-3" upper="3" effort="1000" velocity="3"/></joint>"""
TOOL = """<link name="tool0"/><joint name="tool" type="fixed"><parent link="l3"/>
<child link="tool0"/><origin xyz="{length} 0 0"/></joint>"""


def planar_arm(folder, mass_factors=(1.0, 1.0, 1.0), stiffness_factors=(1.0, 1.0, 1.0)):
    """Return the arm's model, read from files, off by factors."""
    folder.mkdir(parents=True, exist_ok=True)
    offsets = (0.0, *LINK_M[:2])
    links = ''.join(
        LINK.format(
            n=n + 1,
            before=n,
            length=LINK_M[n],
            offset=offsets[n],
            mass=MASS_KG[n] * mass_factors[n],
            i=ARM_KG * LINK_M[n] ** 2,
        )
        for n in range(3)
    )
    tool = TOOL.format(length=LINK_M[2])
    (folder / 'robot.urdf').write_text(
        f'<robot name="planar"><link name="l0"/>{links}{tool}</robot>'
    )
    joints = '\n'.join(
        f'  j{n + 1}: {{drive: {{stiffness: {STIFFNESS[n] * stiffness_factors[n]}}}}}'
        for n in range(3)
    )
    (folder / 'model.yaml').write_text(f'robot_name: planar\njoints:\n{joints}\n')
    return load_robot(folder)
