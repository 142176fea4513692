"""What differs between operating systems is in one module, and has a fallback."""

import ast
import errno
import gc
import os
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import pytest

import usdsdg
from usdsdg import operating_system
from usdsdg.stores.locks import FileLock, Locked, locked

PACKAGE = Path(usdsdg.__file__).parent
# Modules and functions that only some systems have.
MODULES = {"fcntl", "msvcrt", "resource", "pwd", "grp", "termios", "winreg", "syslog"}
FUNCTIONS = {
    *("fork", "kill", "killpg", "register_at_fork", "sched_getaffinity", "setsid", "getuid", "getpgid", "mkfifo"),
    *("statvfs", "sysconf", "getloadavg", "nice", "wait3", "wait4", "waitid", "pread", "pwrite", "chown"),
    *("sendfile", "posix_fallocate", "posix_fadvise", "O_BINARY", "O_DIRECTORY", "O_NOFOLLOW", "O_SYNC", "syncfs"),
}

SCRIPT = """
import omni.replicator.core as rep

with rep.new_layer():
    rep.create.cube(semantics=[("class", "cube")])
    product = rep.create.render_product(rep.create.camera(position=(0, 0, 5)), (64, 48))
    writer = rep.WriterRegistry.get("BasicWriter")
    writer.initialize(output_dir="out", rgb=True, bounding_box_2d_tight=True)
    writer.attach(product)
    with rep.trigger.on_frame(num_frames=2):
        pass
rep.orchestrator.run_until_complete()
"""


def _calls_of_some_systems(file: Path) -> list[str]:
    found = []
    for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            found += [each.name for each in node.names if each.name in MODULES]
        elif isinstance(node, ast.ImportFrom) and node.module in MODULES:
            found.append(node.module)
        elif isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name) and node.value.id == "os":
            found += [f"os.{node.attr}"] if node.attr in FUNCTIONS else []
        elif isinstance(node, ast.Constant) and isinstance(node.value, str) and node.value.startswith("/proc/"):
            found.append(node.value)
    return found


def test_only_one_module_names_calls_of_some_systems() -> None:
    found = {
        str(file.relative_to(PACKAGE.parent)): calls
        for package in ("usdsdg", "usdsdg_physics", "usdsdg_render")
        for file in sorted((PACKAGE.parent / package).rglob("*.py"))
        if (calls := _calls_of_some_systems(file))
    }
    assert set(found) == {"usdsdg/operating_system.py"}
    assert {"fcntl", "msvcrt", "resource", "os.kill", "os.register_at_fork"} <= set(found["usdsdg/operating_system.py"])


@pytest.mark.parametrize(("is_console", "obeys", "modes"), [(1, 1, [7]), (1, 0, [7]), (0, 1, [])])
def test_a_console_of_windows_is_asked_to_obey(monkeypatch, is_console, obeys, modes):
    asked = []

    def get(handle, mode):
        mode._obj.value = 3
        return is_console

    def put(handle, mode):
        asked.append(mode)
        return obeys

    console = SimpleNamespace(GetConsoleMode=get, SetConsoleMode=put)
    monkeypatch.setattr(operating_system, "IS_WINDOWS", True)
    monkeypatch.setattr(operating_system, "msvcrt", SimpleNamespace(get_osfhandle=lambda descriptor: 40 + descriptor))
    monkeypatch.setattr(operating_system.ctypes, "WinDLL", lambda name: console, raising=False)
    found = operating_system.obeys_terminal_sequences(SimpleNamespace(fileno=lambda: 2))
    assert (found, asked) == (bool(is_console and obeys), modes)


def test_the_command_runs_where_posix_calls_are_missing(tmp_path: Path) -> None:
    # As Windows has it: none of these modules, no forks, no affinity; msvcrt counts what is asked of it.
    windows = tmp_path / "windows"
    windows.mkdir()
    (windows / "msvcrt.py").write_text(
        "LK_LOCK, LK_NBLCK = 1, 2\nasked = []\n\ndef locking(*a):\n    asked.append(a)\n"
    )
    (tmp_path / "start.py").write_text(
        "import os, sys\n"
        "for name in ('fcntl', 'resource', 'pwd', 'grp', 'termios'):\n    sys.modules[name] = None\n"
        "import random, subprocess\n"  # which would take a module `msvcrt` for Windows
        "sys.path.insert(0, 'windows')\n"
        "del os.register_at_fork, os.sched_getaffinity\n"
        "from usdsdg import operating_system\n"
        "operating_system._syncfs = lambda: None\n"
        "from usdsdg.cli.program import main\n"
        "import msvcrt\n"
        "try:\n    main()\n"
        "finally:\n    assert msvcrt.asked, 'the dataset was not locked'\n"
    )
    (tmp_path / "script.py").write_text(SCRIPT)
    command = [sys.executable, "start.py", "run", "script.py", "-q"]
    environment = {**os.environ, "PYTHONPATH": str(PACKAGE.parent)}
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, env=environment)
    assert done.returncode == 0, done.stdout + done.stderr


def test_windows_is_asked_again_when_it_gives_up_waiting(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[tuple[int, int]] = []

    def locking(descriptor: int, mode: int, count: int) -> None:
        asked.append((mode, os.lseek(descriptor, 0, os.SEEK_CUR)))
        if len(asked) < 3:
            raise OSError(errno.EDEADLK, "tried ten times")

    monkeypatch.setattr(operating_system, "fcntl", None)
    monkeypatch.setattr(operating_system, "msvcrt", SimpleNamespace(LK_LOCK=1, LK_NBLCK=2, locking=locking))
    file = tmp_path / "lock"
    with locked(file):
        assert [mode for mode, _ in asked] == [1, 1, 1]
        assert all(place > 1 << 32 for _, place in asked), "bytes that are read are not locked"
    asked.clear()
    with pytest.raises(Locked):
        FileLock(file)
    FileLock(file, shared=True).release()


def test_processes_that_run_and_that_have_ended() -> None:
    child = subprocess.Popen([sys.executable, "-c", "import sys; sys.stdin.read()"], stdin=subprocess.PIPE)
    assert not operating_system.has_ended(child.pid)
    child.communicate(b"")
    assert operating_system.has_ended(child.pid)
    assert not operating_system.has_ended(1)  # of another user, perhaps: not for us to signal
    assert not operating_system.has_ended(1 << 80)


def test_memory_is_known_by_another_way(monkeypatch: pytest.MonkeyPatch) -> None:
    exact = operating_system.memory_of_process()["rss"]
    monkeypatch.setattr(operating_system, "Path", lambda _text: SimpleNamespace(exists=lambda: False))
    largest = operating_system.memory_of_process()["rss"]
    assert 0.5 * exact < largest


def test_processes_with_one_number_have_names_of_their_own():
    """As in containers that see the same folder, where each has a number of 1."""
    code = (
        "import os; os.getpid = lambda: 1\n"
        "from pathlib import Path; from usdsdg.stores import whole_file; import usdsdg.operating_system as system\n"
        "part = whole_file._part_of(Path('/tmp/x'), b'', False)\n"
        "print(system.process_name(), whole_file._unique())"
    )
    said = [subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True) for _ in range(2)]
    assert len({name for each in said for name in each.stdout.split()}) == 4


@pytest.mark.skipif(not hasattr(os, "fork"), reason="processes do not fork")
def test_a_fork_leaves_a_folder_that_is_removed_with_an_object(tmp_path):
    class Owner:
        pass

    owner = Owner()
    (folder := tmp_path / "a").mkdir()
    operating_system.removed_with(owner, folder)
    if (pid := os.fork()) == 0:
        del owner
        gc.collect()
        os._exit(0)
    os.waitpid(pid, 0)
    assert folder.is_dir()
    del owner
    gc.collect()
    assert not folder.exists()


LOCKS = """
import errno, resource, sys
from pathlib import Path
from usdsdg.stores.locks import FileLock

own, most = map(int, sys.argv[2:])
resource.setrlimit(resource.RLIMIT_NOFILE, (own, most))
locks = []
try:
    for number in range(300):
        locks.append(FileLock(Path(sys.argv[1]) / str(number)))
except OSError as error:
    assert error.errno == errno.EMFILE
others = [open("/dev/null") for _ in range(20)]
print(len(locks))
"""


@pytest.mark.skipif(operating_system.resource is None, reason="this system has no such limit")
@pytest.mark.parametrize(("own", "most", "fewest"), [(64, 1000, 300), (64, 128, 64), (1000, 1000, 300)])
def test_locks_of_many_folders_raise_the_limit_of_open_files_and_leave_some_to_others(tmp_path, own, most, fewest):
    command = [sys.executable, "-c", LOCKS, str(tmp_path), str(own), str(most)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=60)
    assert done.returncode == 0, done.stderr
    assert fewest <= int(done.stdout) <= min(300, most)
