from rrrobot.escape.confirming import EscapeGait as EscapeGait
from rrrobot.escape.goals import Escape as Escape
from rrrobot.escape.limits import EscapeLimits as EscapeLimits
from rrrobot.escape.story import unstick as unstick
from rrrobot.escape.unstuck import Unstuck as Unstuck
from rrrobot.escape.ways import RollOff as RollOff
