"""Numbers in the sentences of README and docs: none that no test holds, and what they are.

A result counts as a number if it has a point, an exponent, or a unit. Numbers in words do not, nor
those of code, which runs, and of formulas that stand by themselves.
"""

import ast
import inspect
import re
from functools import cache
from itertools import pairwise

import numpy as np
import pytest

import rrrobot
from rrrobot import files, results
from rrrobot.drive.gaits import sinusoidal
from rrrobot.drive.moves import out_of_phase_gait
from rrrobot.escape import atlas, confirming, edges, loss, story
from rrrobot.machines import mechanism
from rrrobot.momentum.coefficients import coefficients
from rrrobot.orbits import many, travel
from rrrobot.robot import faults, joints, limits, markup, meshes
from rrrobot.simulation import effort
from rrrobot.simulation.plots import cycle_mean
from rrrobot.steering import reachable
from rrrobot.studies.sweeps import counts
from rrrobot.view import motion, server
from tests.pages import DOCS, are_printed, joined, number, numbers, said

PAGES = ["../README.md", *sorted(str(p.relative_to(DOCS)) for p in DOCS.rglob("*.md"))]
WRITTEN = {"benchmarks.md", "steering_study.md"}
"""By a program from results; a test compares the whole."""
UNIT = "(?:times|gaits|periods|cycles|steps|digits|rad|deg|[mck]?m|[mµn]?s|k?Hz|k?g|N|m?W|[kMG]B|J)"
NUMBER = re.compile(
    r"(?<![\w.,^-])[\u2212-]?"
    rf"(?:\d+\.\d+(?:e-?\d+)?|\d+e-?\d+|\d+(?= ?[%°]| {UNIT}\b))"
)
PASSED = re.compile(
    r"```.*?```|`[^`]*`|\$\$.*?\$\$|\]\([^)]*\)"
    r"|<!-- (?:robots|written by python -m benchmarks.report) -->.*?<!-- end -->"
    r"|(?:sec\.|eqs?|Python|pitch of|pitch is|pitch reaches) [±(]?[\d.]+"
)
"""Code, formulas, targets of links, what a program writes into a page and a test compares whole;
numbers of sections, equations and versions, and the pitch at which Euler angles end."""
GIVEN = [
    ("errata.md", r"generalised force \$(-[\d.]+)", "eq (9)"),
    ("errata.md", r"only adds \$([\d.]+)", "eq (9)"),
    ("theory/models.md", r"torques, by \$([\d.]+)", "eq (9)"),
    ("errata.md", r"Table 3, pivoting pitch \| ([\d.]+) s", "Table 3"),
    ("theory/models.md", r"The paper's ([\d.]+) s", "Table 3"),
    ("errata.md", r"large at (\d+)° as at (\d+)°", "where the sine is a half, and one"),
    ("errata.md", r"swung (\d+)° out of .* At (\d+)° roll .* yaw, at (\d+)° ", "gaits"),
    ("errata.md", r"rad in (\d+) s\. rrrobot starts", "how long the run is"),
    ("table4.md", r"A = ([\d.]+) rad, ω = (\d+) rad/s, paper's damping, (\d+) s", "what is run"),
    ("table4.md", r"full model \(([\d.]+) N m s/rad, eq 9", "eq (9)"),
    ("ideal.md", r"robot \| friction needed (.*?) Why they part", "the record of benchmarks.ideal"),
    ("ideal.md", r"Each run is (\d+) cycles", "what is run"),
    ("ideal.md", r"MuJoCo has only ([\d.]+) the", "what is run"),
    ("theory/steering.md", r"gait at ([\d.]+) rad: (\d+) cycles", "of its code"),
]
"""Numbers that are no results: place and reason."""


@cache
def pairs() -> list[tuple[str, str]]:
    """Page and sentence wherever a test has them side by side, which is how it reads numbers."""
    found = []
    for path in (DOCS.parent / "tests").glob("test_*.py"):
        text = path.read_text()
        for node in ast.walk(ast.parse(text)) if "tests.pages" in text else ():
            if isinstance(node, ast.Tuple | ast.Call):
                parts = node.elts if isinstance(node, ast.Tuple) else node.args
                words = [getattr(part, "value", None) for part in parts]
                found += [(a, b) for a, b in pairwise(words) if a in PAGES and isinstance(b, str)]
    return found


def shown(text: str) -> set[float]:
    """Numbers of a page's code that runs, of lengths in centimetres too."""
    code = " ".join(re.findall(r"```(?:python|console)(.*?)```", text))
    found = {float(x) for x in re.findall(r"(?<![\w.])\d+\.?\d*(?:e-?\d+)?", code)}
    return found | {round(100 * x, 9) for x in found if x < 1}


@pytest.mark.parametrize("page", sorted(set(PAGES) - WRITTEN))
def test_every_number_is_held(page):
    text = joined(page)
    inputs = shown(text)
    spans = [
        match.span(group + 1)
        for sentence in (s for p, s in pairs() if p == page)
        for match in re.finditer(sentence, text)
        for group in range(match.re.groups)
    ]
    prose = PASSED.sub(lambda m: " " * len(m[0]), text)
    free = [
        prose[max(0, m.start() - 50) : m.end() + 20]
        for m in NUMBER.finditer(prose)
        if abs(number(m[0])) not in inputs
        and not any(low <= m.start() and m.end() <= high for low, high in spans)
    ]
    assert free == []


def test_what_counts_as_a_number():
    text = (
        "At 8 rad/s (sec. 4.2, eq (9)) it is 0.95 s, off by 12 %, 3e-9; `a = 1.5`: 30 times in 5."
    )
    assert NUMBER.findall(PASSED.sub(" ", text)) == ["8", "0.95", "12", "3e-9", "30"]


@pytest.mark.parametrize(("page", "sentence", "reason"), GIVEN)
def test_what_is_given_is_there_once(page, sentence, reason):
    assert said(page, sentence) and reason


RRROBOT = rrrobot.Robot.from_parameters()
LATERAL, CIRCULAR = rrrobot.gait("lateral"), rrrobot.gait("circular")


def test_the_readme_s_numbers_are_what_comes_out():
    """What they are held against has its tests."""
    model = rrrobot.FullModel(RRROBOT)
    runs = [rrrobot.simulate(model, gait, 30.0, method="momentum") for gait in (LATERAL, CIRCULAR)]
    straight, round_ = (run.steady_state() for run in runs)
    ours, kane = numbers(
        "../README.md", r"lateral gait, v \| ([\d.]+) mm/s \(Kane: ([\d.]+)\)"
    )  # fmt: skip
    assert (ours, kane) == pytest.approx(2 * (1e3 * straight.speed,), rel=2e-6)
    speed, rate, *by_kane = numbers(
        "../README.md", r"yaw rate \| ([\d.]+) mm/s, ([\d.]+) rad/s \(Kane: ([\d.]+), ([\d.]+)\)"
    )  # fmt: skip
    for told, found, near in ((speed, 1e3 * round_.speed, 2e-6), (rate, round_.yaw_rate, 5e-6)):
        assert told == pytest.approx(found, rel=near)
    assert by_kane == pytest.approx([speed, rate], rel=2e-6)
    (least,) = numbers("../README.md", r"any run \| below ([\de-]+) m/s and m")
    for run in runs:
        assert max(run.slip.max(), np.abs(run.height_error).max()) < least


def turning():
    return rrrobot.limit_cycle(rrrobot.FullModel(RRROBOT), CIRCULAR).yaw_rate


def yaw_inertia(leg_angle):
    return float(
        rrrobot.paper.yaw_mass_matrix(rrrobot.RRRobotParameters(), (leg_angle, leg_angle))[0, 0]
    )


def small_yaw():
    """2 alpha |sin(delta / 2)| a(o) at 0.3 rad, pi/2 and pi/2 [rad]."""
    return 2 * 0.3 * np.sin(np.pi / 4) * LEVER / yaw_inertia(np.pi / 2)


def whole_yaw():
    gait = rrrobot.SinusoidalGait(
        offset=np.pi / 2, amplitude=0.3, angular_frequency=8.0, phase=(0.0, np.pi / 2)
    )
    return 0.5 * np.ptp(
        rrrobot.simulate(rrrobot.YawModel(RRROBOT), gait, 10.0, method="momentum").euler[:, 2]
    )


def pitch_resonance():
    """Of the pitch with the legs up [rad/s]."""
    found = rrrobot.orbits.modes(rrrobot.FullModel(RRROBOT), (np.pi / 2, np.pi / 2))
    return next(2 * np.pi / mode.period for mode in found if mode.axis == "pitch")


def spread_of_where_cycles_begin():
    t = rrrobot.simulate(rrrobot.FullModel(RRROBOT), CIRCULAR, 40.0, method="momentum")
    period = CIRCULAR.period
    time, means = cycle_mean(t.time, t.position, period)
    late = slice(int(np.searchsorted(time, 30.0)), None)
    steps = [np.interp(time[late][:200] + period, time, x) - x[late][:200] for x in means.T]
    speed = np.hypot(*steps) / period
    return np.ptp(speed) / speed.mean()


def pivoting_pitch():
    return next(r for r in rrrobot.orbits.table_3() if (r.model, r.axis) == ("pivoting", "pitch"))


def net_yaw_of_a():
    return rrrobot.reduction.net_yaw(RRROBOT, out_of_phase_gait(offset=5 * np.pi / 8 + 0.15))


TABLE_2 = rrrobot.RRRobotParameters()
LEVER = 0.057 * 0.1 * 0.12
"""M_l l b [kg m^2]."""


@pytest.mark.parametrize(
    ("page", "sentence", "value"),
    [
        ("extend/constraint.md", r"the same gait turns at ([\d.]+) rad/s", turning),
        ("theory/yaw.md", r"robot turns at ([\d.]+) rad/s", turning),
        ("theory/small_gaits.md", r"resonance at ([\d.]+) rad/s", pitch_resonance),
        ("theory/travel.md", r"by ([\de.-]+) of the circular", spread_of_where_cycles_begin),
        ("theory/travel.md", r"itself, ([\de.-]+) for the circular",
         lambda: (turning() * CIRCULAR.period) ** 2 / 24),
        ("reduction.md", r"up, ([\d.]+) kg", lambda: yaw_inertia(np.pi / 2)),
        ("reduction.md", r"against ([\d.]+) with", lambda: yaw_inertia(0.0)),
        ("reduction.md", r"where \$a\$ is ([\d.]+)", lambda: LEVER / yaw_inertia(np.pi / 2)),
        ("reduction.md", r"and ([\d.]+) times as\s+high",
         lambda: yaw_inertia(0.0) / yaw_inertia(np.pi / 2)),
        ("reduction.md", r"formula gives ([\d.]+) rad", small_yaw),
        ("reduction.md", r"whole model ([\d.]+) rad", whole_yaw),
        ("files.md", r"more than ([\d.]+) MB", lambda: markup.MAX_BYTES / 1e6),
        ("files.md", r"MB, (\d+) links", lambda: faults._MAX_LINKS),
        ("files.md", r"a chain of (\d+)", lambda: faults._MAX_CHAIN),
        ("files.md", r"(\d+) moving joints", lambda: joints._MAX_LEGS),
        ("files.md", r"process of its own within (\d+) s", lambda: meshes._SECONDS),
        ("files.md", r"pipe that does not stay silent for (\d+) s",
         lambda: files._PATIENCE),
        ("theory/steering.md", r"rests within ([\d.]+) mm",
         lambda: 1e3 * inspect.signature(rrrobot.plan).parameters["tolerance"].default[0]),
        ("theory/steering.md", r"mm and ([\d.]+)°",
         lambda: np.rad2deg(inspect.signature(rrrobot.plan).parameters["tolerance"].default[1])),
        ("errata.md", r"begins: ([\de.-]+) of the circular", spread_of_where_cycles_begin),
        ("tutorials/ten_lines.md", r"from ([\d.]+) to [\d.]+ of each mode", lambda: atlas.NEAR[0]),
        ("tutorials/ten_lines.md", r"from [\d.]+ to ([\d.]+) of each mode", lambda: atlas.NEAR[-1]),
        ("tutorials/ten_lines.md", r"differ by more than (\d) %", lambda: 100 * confirming.AGREE),
        ("tutorials/ten_lines.md", r"rounded by (\d) cm", lambda: 100 * edges.EDGE),
        ("tutorials/ten_lines.md", r"more than (\d+) degrees astray",
         lambda: np.rad2deg(story._STRAIGHT)),
        ("tutorials/ten_lines.md", r"damping ratio of ([\d.]+)", lambda: loss.RATIO),
        ("theory/limit_cycles.md", r"comes to in (\d+) periods", lambda: many.SETTLING),
        ("theory/limit_cycles.md", r"no multiplier beyond ([\d.]+)", lambda: many._SURE),
        ("errata.md", r"pivoting pitch [^|]*\| 0.96 s \| ([\d.]+) s undamped",
         lambda: pivoting_pitch().linear),
        ("errata.md", r"undamped, ([\d.]+) s with", lambda: pivoting_pitch().damped),
        ("reduction.md", r"by (\u2212[\d.]+) rad \(", net_yaw_of_a),
        ("reduction.md", r"rad \((\u2212[\d.]+)°\) a cycle", lambda: np.rad2deg(net_yaw_of_a())),
        ("files.md", r"viscous below ([\d.]+) rad/s", lambda: limits.CREEP),
        ("files.md", r"(\d+) attributes of", lambda: markup._MAX_ATTRIBUTES),
        ("files.md", r"nesting of (\d+)", lambda: markup._MAX_NESTING),
        ("files.md", r"masses above ([\de]+) kg", lambda: faults._LIMITS["mass"][0]),
        ("files.md", r"moments above ([\de]+) kg", lambda: faults._LIMITS["inertia"][0]),
        ("files.md", r"offsets above ([\de]+) m", lambda: faults._LIMITS["origin"][0]),
        ("files.md", r"phases beyond ([\de]+) rad", lambda: sinusoidal._LARGEST),
        ("files.md", r"more than ([\de]+) steps", lambda: effort.ENDLESS_STEPS),
        ("files.md", r"from ([\de]+) on a", lambda: effort.MANY_STEPS),
        ("files.md", r"stays silent is left after (\d+) s", lambda: files._PATIENCE),
        ("files.md", r"above (\d+) kB and", lambda: server._MOST_BYTES / 1024),
        ("files.md", r"keeps (\d+) connections", lambda: server.MOST_CONNECTIONS),
        ("gallery.md", r"as long as ([\d.]+) shell radii", lambda: motion.WEIGHT),
        ("reference/machines.md", r"is met to ([\de-]+) per metre", lambda: mechanism._CLOSED),
        ("robots.md", r"rocking is taken as ([\d.]+)\.", lambda: loss.RATIO),
        ("theory/travel.md", r"Above (\d+) % it has not", lambda: 100 * results.SETTLED),
        ("tutorials/sweeps.md", r"by more than (\d+) % from", lambda: 100 * results.SETTLED),
        ("tutorials/sweeps.md", r"runs for (\d+) cycles", lambda: counts.CYCLES),
        ("tutorials/sweeps.md", r"over the last (\d+)\.",
         lambda: counts.run_settings(None, None, 10)["counted"]),
        ("tutorials/sweeps.md", r"amplitude ([\d.]+) rad, freq", lambda: CIRCULAR.amplitude[0]),
        ("tutorials/sweeps.md", r"frequency (\d+) rad/s",
         lambda: CIRCULAR.angular_frequency[0]),
        ("tutorials/first_roll.md", r"radius ([\d.]+) m", lambda: TABLE_2.shell_radius),
        ("theory/frames.md", r"-r\)\$ \| ([\d.]+) kg", lambda: TABLE_2.battery_mass),
        ("theory/frames.md", r"\| ([\d.]+) kg each \| \| leg", lambda: TABLE_2.servo_mass),
        ("theory/frames.md", r"\| ([\d.]+) kg each \| with", lambda: TABLE_2.leg_mass),
        ("theory/frames.md", r"r = b = ([\d.]+)\$ m", lambda: TABLE_2.hip_offset),
        ("theory/frames.md", r"l = ([\d.]+)\$ m", lambda: TABLE_2.leg_length),
        ("theory/frames.md", r"which is \$(-[\d.]+)\$ kg m along",
         lambda: coefficients(RRROBOT, np.full((1, 2), np.pi / 2), np.zeros((1, 2)))[0, 2]),
        ("theory/small_gaits.md", r"cycles of ([\d.]+) and", lambda: travel.SMALL),
        ("theory/small_gaits.md", r"and ([\d.]+) rad by Richardson", lambda: 2 * travel.SMALL),
        ("theory/steering.md", r"gaits of ([\d.]+), [\d.]+ and", lambda: reachable._SHARES[0]),
        ("theory/steering.md", r"gaits of [\d.]+, ([\d.]+) and", lambda: reachable._SHARES[1]),
        ("theory/steering.md", r"and ([\d.]+) of the largest", lambda: reachable._SHARES[2]),
        ("extend/constraint.md", r"damping of ([\d.]+) on each", lambda: TABLE_2.damping),
    ],
)  # fmt: skip
def test_numbers_in_sentences_are_what_comes_out(page, sentence, value):
    """To the digits that are printed."""
    are_printed([value()], page, sentence)
