"""What a flexible-joint model is made of, as immutable data.

An effect never patches a model: it returns a new ``ModelSpec`` (``dataclasses.replace`` or
``with_parameters``) and a new model is built from that.
"""

from dataclasses import dataclass, field
import math

Vector = tuple[float, float, float]
ZERO: Vector = (0.0, 0.0, 0.0)


@dataclass(frozen=True, slots=True)
class Spring:
    """A linear spring with a viscous damper beside it.

    Parameters
    ----------
    stiffness : float [N m/rad], or [N/m] for a translation
        Infinite: the degree of freedom does not exist.
    damping : float [N m s/rad], or [N s/m] for a translation
        Viscous coefficient.
    """

    stiffness: float = math.inf
    damping: float = 0.0

    @property
    def rigid(self) -> bool:
        """Whether the degree of freedom does not exist."""
        return math.isinf(self.stiffness)


@dataclass(frozen=True, slots=True)
class Drive:
    """Gear, motor and servo of one axis.

    Parameters
    ----------
    spring : Spring
        Twist between motor and link about the joint axis, seen at the link.
    gear_ratio : float
        Motor turns per joint turn.
    rotor_inertia_kg_m2 : float [kg m²]
        Rotor and everything that turns with it, at the motor shaft.
    servo : Spring
        Position stiffness and damping of the servo at the link side; infinite: the drive
        prescribes the motor angle.
    """

    spring: Spring = Spring()
    gear_ratio: float = 1.0
    rotor_inertia_kg_m2: float = 0.0
    servo: Spring = Spring()


@dataclass(frozen=True, slots=True)
class JointSpec:
    """Flexibility of one joint: drive twist about its axis, two bearing tilts across it.

    Parameters
    ----------
    name : str
        Joint of the URDF.
    drive : Drive
        About the axis (or along it, for a prismatic joint).
    tilts : (2,) tuple of Spring
        About the two axes across, fixed in the parent link (see ``assembly.across``).
    offset_rad : float [rad]
        How much further the joint stands than its encoder says ([m] of a prismatic one).  The
        dynamics and the sensors' readings know it; shapes and their collisions do not.
    """

    name: str
    drive: Drive = Drive()
    tilts: tuple[Spring, Spring] = (Spring(), Spring())
    offset_rad: float = 0.0


@dataclass(frozen=True, slots=True)
class BaseSpec:
    """Six springs between the floor and the base link.

    Parameters
    ----------
    springs : (6,) tuple of Spring
        Along x, y, z [N/m] and about x, y, z [N m/rad].
    position_m : (3,) tuple [m]
        Where they act, in the base frame.
    """

    springs: tuple[Spring, Spring, Spring, Spring, Spring, Spring] = (Spring(),) * 6
    position_m: Vector = ZERO


@dataclass(frozen=True, slots=True)
class FoundationSpec:
    """A body under the base's springs that swings on springs of its own: floor, block, plate.

    Parameters
    ----------
    springs : (6,) tuple of Spring
        Along its x, y, z [N/m] and about them [N m/rad]; all infinite: there is none.
    mass_kg : float [kg]
        Of the body.
    gyration_m : float [m]
        Its radius of gyration about any axis.
    position_m : (3,) tuple [m]
        Where the springs act and its centre of mass is, in the base frame.
    yaw_rad : float [rad]
        By which its x and y are turned about the base's z.
    """

    springs: tuple[Spring, Spring, Spring, Spring, Spring, Spring] = (Spring(),) * 6
    mass_kg: float = 0.0
    gyration_m: float = 0.0
    position_m: Vector = ZERO
    yaw_rad: float = 0.0

    @property
    def rigid(self) -> bool:
        """Whether it stands still."""
        return all(spring.rigid for spring in self.springs)


@dataclass(frozen=True, slots=True)
class CableSpec:
    """A hose or cable that pulls a point of a link towards a point of the ground.

    About a pose it is a spring along its own direction, whatever its length; a steady pull besides
    loads the arm and resists what turns its direction.

    Parameters
    ----------
    name : str
        Unique name.
    link : str
        Link it is fixed to.
    position_m : (3,) tuple [m]
        Where, in the link frame.
    anchor_m : (3,) tuple [m]
        Its other end, in the base frame.
    stiffness_n_m : float [N/m]
        Along it.
    pull_n : float [N]
        The same in every pose.
    """

    name: str
    link: str
    position_m: Vector
    anchor_m: Vector
    stiffness_n_m: float
    pull_n: float = 0.0


@dataclass(frozen=True, slots=True)
class LinkSpec:
    """Corrections to the inertia the URDF gives a link.

    Parameters
    ----------
    name : str
        Link of the URDF.
    mass_factor, inertia_factor : float
        Scale mass (and inertia with it), and the inertia about the centre of mass alone.
    com_shift_m : (3,) tuple [m]
        Added to the centre of mass, in the link frame.
    """

    name: str
    mass_factor: float = 1.0
    inertia_factor: float = 1.0
    com_shift_m: Vector = ZERO


@dataclass(frozen=True, slots=True)
class MassSpec:
    """A mass fixed to a link: payload, tool, sensor; negative takes away.

    Parameters
    ----------
    name : str
        Unique name.
    link : str
        Link it is fixed to.
    mass_kg : float [kg]
        Mass.
    position_m : (3,) tuple [m]
        Centre of mass in the link frame.
    gyration_m : (3,) tuple [m]
        Radii of gyration about x, y, z through the centre of mass.
    """

    name: str
    link: str
    mass_kg: float
    position_m: Vector = ZERO
    gyration_m: Vector = ZERO


@dataclass(frozen=True, slots=True)
class HingeSpec:
    """One extra compliance inside a link (virtual hinge or slide).

    Parameters
    ----------
    name : str
        Unique name.
    link : str
        Link it divides.
    position_m : (3,) tuple [m]
        Where, in the link frame.
    axis : (3,) tuple
        Axis in the link frame.
    spring : Spring
        About (or along) the axis.
    translation : bool
        A slide along the axis instead of a turn about it.
    outboard_share : float
        Share of the link's inertia that rides beyond it.
    """

    name: str
    link: str
    position_m: Vector
    axis: Vector
    spring: Spring
    translation: bool = False
    outboard_share: float = 0.5


@dataclass(frozen=True, slots=True)
class BeamSpec:
    """An Euler-Bernoulli beam inside a link, from one point to another.

    Parameters
    ----------
    name : str
        Unique name.
    link : str
        Link it is part of.
    start_m, end_m : (3,) tuple [m]
        Ends in the link frame; what lies beyond the end rides on the tip.
    bending_n_m2 : (2,) tuple [N m²]
        EI about the two axes across the beam (see ``assembly.across``).
    torsion_n_m2 : float [N m²]
        GJ.
    axial_n : float [N]
        EA; infinite: no stretch.
    mass_kg : float [kg]
        Share of the link's mass spread evenly along the beam.
    outboard_share : float
        Share of the remaining inertia of the link that rides on the tip.
    gyration_m : float [m]
        Radius of gyration of that share about the beam's axis; needed with torsion.
    elements : int
        Number of segments.
    damping_s : float [s]
        Stiffness-proportional material damping.
    """

    name: str
    link: str
    start_m: Vector
    end_m: Vector
    bending_n_m2: tuple[float, float]
    torsion_n_m2: float = math.inf
    axial_n: float = math.inf
    mass_kg: float = 0.0
    outboard_share: float = 0.0
    gyration_m: float = 0.0
    elements: int = 2
    damping_s: float = 0.0


@dataclass(frozen=True, slots=True)
class AbsorberSpec:
    """A mass on a spring at a point of a link: dress pack, hose, tuned mass.

    Parameters
    ----------
    name : str
        Unique name.
    link : str
        Link it hangs on.
    position_m : (3,) tuple [m]
        Where, in the link frame.
    axis : (3,) tuple
        Direction it moves in, in the link frame.
    mass_kg : float [kg]
        Moving mass.
    spring : Spring
        Along the axis [N/m], [N s/m].
    """

    name: str
    link: str
    position_m: Vector
    axis: Vector
    mass_kg: float
    spring: Spring


@dataclass(frozen=True, slots=True)
class RodSpec:
    """A spring on a combination of joint deflections: K += k wwᵀ.

    Parameters
    ----------
    name : str
        Unique name.
    weights : tuple of (joint name, float)
        The combination w, for a rod over joints 2 and 3 one of (1, 1) or (1, -1).
    spring : Spring
        Stiffness of the combination [N m/rad].
    """

    name: str
    weights: tuple[tuple[str, float], ...]
    spring: Spring


@dataclass(frozen=True, slots=True)
class CompensatorSpec:
    """A gravity compensator: torque -κ sin(q - φ) on one joint.

    Parameters
    ----------
    name : str
        Unique name.
    joint : str
        Joint it acts on.
    strength_nm : float [N m]
        κ, spring rate times lever arms; adds κ cos(q - φ) to the stiffness.
    phase_rad : float [rad]
        φ, the joint angle at which it is neutral.
    """

    name: str
    joint: str
    strength_nm: float
    phase_rad: float = 0.0


@dataclass(frozen=True, slots=True)
class MaterialDamping:
    """Proportional structural damping C += α M + β K.

    Parameters
    ----------
    mass_proportional_1_s : float [1/s]
        α.
    stiffness_proportional_s : float [s]
        β, on every spring.
    """

    mass_proportional_1_s: float = 0.0
    stiffness_proportional_s: float = 0.0


@dataclass(frozen=True, slots=True)
class KnownNumber:
    """A parameter of a known effect.

    Parameters
    ----------
    name : str
        Of the parameter.
    value, sigma : float
        As it was fitted, and its standard deviation.
    unit : str
        Of both; ``1`` for a plain number.
    """

    name: str
    value: float
    sigma: float = 0.0
    unit: str = '1'


@dataclass(frozen=True, slots=True)
class KnownEffect:
    """A physical effect that was found missing and has been added.

    Parameters
    ----------
    type, location, variant : str
        As the catalogue of effects names them; empty where there is none.
    kept_in : str
        Where its numbers are: ``model`` (masses, springs and dampers beside this list), ``layout``
        (the sensor layout), or ``effects`` (only in this list, for those who know the effect).
    parameters : tuple of KnownNumber
        May be empty.
    """

    type: str
    location: str = ''
    variant: str = ''
    kept_in: str = 'model'
    parameters: tuple[KnownNumber, ...] = ()

    @property
    def where(self) -> str:
        """Place and variant in words that follow its name; empty where there are none."""
        place = f' at {self.location}' if self.location else ''
        return place + (f' ({self.variant})' if self.variant else '')


@dataclass(frozen=True, slots=True)
class ModelSpec:
    """Everything the URDF does not say.

    Parameters
    ----------
    joints : tuple of JointSpec
        One per moving joint of the URDF, in its order.
    base, foundation, links, masses, hinges, beams, absorbers, rods, compensators, cables
        See their classes; empty means absent.
    damping : MaterialDamping
        Proportional damping of everything.
    gravity_m_s2 : (3,) tuple [m/s²]
        In the base frame.
    effects : tuple of KnownEffect
        Effects that were added to this model.
    tolerances : tuple of (str, float)
        How roughly its numbers are known, by kind or by name: see ``model_gap``.
    """

    joints: tuple[JointSpec, ...]
    base: BaseSpec = BaseSpec()
    foundation: FoundationSpec = FoundationSpec()
    links: tuple[LinkSpec, ...] = ()
    masses: tuple[MassSpec, ...] = ()
    hinges: tuple[HingeSpec, ...] = ()
    beams: tuple[BeamSpec, ...] = ()
    absorbers: tuple[AbsorberSpec, ...] = ()
    rods: tuple[RodSpec, ...] = ()
    compensators: tuple[CompensatorSpec, ...] = ()
    cables: tuple[CableSpec, ...] = ()
    damping: MaterialDamping = field(default_factory=MaterialDamping)
    gravity_m_s2: Vector = (0.0, 0.0, -9.81)
    effects: tuple[KnownEffect, ...] = ()
    tolerances: tuple[tuple[str, float], ...] = ()

    @property
    def stands_at_m(self) -> Vector:
        """Where the springs under the base link are, in the base frame."""
        on_springs = not all(spring.rigid for spring in self.base.springs)
        return self.base.position_m if on_springs else self.foundation.position_m
