"""rrrobot: legless locomotion of round robots. See README.md."""

from rrrobot.constraints import (
    ConstraintRows,
    KKTSolution,
    KKTSystem,
    PrescribedJoints,
    RollingContact,
    contact_drift,
    contact_jacobian,
    contact_point,
    kkt_build,
    kkt_solve,
    projected_acceleration,
    rolling_null_space,
    rolling_projector,
)
from rrrobot.damping import BodyRateDamping, Damping, EulerRateDamping
from rrrobot.errors import (
    ConstraintError,
    GaitError,
    GroundClearanceWarning,
    MissingExtraError,
    ModelError,
    OutputError,
    ParameterError,
    RRRobotError,
    ShellError,
    SimulationError,
    SimulationInterrupted,
    UrdfError,
)
from rrrobot.gaits import (
    CallableGait,
    FourierGait,
    Gait,
    LegMotion,
    RampIn,
    SinusoidalGait,
    StillLegs,
    gait,
)
from rrrobot.models.full import FullModel
from rrrobot.parameters import RRRobotParameters
from rrrobot.robot import Robot, example_robots
from rrrobot.simulate import simulate
from rrrobot.steady_state import SteadyState
from rrrobot.surfaces import Ellipsoid, Sphere, Surface
from rrrobot.torques import LegTorques, MotionState
from rrrobot.trajectory import Trajectory
from rrrobot.urdf import reduced_urdf, rrrobot_urdf, urdf_path
