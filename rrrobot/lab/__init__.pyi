from rrrobot.lab.server import Laboratory as Laboratory
from rrrobot.lab.server import laboratory as laboratory
