"""Bad URDFs: each is one clear UrdfError, and none stops the process."""

import os
import random
import re
import subprocess
import sys
import time
import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import rrrobot as rr
from rrrobot.robot import markup
from tests.strategies import examples

# Bodies here are cubes of 1 kg m^2 for 1 kg.
pytestmark = pytest.mark.filterwarnings("ignore::rrrobot.errors.UrdfWarning")
SHELL = rr.Sphere(0.12)
GOOD = rr.rrrobot_urdf()
INERTIA = '<inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/>'
BODY = f'<inertial><mass value="1"/>{INERTIA}</inertial>'
MOVES = '<axis xyz="0 0 1"/><limit effort="1" velocity="1" lower="-1" upper="1"/>'


def robot(*parts: str) -> str:
    return f'<robot name="r">{"".join(parts)}</robot>'


def link(name: str, content: str = BODY) -> str:
    return f'<link name="{name}">{content}</link>'


def joint(name: str, parent: str, child: str, kind: str = "revolute", content: str = MOVES) -> str:
    ends = f'<parent link="{parent}"/><child link="{child}"/>'
    return f'<joint name="{name}" type="{kind}">{ends}{content}</joint>'


def chain(n: int, kind: str = "continuous") -> str:
    links = [link(f"l{i}") for i in range(n)]
    return robot(*links, *(joint(f"j{i}", f"l{i - 1}", f"l{i}", kind) for i in range(1, n)))


def star(n: int) -> str:
    links = [link(f"l{i}") for i in range(n)]
    return robot(*links, *(joint(f"j{i}", "l0", f"l{i}") for i in range(1, n)))


PAIR = link("a"), link("b")
LAUGHS = "".join(f'<!ENTITY l{i} "{f"&l{i - 1};" * 10}">' for i in range(1, 12))

BAD = {
    # XML
    "cut off": (GOOD[:700], "not well-formed XML"),
    "mismatched tag": ("<robot name='r'><link></robot>", "mismatched tag: line 1"),
    "two documents": (robot(*PAIR) * 2, "junk after document element"),
    "a null": (robot(link("a\0")), "not well-formed XML"),
    "a surrogate": (robot(link("\ud800")), "not well-formed XML"),
    "undefined entity": (robot(link("&a;")), "undefined entity"),
    "nested too deep": (robot(link("a"), "<z>" * 100_000, "</z>" * 100_000), "<z> is nested 101"),
    # hostile
    "billion laughs": (
        f'<!DOCTYPE robot [<!ENTITY l0 "ha">{LAUGHS}]>{robot(link("&l11;"))}', "DOCTYPE"),
    "external entity": (
        f'<!DOCTYPE robot [<!ENTITY x SYSTEM "file:///etc/hostname">]>{robot(link("&x;"))}',
        "DOCTYPE: entities are not allowed"),
    "external DTD": (f'<!DOCTYPE robot SYSTEM "file:///dev/zero">{robot(link("a"))}', "DOCTYPE"),
    # no robot
    "another format": ('<sdf version="1.6"><model name="m"/></sdf>', "is an SDF file, not a URDF"),
    "no name": (f"<robot>{link('a')}</robot>", "<robot> has no name"),
    "no link": (robot(), "the URDF has no <link>"),
    "links elsewhere": (robot("<model>", *PAIR, "</model>"), "the URDF has no <link>"),
    "no mass": (robot(link("a", "")), "total mass is 0.0 kg: it must be above zero"),
    # names
    "double link": (robot(link("a"), link("a")), "<link> names must be unique and not empty: a"),
    "double joint": (
        robot(*PAIR, link("c"), joint("j", "a", "b"), joint("j", "b", "c")),
        "<joint> names must be unique and not empty: j"),
    "link without a name": (robot("<link/>"), "<link> names must be unique"),
    "joint with an empty name": (robot(*PAIR, joint("", "a", "b")), "<joint> names must be"),
    "joint named universe": (robot(*PAIR, joint("universe", "a", "b")), "named 'universe'"),
    "joint named root_joint": (robot(*PAIR, joint("root_joint", "a", "b")), "named 'root_joint'"),
    "link named as our frame": (robot(link("rrrobot_shell")), "the name 'rrrobot_shell'"),
    # tree
    "two roots": (robot(*PAIR), "2 root links (a, b)"),
    "a loop": (
        robot(*PAIR, joint("i", "a", "b"), joint("j", "b", "a")), "0 root links (a loop)"),
    "a loop aside": (
        robot(*PAIR, link("c"), joint("i", "b", "c"), joint("j", "c", "b")), "hangs in a loop"),
    "its own child": (robot(*PAIR, joint("j", "b", "b")), "link 'b' hangs in a loop"),
    "two parents": (
        robot(*PAIR, link("c"), joint("i", "a", "b"), joint("j", "a", "c"), joint("k", "b", "c")),
        "link 'c' is the child of the joints 'j' and 'k'"),
    "unknown child": (
        robot(*PAIR, joint("j", "a", "c")), "joint 'j' has the child link 'c', which"),
    "unknown parent": (robot(*PAIR, joint("j", "c", "b")), "Its links are: a, b"),
    "no child": (robot(*PAIR, '<joint name="j" type="fixed"/>'), "parent link None"),
    "two children": (
        robot(*PAIR, joint("j", "a", "b", "fixed", '<child link="a"/>')), "2 <child> elements"),
    "endless chain": (chain(400), "a chain of 251 links: the limit is 250"),
    "too many links": (star(1001), "1001 <link> elements: the limit is 1000"),
    "too many joints": (star(201), "200 moving joints: the limit is 150; name fewer legs"),
    # joints
    "no type": (robot(*PAIR, '<joint name="j"><parent link="a"/><child link="b"/></joint>'),
                "joint 'j' has the type None: it must be one of revolute, continuous"),
    "unknown type": (robot(*PAIR, joint("j", "a", "b", "hinge")), "the type 'hinge'"),
    "no limits": (robot(*PAIR, joint("j", "a", "b", content="")), "'j' is revolute and has no lim"),
    "floating": (robot(*PAIR, joint("j", "a", "b", "floating")), "'j' has 6 degrees of freedom"),
    "planar": (robot(*PAIR, joint("j", "a", "b", "planar")), "'j' has 3 degrees of freedom"),
    "zero axis": (robot(*PAIR, joint("j", "a", "b", content=MOVES.replace("0 0 1", "0 0 0"))),
                  "<axis xyz='0 0 0'> of joint 'j' is no direction"),
    "vanishing axis": (
        robot(*PAIR, joint("j", "a", "b", content=MOVES.replace("0 0 1", "1e-200 0 0"))),
        "is no direction"),
    "axis without xyz": (
        robot(*PAIR, joint("j", "a", "b", "continuous", "<axis/>")), "<axis> of joint 'j' has no"),
    "limit without effort": (
        robot(*PAIR, joint("j", "a", "b", content='<limit velocity="1"/>')), "has no effort"),
    # inertia
    "inertial without mass": (robot(link("a", "<inertial/>")), "'a' has no <mass>: add one"),
    "inertia without ixy": (
        robot(link("a", BODY.replace('ixy="0"', ""))), "<inertia> of link 'a' has no ixy"),
    "negative through products": (
        robot(link("a", BODY.replace('ixy="0"', 'ixy="3"'))), "principal moment -2 kg m^2"),
    "too large": (
        robot(*PAIR, joint("j", "a", "b", content=f'<origin xyz="1e200 0 0"/>{MOVES}')),
        "<origin> of joint 'j' is too large: the limit is 100000 m"),
    "negative within rounding, but all there is": (
        robot(link("a", BODY.replace('mass value="1"', 'mass value="1e-9"')
                            .replace('ixx="1"', 'ixx="-5e-7"').replace('"1"', '"1e-9"'))),
        "mass matrix is not positive"),
}  # fmt: skip


@pytest.mark.parametrize("name", BAD)
def test_bad_text(name):
    text, says = BAD[name]
    began = time.perf_counter()
    with pytest.raises(rr.UrdfError) as caught:
        rr.Robot.from_urdf(text, shell=SHELL)
    assert time.perf_counter() - began < 5.0
    message = str(caught.value)
    assert says in message
    assert isinstance(caught.value, ValueError)
    assert message.endswith(".")
    assert len(message) < 400
    assert caught.value.__cause__ is None


NUMBERS = [
    ("mass", "value", "<mass value={!r}> of link 'a'"),
    ("inertia", "iyy", "<inertia iyy={!r}> of link 'a'"),
    ("inertia", "ixz", "<inertia ixz={!r}> of link 'a'"),
]
WRONG = ["nan", "NaN", "inf", "-inf", "1e999", "one", "0x10", "1,5", "1_0", "\u0661", "", " ",
         "1 2"]  # fmt: skip


@pytest.mark.parametrize("value", WRONG)
@pytest.mark.parametrize(("tag", "attribute", "where"), NUMBERS)
def test_bad_numbers(tag, attribute, where, value):
    body = re.sub(rf'(<{tag}[^>]*{attribute}=)"[^"]*"', rf'\1"{value}"', BODY)
    assert body != BODY
    with pytest.raises(rr.UrdfError) as caught:
        rr.Robot.from_urdf(robot(link("a", body)), shell=SHELL)
    assert str(caught.value).startswith(where.format(value))


@pytest.mark.parametrize("value", ["1 2", "1 2 3 4", "1 2 nan", "a b c", "", "1;2;3", "1,,2"])
@pytest.mark.parametrize("attribute", ["xyz", "rpy"])
@pytest.mark.parametrize("owner", ["visual", "collision", "inertial", "joint"])
def test_bad_origins(owner, attribute, value):
    origin = f'<origin {attribute}="{value}"/>'
    shape = '<geometry><box size="1 1 1"/></geometry>'
    parts = {
        "visual": (link("a", f"{BODY}<visual>{origin}{shape}</visual>"),),
        "collision": (link("a", f"{BODY}<collision>{origin}{shape}</collision>"),),
        "inertial": (link("a", BODY.replace("<mass", f"{origin}<mass")),),
        "joint": (*PAIR, joint("j", "a", "b", content=origin + MOVES)),
    }[owner]
    with pytest.raises(rr.UrdfError) as caught:
        rr.Robot.from_urdf(robot(*parts), shell=SHELL)
    named = "joint 'j'" if owner == "joint" else "link 'a'"
    assert str(caught.value).startswith(f"<origin {attribute}={value!r}> of {named}")


@pytest.mark.parametrize("value", ["-1", "-1e-300"])
def test_negative_mass(value):
    with pytest.raises(rr.UrdfError, match=f"<mass value='{value}'> of link 'a' must not be neg"):
        rr.Robot.from_urdf(robot(link("a", BODY.replace('"1"', f'"{value}"', 1))), shell=SHELL)


def test_negative_inertia_but_for_rounding():
    """Exporters print moments such as -5e-20; those are no mistake."""
    rr.Robot.from_urdf(robot(link("a", BODY.replace('ixx="1"', 'ixx="-5e-20"'))), shell=SHELL)
    with pytest.raises(rr.UrdfError, match=r"link 'a' has the principal moment -0\.001 kg"):
        rr.Robot.from_urdf(robot(link("a", BODY.replace('ixx="1"', 'ixx="-0.001"'))), shell=SHELL)


def test_fixed_joints_may_have_no_direction():
    """Many robots give a fixed joint the axis 0 0 0."""
    text = robot(*PAIR, joint("j", "a", "b", "fixed", '<axis xyz="0 0 0"/>'))
    assert rr.Robot.from_urdf(text, shell=SHELL).legs == ()


@pytest.mark.slow
def test_largest_robots_within_the_limits_are_read():
    assert rr.Robot.from_urdf(chain(250, "fixed"), shell=SHELL).n_legs == 0
    assert rr.Robot.from_urdf(chain(101), shell=SHELL).n_legs == 100
    assert rr.Robot.from_urdf(star(1000), shell=SHELL, legs=("j1", "j2")).n_legs == 2


# Files


def refused(path: Path, says: str) -> None:
    for source in (path, str(path)):
        with pytest.raises(rr.UrdfError) as caught:
            rr.Robot.from_urdf(source, shell=SHELL)
        assert says in str(caught.value)
        assert str(path) in str(caught.value)


def test_missing_file(tmp_path):
    refused(tmp_path / "none.urdf", "there is no URDF file")


def test_directory(tmp_path):
    refused(tmp_path, "cannot be read")


def test_empty_path():
    with pytest.raises(rr.UrdfError, match="cannot be read"):
        rr.Robot.from_urdf("", shell=SHELL)


@pytest.mark.parametrize("name", ["a\0b", "x" * 300])
def test_impossible_names(name):
    with pytest.raises(rr.UrdfError, match="cannot be read"):
        rr.Robot.from_urdf(name, shell=SHELL)


@pytest.mark.parametrize(
    ("content", "says"),
    [
        (b"", "not well-formed XML"),
        (b"\n\n", "not well-formed XML"),
        (b"name: robot\nlinks: []\n", "not well-formed XML"),
        (np.random.default_rng(0).bytes(5000), "is not UTF-8 text"),
        (b"\x7fELF" + bytes(2000), "not well-formed XML"),
        (GOOD.replace("shell", "Hülle").encode("latin-1"), "is not UTF-8 text"),
        (GOOD.encode("utf-16"), "is not UTF-8 text"),
        (robot().encode(), "the URDF has no <link>"),
        (BAD["billion laughs"][0].encode(), "DOCTYPE"),
        (("\ufeff" + BAD["billion laughs"][0]).encode(), "DOCTYPE"),
    ],
    ids=["empty", "blank", "text", "garbage", "binary", "latin-1", "utf-16", "robot", "laughs",
         "laughs after a mark"],
)  # fmt: skip
def test_bad_files(tmp_path, content, says):
    path = tmp_path / "bad.urdf"
    path.write_bytes(content)
    refused(path, says)


def test_huge_file(tmp_path, monkeypatch):
    monkeypatch.setattr(markup, "MAX_BYTES", 10_000)
    path = tmp_path / "huge.urdf"
    path.write_text(GOOD + " " * 10_000)
    refused(path, "more than 10000 bytes: that is the limit")
    with pytest.raises(rr.UrdfError, match="more than 10000 bytes"):
        rr.robot.reduced_urdf(GOOD + " " * 10_000, "yaw")
    path.write_text(GOOD)
    rr.Robot.from_urdf(path, shell=SHELL)


def test_endless_file_is_read_to_the_limit_only(monkeypatch):
    monkeypatch.setattr(markup, "MAX_BYTES", 10_000)
    endless = Path("/dev/zero")
    if not endless.exists():
        pytest.skip("no such device here")
    refused(endless, "more than 10000 bytes")


# What stops the process in Pinocchio's own parser, in a process of its own.


@pytest.mark.slow
def test_chain_that_overflows_the_stack_of_the_parser():
    """Without the limit, 30,000 links in a chain end the process with a segmentation fault."""
    script = (
        "import rrrobot as rr\n"
        "from tests.test_urdf_bad import chain\n"
        "try:\n"
        "    rr.Robot.from_urdf(chain(30_000, 'fixed'), shell=rr.Sphere(0.1))\n"
        "except rr.UrdfError as error:\n"
        "    print(error)\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, timeout=60,
        cwd=Path(__file__).parent.parent,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert "the limit is 1000" in done.stdout


# Mutations

VALUES = ["", "nan", "-1", "0", "1e308", "1e-400", "1_0", "abc", "0 0 0", "1 0 0", "fixed",
          "continuous", "floating", "planar", "prismatic", "shell", "battery", "leg_1",
          "leg_1_link", "universe", "root_joint", "world", "\u0661", "a b", "x" * 3000, "2.0",
          "%s%n", "package://a/b.stl", "1 2 3 4", " 1 "]  # fmt: skip
TAGS = ["link", "joint", "inertial", "mass", "inertia", "origin", "axis", "limit", "mimic",
        "dynamics", "visual", "collision", "geometry", "mesh", "sphere", "material", "color",
        "safety_controller", "calibration", "parent", "child", "gazebo"]  # fmt: skip
ATTRIBUTES = ["name", "type", "xyz", "rpy", "value", "link", "joint", "multiplier", "lower",
              "effort", "velocity", "ixx", "izz", "radius", "filename", "rgba", "damping",
              "version", "quat_xyzw"]  # fmt: skip
CHUNKS = ["<", ">", "/>", '"', "=", "&", "&#0;", "&#10;", "]]>", "<!--", "-->", "<![CDATA[",
          "<?xml version='1.0'?>", "<link/>", "<joint/>", "<robot>", "é", *VALUES]  # fmt: skip


def read_or_refuse(text: str) -> bool:
    """Whether the robot is read; any exception but the package's own fails the test."""
    try:
        read = rr.Robot.from_urdf(text, shell=SHELL)
    except rr.RRRobotError as error:
        assert str(error)
        return False
    assert np.isfinite(read.mass)
    assert read.mass > 0
    names = set(read.model.names[2:])
    assert names == set(read.legs)
    assert len(names) == len(read.legs)
    assert read.shell_link in [e.get("name") for e in ET.fromstring(text).findall("link")]
    return True


def mutated_text(rng: random.Random) -> str:
    text = GOOD
    for _ in range(rng.choice((1, 1, 2, 4))):
        start = rng.randrange(len(text))
        stop = min(len(text), start + rng.choice((0, 1, 3, 20, 200)))
        text = text[:start] + rng.choice((*CHUNKS, "", "", "")) + text[stop:]
    return text if text.lstrip().startswith("<") else "<" + text


def mutated_tree(rng: random.Random) -> str:
    tree = ET.fromstring(GOOD)
    for _ in range(rng.choice((1, 1, 2, 4))):
        elements = list(tree.iter())
        one = rng.choice(elements)
        kind = rng.randrange(6)
        if kind == 0 and one.attrib:
            one.set(rng.choice(list(one.attrib)), rng.choice(VALUES))
        elif kind == 1 and one.attrib:
            del one.attrib[rng.choice(list(one.attrib))]
        elif kind == 2:
            one.set(rng.choice(ATTRIBUTES), rng.choice(VALUES))
        elif kind == 3:
            attributes = {rng.choice(ATTRIBUTES): rng.choice(VALUES) for _ in range(3)}
            one.insert(0, ET.Element(rng.choice(TAGS), attributes))
        elif kind == 4 and len(one):
            one.remove(rng.choice(list(one)))
        elif kind == 5:
            copy = ET.fromstring(ET.tostring(one))
            rng.choice(elements).append(copy)
    return ET.tostring(tree, encoding="unicode")


@pytest.mark.parametrize(
    ("mutate", "least"),
    [(mutated_text, 10), pytest.param(mutated_tree, 60, marks=pytest.mark.slow)],
)
def test_four_hundred_mutations_are_read_or_refused(capfd, mutate, least):
    accepted = sum(read_or_refuse(mutate(random.Random(seed))) for seed in range(400))
    capfd.readouterr()
    assert least < accepted < 390


@given(
    cut=st.tuples(st.integers(0, len(GOOD)), st.integers(0, 60)),
    chunk=st.one_of(st.sampled_from(CHUNKS), st.text(max_size=12)),
)
@examples(150)
def test_any_chunk_anywhere_is_read_or_refused(cut, chunk):
    start, length = cut
    text = GOOD[:start] + chunk + GOOD[start + length :]
    read_or_refuse(text if text.lstrip().startswith("<") else "<" + text)


@given(st.one_of(st.text(max_size=40), st.binary(max_size=40)))
@examples(50)
def test_any_file_content(tmp_path_factory, content):
    path = tmp_path_factory.getbasetemp() / "any.urdf"
    path.write_bytes(content if isinstance(content, bytes) else content.encode("utf-8", "replace"))
    with pytest.raises(rr.UrdfError, match=re.escape(os.fspath(path))):
        rr.Robot.from_urdf(path, shell=SHELL)
