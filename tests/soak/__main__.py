"""`python -m tests.soak NAME` runs one long check at its full count; without a name it lists them."""

import importlib
import sys

SOAKS = {
    "isaac_scripts": "Isaac Sim's Replicator scripts, from a checkout of isaac-sim/IsaacSim, each to its end",
    "isaac_label_tests": "Isaac Sim's own tests of labels, from a checkout of isaac-sim/IsaacSim, row by row",
    "spellings": "the object-based tutorial script in the spellings of Isaac Sim 4.2, 5.1 and 6.0: the same files",
    "label_faults": "every kind of label fault put into datasets: `usdsdg verify` finds all but one at most",
    "label_clean": "2,000 frames in every format, without a fault: `usdsdg verify` finds none",
    "formats": "200 cluttered frames in every dataset format, read and scored by the formats' own tools",
    "meshes": "mesh files in ten forms, whole, broken and mutated: each converted, rendered, or refused with a reason",
    "writing_threads": "every format over 200 frames, by threads beside rendering and one by one: the same files",
    "inputs": "1,000 mutated stages, textures, packages, configurations and graphs: no crash, hang or traceback",
    "cases": "all cases of the tests of which CI runs a sample",
    "kills": "runs that are killed, or whose disk is full, at random moments, and resumed: the same bytes",
    "processes": "up to 12 processes make one dataset, are ended at random moments and resumed: the same bytes",
    "damage": "60 kinds of damage to a dataset of 10,000 files: `usdsdg verify` names each file, and no other",
    "worlds": "300 random graphs: each world shows what the frame of its number shows",
    "programs": "100 random scripts in parts, by workers, resumed, with more threads or worlds: the same files",
    "ray": "actors of Ray, killed actors, and two nodes make the bytes of one process (needs `usdsdg[ray]`)",
    "stores": "object stores on servers that run here, Ceph where it is installed: promises, failures, absence",
    "long": "100,000 small label frames in episodes: time a frame, memory, and what the journal takes",
    "warmup": "`usdsdg warmup` in an empty cache; then scripts and jobs compile nothing more",
    "physics_calm": "drops, rebounds, stacks, overlaps, piles and the object-based scene, each with its limit",
}


def main() -> int:
    if len(sys.argv) < 2 or sys.argv[1] not in SOAKS:
        print("python -m tests.soak NAME [OPTIONS]\n")
        for name, what in SOAKS.items():
            print(f"  {name}: {what}")
        return 2
    name = sys.argv.pop(1)
    return importlib.import_module(f"tests.soak.{name}").main()


if __name__ == "__main__":
    sys.exit(main())
