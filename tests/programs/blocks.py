"""Scripts as blocks of lines, which can be left out one by one."""

from __future__ import annotations

from dataclasses import dataclass, field

HEAD = """\
import asyncio
import os
import random
import sys

import numpy as np
import omni.kit.app
import omni.replicator.core as rep
import omni.timeline
import omni.usd
from pxr import Gf, Sdf, UsdGeom

OUT = os.path.abspath(sys.argv[1])
uniform, choice, sequence = rep.distribution.uniform, rep.distribution.choice, rep.distribution.sequence
"""

OWN_WRITER = """\
class OwnWriter(rep.Writer):
    def __init__(self):
        self._frame_id = 0
        self.annotators = ["bounding_box_2d_tight", "camera_params"]

    def initialize(self, output_dir):
        self.backend = rep.BackendDispatch({"paths": {"out_dir": output_dir}})

    def write(self, data):
        import json
        found = {}
        for name in sorted(data):
            if name.startswith("bounding_box_2d_tight"):
                value = data[name]["data"] if isinstance(data[name], dict) else data[name]
                found[name] = [list(map(float, [row[0], row[1], row[2], row[3], row[4]])) for row in value]
        self.backend.write_blob(f"own_{self._frame_id:03}.json", json.dumps(found).encode())
        self._frame_id += 1


rep.WriterRegistry.register(OwnWriter)"""


@dataclass
class Block:
    """A line of a script, and the lines below it that are further in."""

    line: str
    below: list[Block] = field(default_factory=list)

    def lines(self, indent: str = "") -> list[str]:
        """Return the text, line by line; a block that has lost what was below it says `pass`."""
        inner = [text for block in self.below for text in block.lines(indent + "    ")]
        if self.line.endswith(":") and not inner:
            inner = [indent + "    pass"]
        return [*(indent + text for text in self.line.split("\n")), *inner]


@dataclass
class Script:
    """A script as blocks, and what of it decides how it can be run."""

    blocks: list[Block]
    features: set[str] = field(default_factory=set)

    @property
    def text(self) -> str:
        """The Python source."""
        return HEAD + "\n".join(text for block in self.blocks for text in block.lines()) + "\n"
