"""How legs lean to a side: limb by limb, on ways that touch nothing.

Each limb in turn goes to the posture that shifts the centre of mass farthest, of those to which a
way leads: straight, or over one posture between. Where all of them can go at once, they do.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from rrrobot.belly.posture import ASIDE, Search
from rrrobot.checks import Array

_FAR = 10.0
"""Place to the side that is as good as infinitely far [m]."""
_BETWEEN = 6
"""Power of two: postures between that are tried for a limb."""
_TRIED, _ASKED = 24, 12
"""Postures of a limb to which ways are looked for, and ways to one of which Coal is asked."""
_LOOKED = 16
"""Postures that are looked at on each straight part."""
_APART, _ROOM = 0.002, 0.003
"""Distances of links, and of links and ground, that are wanted on the way [m]."""
_WORTH = 5e-4
"""Of what a posture costs, the least gain for which a limb moves; see `Search.costs` [m]."""
_BACK = 0.004
"""How far the centre of mass may go to the other side on the way [m]."""


def leaning(search: Search, start: Array, side: Array, rise: float) -> list[Array]:
    """Postures (legs,) from `start` on, the last with the centre of mass far to a side (2,).

    Limbs mirror each other as the search says.

    Args:
        search: of the robot over its ground; its aim is set here.
        start: posture (legs,).
        side: unit vector.
        rise: how far to the side counts as much as a metre up: of a body that is to tip over at
            an angle a, tan(a).
    """
    search.middle, search.height = _FAR * side, -ASIDE * rise
    passed = [start]
    for limb in search.groups():
        passed += _moved(search, passed[-1], limb)
    every = tuple(range(start.size))
    if _clear(search, [passed[0], passed[-1]], every):
        return [passed[0], passed[-1]]
    return passed


def farthest(search: Search, start: Array) -> Array:
    """The posture (legs,) that leans most if nothing is in the legs' way, as `leaning` aims."""
    angle = start
    for limb in search.groups():
        angle = search.candidates(angle, limb, free=True)[0][0]
    return angle


def _moved(search: Search, start: Array, limb: tuple[int, ...]) -> list[Array]:
    """Where a limb and its images go from a posture; nowhere if nothing better is in reach."""
    trials, costs = search.candidates(start, limb)
    stay = search.costs(start[None], search.capsules_of(search.moved(limb)))
    trials = trials[costs < stay - _WORTH]
    for i in search.unlike(trials, limb)[:_TRIED]:
        if _clear(search, [start, trials[i]], limb):
            return [trials[i]]
        for between in _between(search, start, trials[i], limb):
            if _apart(search, _along([start, between, trials[i]])):
                return [between, trials[i]]
    return []


def _between(search: Search, start: Array, end: Array, limb: tuple[int, ...]) -> list[Array]:
    """Postures over which a limb's way is clear of ground and floor, the shortest way first."""
    from scipy.stats import qmc

    legs = list(limb)
    unit = qmc.Sobol(len(legs), rng=np.random.default_rng(2)).random_base2(_BETWEEN)
    found = np.tile(start, (len(unit), 1))
    found[:, legs] = search.low[legs] + unit * (search.high - search.low)[legs]
    found = search.mirrored(found, limb)
    far = np.abs(found - start).sum(axis=1) + np.abs(end - found).sum(axis=1)
    found = found[np.argsort(far, kind="stable")]
    way = np.vstack([_along([start, one, end]) for one in found])
    miss = _misses(search, way, limb).reshape(len(found), -1).max(axis=1)
    return list(found[miss <= 0][:_ASKED])


def _along(postures: list[Array]) -> Array:
    parts = np.linspace(0.0, 1.0, _LOOKED)[:, None]
    return np.vstack([a + parts * (b - a) for a, b in pairwise(postures)])


def _clear(search: Search, postures: list[Array], limb: tuple[int, ...]) -> bool:
    way = _along(postures)
    return bool(_misses(search, way, limb).max() <= 0) and _apart(search, way)


def _misses(search: Search, way: Array, limb: tuple[int, ...]) -> Array:
    """How far a way of a limb is from what is wanted (n,) [m].

    It comes no closer to the ground than `_ROOM`, or than at both ends, and the centre of mass
    does not go the other way first.
    """
    capsules = search.capsules_of(search.moved(limb))
    centers, gaps = search.gaps(way, capsules)
    wanted = np.minimum(_ROOM, np.minimum(gaps[0], gaps[-1]))
    away = np.linalg.norm(centers[:, :2] - search.middle, axis=1)
    short = np.maximum(0.0, wanted - gaps).max(axis=(1, 2), initial=0.0)
    return np.asarray(np.maximum(short, away - away[0] - _BACK))


def _apart(search: Search, way: Array) -> bool:
    least = min(_APART, search.separation(way[0]), search.separation(way[-1]))
    return least > 0 and all(search.separation(one) >= least for one in way)
