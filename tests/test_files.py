"""Files are written whole or not at all."""

import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

import rrrobot as rr
from rrrobot import files
from rrrobot.files import check_writable, make_folder, write_whole


def test_write_and_overwrite(tmp_path):
    target = tmp_path / "a.txt"
    assert write_whole(target, b"one") == target
    assert write_whole(str(target), b"second") == target
    assert target.read_bytes() == b"second"
    assert os.listdir(tmp_path) == ["a.txt"]


def test_mode_is_that_of_any_new_file(tmp_path):
    plain = tmp_path / "plain"
    plain.touch()
    write_whole(tmp_path / "ours", b"")
    assert (tmp_path / "ours").stat().st_mode == plain.stat().st_mode


@pytest.mark.parametrize("call", ["replace", "fsync", "chmod"])
@pytest.mark.parametrize("failure", [OSError(28, "No space left on device"), KeyboardInterrupt()])
def test_a_failure_leaves_the_old_file_and_no_litter(tmp_path, monkeypatch, call, failure):
    target = tmp_path / "a.txt"
    target.write_bytes(b"old")

    def fail(*_):
        raise failure

    monkeypatch.setattr(os, call, fail)
    expected = rr.OutputError if isinstance(failure, OSError) else KeyboardInterrupt
    with pytest.raises(expected) as caught:
        write_whole(target, b"new")
    if isinstance(failure, OSError):
        assert str(caught.value) == f"cannot write {str(target)!r}: No space left on device."
        assert isinstance(caught.value, OSError)
    assert os.listdir(tmp_path) == ["a.txt"]
    assert target.read_bytes() == b"old"


def test_no_folder(tmp_path):
    for write in (check_writable, lambda path: write_whole(path, b"")):
        with pytest.raises(rr.OutputError, match="there is no folder"):
            write(tmp_path / "missing" / "a.txt")
    assert os.listdir(tmp_path) == []


def test_a_folder_is_no_file(tmp_path):
    with pytest.raises(rr.OutputError, match="it is a folder"):
        check_writable(tmp_path)
    with pytest.raises(rr.OutputError, match="it is a folder"):
        write_whole("", b"")


def test_a_device_is_not_replaced_by_a_file(tmp_path):
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    with pytest.raises(rr.OutputError, match="device or a pipe"):
        write_whole(pipe, b"")
    assert pipe.is_fifo()
    with pytest.raises(rr.OutputError, match="device or a pipe"):
        check_writable(os.devnull)


def test_a_file_is_no_folder(tmp_path):
    (tmp_path / "a.txt").touch()
    with pytest.raises(rr.OutputError, match="there is no folder"):
        write_whole(tmp_path / "a.txt" / "b.txt", b"")


def test_folder_that_may_not_be_written(tmp_path, monkeypatch):
    monkeypatch.setattr(os, "access", lambda path, mode: Path(path) != tmp_path)
    with pytest.raises(rr.OutputError, match="not writable"):
        check_writable(tmp_path / "a.txt")


@pytest.mark.parametrize("name", ["a\0b", "x" * 300])
def test_impossible_names(tmp_path, name):
    for write in (check_writable, lambda path: write_whole(path, b"")):
        with pytest.raises(rr.OutputError, match="cannot write"):
            write(tmp_path / name)
    assert os.listdir(tmp_path) == []


def test_the_longest_name(tmp_path):
    write_whole(tmp_path / ("x" * 255), b"1")
    assert os.listdir(tmp_path) == ["x" * 255]


def test_check_writes_nothing(tmp_path):
    assert check_writable(str(tmp_path / "a.txt")) == tmp_path / "a.txt"
    assert os.listdir(tmp_path) == []


def test_a_folder_is_made_with_its_parents(tmp_path):
    folder = tmp_path / "a" / "b"
    assert make_folder(folder) == make_folder(str(folder)) == folder and folder.is_dir()
    (tmp_path / "file").touch()
    for bad in (tmp_path / "file", tmp_path / "file" / "below", "nul\0", ""):
        with pytest.raises(rr.OutputError, match=r"cannot make (the|a) folder"):
            make_folder(bad)


def test_what_a_killed_process_left_behind_is_removed(tmp_path):
    code = (
        "import os, signal\nfrom rrrobot import files\n"
        "os.replace = lambda *_: os.kill(os.getpid(), signal.SIGKILL)\n"
        f"files.write_whole({str(tmp_path / 'a.txt')!r}, b'half')\n"
    )
    killed = subprocess.run([sys.executable, "-c", code], check=False)
    assert killed.returncode == -signal.SIGKILL
    (litter,) = tmp_path.iterdir()
    alive = tmp_path / f"{litter.name.rpartition('.')[0].rpartition('.')[0]}.{os.getpid()}.x"
    alive.write_bytes(b"of a run that goes on")
    write_whole(tmp_path / "b.txt", b"whole")
    assert sorted(p.name for p in tmp_path.iterdir()) == sorted((alive.name, "b.txt"))


def test_a_pipe_that_says_nothing_is_left(tmp_path, monkeypatch):
    monkeypatch.setattr(files, "_PATIENCE", 0.05)
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    end = os.open(pipe, os.O_RDWR)
    try:
        with pytest.raises(TimeoutError, match="nothing came from it"):
            files.read_bytes(pipe)
        os.write(end, b"some")
        monkeypatch.setattr(files, "_LONGEST", 0.0)
        with pytest.raises(TimeoutError, match="did not end"):
            files.read_bytes(pipe)
    finally:
        os.close(end)
