"""The search for one goal: small gaits grown to the limits, polished, and the unlike ones kept.

1. the best small gaits of every posture, frequency and symmetry, from the atlas: no simulation
2. each at a dozen sizes: the largest that the limits allow
3. the best few polished in all joints, offsets and the frequency
4. the best of these with higher harmonics
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np

from rrrobot.checks import Array
from rrrobot.errors import GaitError
from rrrobot.escape.atlas import Atlas
from rrrobot.escape.bench import Bench
from rrrobot.escape.limits import Rules
from rrrobot.escape.polish import Judged, Scale, polish

_SEEDS, _STARTS, _ENRICHED = 12, 4, 1
_FIRST_SHARE = 0.65
"""Of the budget, for one harmonic."""
_UNLIKE = 0.15
"""Distance of points per coordinate at which gaits are different solutions."""


def find_gaits(
    bench: Bench,
    atlas: Atlas,
    rules: Rules,
    *,
    budget: int,
    harmonics: int,
    tell: Callable[[int], None] = lambda done: None,
) -> list[Judged]:
    """Gaits for a goal, the best first; those within the limits before those that are not.

    Args:
        bench: where gaits run.
        atlas: small gaits to begin with.
        rules: limits and the goal.
        budget: gaits that may be simulated.
        harmonics: of the gaits.
        tell: told how many of the budget are simulated.

    Raises:
        GaitError: no gait goes there, or none settles.
    """
    begun = bench.simulated

    def spent(share: float = 1.0) -> bool:
        used = bench.simulated - begun
        tell(min(used, budget))
        return used >= share * budget

    seeds = atlas.seeds(rules, _SEEDS)
    if not seeds:
        raise GaitError(
            f"no small gait goes {rules.goal.name} without going elsewhere: free more joints, or "
            "other groups of them."
        )
    rooms = [atlas.room(seed.small) for seed in seeds]
    found = atlas.grown(rules, seeds)
    if not any(np.isfinite(one.value) for one in found):
        raise GaitError(
            f"no gait settles on the way {rules.goal.name}: the rocking grows without bound. More "
            "damping, a flatter belly or smaller swings would hold it."
        )
    order = _ordered(range(len(found)), found)
    kept: list[tuple[Judged, Array]] = [(found[i], rooms[i]) for i in order]
    polished: list[tuple[Judged, Array]] = []
    for n, i in enumerate(order[:_STARTS]):
        share = _FIRST_SHARE * (n + 1) / _STARTS if harmonics > 1 else (n + 1) / _STARTS
        if spent(share):
            continue
        one = polish(bench, rules, found[i], rooms[i], stop=partial(spent, share))
        polished.append((one, rooms[i]))
    if harmonics > 1:
        for i in _ordered(range(len(polished)), [one for one, _ in polished])[:_ENRICHED]:
            one, room = polished[i]
            polished.append(
                (polish(bench, rules, one, room, harmonics=harmonics, stop=spent), room)
            )
    spent()
    every = [*polished, *kept]
    order = _ordered(range(len(every)), [one for one, _ in every])
    return _unlike([every[i] for i in order], harmonics)


def _ordered(which: range, found: list[Judged]) -> list[int]:
    """Indices, the best first; those that do not settle are left out."""
    fit = [i for i in which if np.isfinite(found[i].value)]
    return sorted(
        fit,
        key=lambda i: (found[i].valid, found[i].value if found[i].valid else found[i].slack),
        reverse=True,
    )


def _unlike(found: list[tuple[Judged, Array]], harmonics: int) -> list[Judged]:
    """Those that differ from all better ones; a shift in time is no difference."""
    chosen: list[Judged] = []
    for one, room in found:
        scale = Scale(room, harmonics)
        near = [_gap(scale, one, other) for other in chosen]
        if min(near, default=np.inf) > _UNLIKE:
            chosen.append(one)
    return chosen


def _gap(scale: Scale, one: Judged, other: Judged) -> float:
    """Root mean square distance of two gaits, whatever their beginning in time."""
    a, b = scale.points(one.gait)[0], scale.points(other.gait)[0]
    legs, harmonics = scale.room.size, scale.harmonics
    end = legs * (1 + harmonics)
    complex_a = (a[legs:end] + 1j * a[end:-1]).reshape(harmonics, legs)
    complex_b = (b[legs:end] + 1j * b[end:-1]).reshape(harmonics, legs)
    turn = np.exp(1j * np.angle(np.vdot(complex_b[0], complex_a[0])))
    shift = turn ** np.arange(1, harmonics + 1)[:, None]
    parts = (a[:legs] - b[:legs], abs(complex_a - shift * complex_b).ravel(), [a[-1] - b[-1]])
    return float(np.sqrt(np.mean(np.concatenate([np.square(p) for p in parts]))))
