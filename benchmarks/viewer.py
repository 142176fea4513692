"""`usdsdg view`: seconds to the first picture, pictures a second while orbiting, and memory over many steps.

    python -m benchmarks.viewer [--steps 2000] [--size 640 480] [--mode classes] [--scene FILE.usd] [--cores 2]
    python -m benchmarks.viewer --minutes 60 --rate 4      # memory over an hour, at a rate that leaves the machine free

The command runs in a process of its own; this one is the page: it asks for a turn, waits for the picture, and answers.
"""

from __future__ import annotations

import argparse
import itertools
import json
import os
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from urllib.parse import urlsplit

from websockets.sync.client import ClientConnection, connect

from benchmarks import report

REPOSITORY = Path(__file__).parents[1]
TARGETS = {"first": 5.0, "rate": 10.0}
SCENE = """
import sys
import usdsdg as rep
from usdsdg.session.stage_context import save_stage

rep.create.cube(position=(0, 0, -0.5), scale=(30, 30, 1))
for number in range(337):
    shape = (rep.create.cube, rep.create.sphere, rep.create.cylinder, rep.create.cone)[number % 4]
    place = (number % 19 - 9, number // 19 - 9, 0.5 + number % 3)
    shape(position=place, scale=0.6, semantics=[("class", shape.__name__)])
rep.create.light(light_type="Dome", intensity=800)
save_stage(sys.argv[1])
"""


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--steps", type=int, default=2000, help="of the orbit whose memory is measured")
    parser.add_argument("--minutes", type=float, help="of the orbit, in place of --steps")
    parser.add_argument("--rate", type=float, default=1e9, help="pictures a second at most")
    parser.add_argument("--size", type=int, nargs=2, default=(640, 480))
    parser.add_argument("--mode", default="classes")
    parser.add_argument("--scene", type=Path, help="default: 337 labeled objects")
    parser.add_argument("--cores", type=int, default=2)
    parser.add_argument("--device", default="cpu")
    arguments = parser.parse_args()
    report.begin()
    with tempfile.TemporaryDirectory() as folder:
        scene = arguments.scene or Path(folder) / "scene.usdc"
        if arguments.scene is None:
            script = Path(folder) / "scene.py"
            script.write_text(SCENE)
            subprocess.run([*usdsdg(), "run", "-q", str(script), str(scene)], check=True, env=environment())
        measure(scene, arguments)


def measure(scene: Path, arguments: argparse.Namespace) -> None:
    started = time.perf_counter()
    command = [*usdsdg(), "view", "-q", "--device", arguments.device, str(scene)]
    process = subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True, env=environment(),
        preexec_fn=lambda: os.sched_setaffinity(0, sorted(os.sched_getaffinity(0))[: arguments.cores]),
    )  # fmt: skip
    try:
        assert process.stdout is not None
        address = urlsplit(process.stdout.readline().strip())
        with connect(
            f"ws://{address.netloc}{address.path}socket", origin=f"http://{address.netloc}", proxy=None, max_size=None
        ) as page:
            ask(page, do="size", width=arguments.size[0], height=arguments.size[1])
            picture(page)
            seconds = time.perf_counter() - started
            report.row(
                "first picture", f"{seconds:.1f} s, {cpu(process.pid):.1f} CPU-s", target=f"{TARGETS['first']:g} s"
            )
            ask(page, do="mode", name=arguments.mode)
            orbit(page, process.pid, arguments)
    finally:
        process.terminate()
        process.wait(120)


def orbit(page: ClientConnection, pid: int, arguments: argparse.Namespace) -> None:
    walls: list[float] = []
    mebibytes: list[float] = []
    said = 0.0  # minutes after which memory is printed next
    while picture(page)["mode"] != arguments.mode:
        pass
    before, started = cpu(pid), time.perf_counter()
    for step in range(arguments.steps) if arguments.minutes is None else itertools.count():
        minutes = (time.perf_counter() - started) / 60
        if arguments.minutes is not None and minutes > arguments.minutes:
            break
        begun = time.perf_counter()
        ask(page, do="turn", by=[0.013, 0.004 if step % 200 < 100 else -0.004])
        picture(page)
        walls.append(time.perf_counter() - begun)
        if step % max(arguments.steps // 20, 1) == 0:
            mebibytes.append(resident(pid))
        if arguments.minutes is not None and minutes > said:
            said += 5
            print(f"after {minutes:.0f} minutes and {step} pictures: {resident(pid):.1f} MiB", flush=True)
        time.sleep(max(0.0, 1 / arguments.rate - walls[-1]))
    rate = 1.0 / statistics.median(walls)
    each = 1000 * (cpu(pid) - before) / len(walls)
    what = f"{arguments.mode}, {arguments.size[0]}x{arguments.size[1]}"
    report.row(what, f"{rate:.1f} pictures/s, {each:.0f} CPU-ms each", target=f"{TARGETS['rate']:g} pictures/s")
    first, last, most = mebibytes[len(mebibytes) // 4], resident(pid), max(mebibytes)
    what = f"{len(walls)} steps" if arguments.minutes is None else f"{arguments.minutes:g} minutes, {len(walls)} steps"
    report.row(f"memory, {what}", f"{first:.1f} to {last:.1f} MiB", target=f"flat; most {most:.1f} MiB")


def ask(page: ClientConnection, **wish: object) -> None:
    page.send(json.dumps(wish))


def picture(page: ClientConnection) -> dict:
    """Return the header of the next large picture, and answer it."""
    while True:
        message = page.recv(timeout=600)
        if isinstance(message, str):
            continue
        ask(page, do="shown")
        header = json.loads(message[4 : 4 + int.from_bytes(message[:4], "big")])
        if header["kind"] == "view":
            return header


def cpu(pid: int) -> float:
    """CPU seconds of a process so far."""
    fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def resident(pid: int) -> float:
    """Return the resident memory of a process [MiB]."""
    lines = Path(f"/proc/{pid}/status").read_text().splitlines()
    return int(next(line for line in lines if line.startswith("VmRSS")).split()[1]) / 1024


def usdsdg() -> list[str]:
    return [sys.executable, "-m", "usdsdg"]


def environment() -> dict[str, str]:
    return {**os.environ, "PYTHONPATH": str(REPOSITORY)}


if __name__ == "__main__":
    main()
