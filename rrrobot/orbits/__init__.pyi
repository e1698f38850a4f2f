from rrrobot.orbits.linear import Linearisation as Linearisation
from rrrobot.orbits.linear import linearise as linearise
from rrrobot.orbits.oscillations import Mode as Mode
from rrrobot.orbits.oscillations import PeriodRow as PeriodRow
from rrrobot.orbits.oscillations import equilibrium as equilibrium
from rrrobot.orbits.oscillations import measured_period as measured_period
from rrrobot.orbits.oscillations import modes as modes
from rrrobot.orbits.oscillations import table_3 as table_3
