"""The search for one goal: small gaits grown to the limits, then climbs from the best of them.

1. the best small gaits of every posture, frequency and symmetry, from the atlas: no simulation
2. each at a dozen sizes: the largest that the limits allow
3. climbs from these: first as their group moves, then in all joints, then with higher harmonics;
   where all have ended before the budget has, the next best small gaits are taken

What is simulated next depends on what was found, and never on the budget, which only says when to
stop: a larger budget sees all that a smaller one saw, so that its best is never worse.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from itertools import islice

import numpy as np

from rrrobot.checks import Array
from rrrobot.errors import GaitError
from rrrobot.escape.atlas import Atlas, Seed
from rrrobot.escape.bench import Bench
from rrrobot.escape.limits import Rules
from rrrobot.escape.polish import Judged, Scale, climb, judge

_SEEDS = 12
_SLICE = 3
"""Steps of a climb before another may go on."""
_GROUPED, _SINGLE, _ENRICHED = 8, 12, 30
"""Steps as the group moves, in all joints, and with higher harmonics, at most."""
UNLIKE, SAME = 0.15, 0.03
"""Distance of points per coordinate from which on gaits are different solutions; and up to which
they are one and the same."""
_ROOM = 0.5
"""Of the legs, for such distances [rad]."""

Nearer = Callable[[Bench, Judged], Bench | None]


def find_gaits(
    bench: Bench,
    atlas: Atlas,
    rules: Rules,
    *,
    budget: int,
    harmonics: int,
    nearer: Nearer = lambda bench, one: None,
    tell: Callable[[int], None] = lambda done: None,
) -> list[Judged]:
    """Gaits for a goal, the best first; those that are clear and within the limits before others.

    Args:
        bench: that counts what is simulated.
        atlas: small gaits to begin with.
        rules: limits and the goal.
        budget: gaits that may be simulated; no climb goes on once they are.
        harmonics: of the gaits.
        nearer: of a bench and a gait, None if the links' own shapes are clear, else a bench that
            knows better from where the gait is.
        tell: told how many of the budget are simulated.

    Raises:
        GaitError: no gait goes there, or none settles.
    """
    begun = bench.simulated
    seeds = atlas.seeds(rules, _SEEDS)
    if not seeds:
        raise GaitError(
            f"no small gait goes {rules.goal.name} without going elsewhere: free more joints, or "
            "other groups of them."
        )
    found = atlas.grown(rules, seeds)
    order = ordered(found)
    if not order:
        raise GaitError(
            f"no gait settles on the way {rules.goal.name}: the rocking grows without bound. More "
            "damping, a flatter belly or smaller swings would hold it."
        )
    nearest, seen, taken, turn = found[order[0]], list[Judged](), len(seeds), 0

    def begin() -> list[_Climb]:
        climbs = [
            _Climb(rules, seeds[i], found[i], atlas.room(seeds[i].small), harmonics, nearer)
            for i in ordered(found)
        ]
        seen.extend(one.best for one in climbs if one.clear)
        return climbs

    climbs = begin()
    while bench.simulated - begun < budget:
        tell(bench.simulated - begun)
        # What does not settle once more is known of the links' own shapes is no beginning.
        climbs = [one for one in climbs if np.isfinite(one.best.value)]
        if not climbs:
            seeds = atlas.seeds(rules, taken + _SEEDS)[taken:]
            if not seeds:
                break
            taken += len(seeds)
            found = atlas.grown(rules, seeds)
            climbs = begin()
            continue
        # By turns the best one, and the one that had the least chance; of equals, the better seed.
        if turn % 2 == 0:
            one = climbs[ordered([one.best for one in climbs])[0]]
        else:
            one = min(climbs, key=lambda climb: climb.slices)
        if not one.goes_on():
            climbs.remove(one)
        elif one.clear and not any(one.best is other for other in seen):
            seen.append(one.best)
        turn += 1
    tell(budget)
    climbs = [one for one in climbs if np.isfinite(one.best.value)]
    seen = seen or [one.best for one in climbs] or [nearest]
    return [seen[i] for i in ordered(seen)]


class _Climb:
    """A climb that can be left and taken up again."""

    def __init__(
        self, rules: Rules, seed: Seed, start: Judged, room: Array, harmonics: int, nearer: Nearer
    ) -> None:
        self.best, self.bench, self.slices = start, seed.bench, 0
        self.rules, self.group, self.room = rules, seed.group, room
        self.harmonics, self.nearer = harmonics, nearer
        self.steps = self._steps()
        self._look()

    def goes_on(self) -> bool:
        """Some more steps; False if there are none."""
        self.slices += 1
        steps = list(islice(self.steps, _SLICE))
        if steps:
            self.best = steps[-1]
            self._look()
        return bool(steps)

    def _look(self) -> None:
        """Hold the best gait against the links' own shapes; if they touch, go on knowing that."""
        better = self.nearer(self.bench, self.best) if self.best.valid else None
        self.clear = better is None
        if better is not None:
            self.bench = better
            gait = self.best.gait
            self.best = judge(self.rules, gait, better(gait))[0]
            self.steps = self._steps()

    def _steps(self) -> Iterator[Judged]:
        single, group = Scale(self.room, self.best.gait.sine.shape[1]), self.group
        if group.swings.shape[1] < self.room.size:
            free = single.directions(group.swings, group.offsets)
            yield from self._climb(single, free, _GROUPED)
        yield from self._climb(single, None, _SINGLE if self.harmonics > 1 else _ENRICHED)
        if self.harmonics > 1:
            yield from self._climb(Scale(self.room, self.harmonics), None, _ENRICHED)

    def _climb(self, scale: Scale, free: Array | None, most: int) -> Iterator[Judged]:
        return climb(self.bench, self.rules, self.best, scale, free=free, iterations=most)


def ordered(found: list[Judged]) -> list[int]:
    """Indices, the best first; those that do not settle are left out."""
    return sorted(
        (i for i, one in enumerate(found) if np.isfinite(one.value)),
        key=lambda i: (found[i].valid, found[i].value if found[i].valid else found[i].slack),
        reverse=True,
    )


def gap(one: Judged, other: Judged) -> float:
    """Root mean square distance of two gaits, whatever their beginning in time."""
    legs = one.gait.offset.shape[1]
    harmonics = max(one.gait.sine.shape[1], other.gait.sine.shape[1])
    scale = Scale(np.full(legs, _ROOM), harmonics)
    a, b = scale.points(one.gait)[0], scale.points(other.gait)[0]
    end = legs * (1 + harmonics)
    complex_a = (a[legs:end] + 1j * a[end:-1]).reshape(harmonics, legs)
    complex_b = (b[legs:end] + 1j * b[end:-1]).reshape(harmonics, legs)
    turn = np.exp(1j * np.angle(np.vdot(complex_b[0], complex_a[0])))
    shift = turn ** np.arange(1, harmonics + 1)[:, None]
    parts = (a[:legs] - b[:legs], abs(complex_a - shift * complex_b).ravel(), [a[-1] - b[-1]])
    return float(np.sqrt(np.mean(np.concatenate([np.square(p) for p in parts]))))
