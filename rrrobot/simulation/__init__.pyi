from rrrobot.simulation.recombined import decoupled as decoupled
from rrrobot.simulation.run import simulate as simulate
from rrrobot.simulation.steady import SteadyState as SteadyState
from rrrobot.simulation.steady import steady_state as steady_state
from rrrobot.simulation.trajectory import Trajectory as Trajectory
