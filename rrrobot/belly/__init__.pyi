from rrrobot.belly.fit import fit_belly as fit_belly
from rrrobot.belly.found import Belly as Belly
from rrrobot.belly.ranges import RollingRange as RollingRange
from rrrobot.belly.shapes import Piece as Piece
from rrrobot.belly.shapes import Shapes as Shapes
