"""What the paper claims in words, each claim measured: agrees, or differs, and by how much."""

from __future__ import annotations

from rrrobot.paper.claims_axes import AXES_CLAIMS
from rrrobot.paper.claims_drift import DRIFT_CLAIMS
from rrrobot.paper.claims_reach import REACH_CLAIMS
from rrrobot.paper.claims_travel import TRAVEL_CLAIMS
from rrrobot.paper.claims_yaw import YAW_CLAIMS
from rrrobot.paper.item import Item

CLAIMS: tuple[Item, ...] = (
    *TRAVEL_CLAIMS,
    *REACH_CLAIMS,
    *AXES_CLAIMS,
    *YAW_CLAIMS,
    *DRIFT_CLAIMS,
)
