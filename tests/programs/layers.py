"""Scenes of random scripts in several layers: sublayers, references, payloads, edit targets."""

from __future__ import annotations

import random
from pathlib import Path

from tests.programs.blocks import Block


def in_layers(scene: list[Block], some: random.Random) -> tuple[list[Block], list[Block]]:
    """Return a scene on a stage of several layers, and what is done to these before each step of a loop."""
    stage, below = "omni.usd.get_context().get_stage()", Path(__file__).parent
    part, layer = f"{str(below / 'part.usda')!r}", f"{str(below / 'layer.usda')!r}"
    blocks = [Block(f"stage = {stage}")]
    has_layer = some.random() < 0.5
    if has_layer:
        blocks.append(Block(f"stage.GetRootLayer().subLayerPaths.append({layer})"))
    if some.random() < 0.5:
        blocks += [
            Block("edits = Sdf.Layer.CreateAnonymous('.usda')"),
            Block("stage.GetRootLayer().subLayerPaths.insert(0, edits.identifier)"),
            Block("stage.SetEditTarget(edits)"),
        ]
    elif some.random() < 0.3:
        blocks.append(Block("stage.SetEditTarget(stage.GetSessionLayer())"))
    if some.random() < 0.3:
        scene = [Block("with rep.new_layer():", scene)]
    after = [Block("part = stage.DefinePrim('/World/part', 'Xform')")]
    after += [
        Block(f"part.{some.choice(['GetReferences().AddReference', 'GetPayloads().AddPayload'])}({part})"),
        Block(f"UsdGeom.XformCommonAPI(part).SetTranslate(({some.uniform(-2, 2):.3f}, 2, 1))"),
    ]
    if some.random() < 0.4:
        after.append(Block("part.SetInstanceable(True)"))
    if some.random() < 0.4:
        after.append(Block("stage.SetEditTarget(stage.GetRootLayer())"))
    in_frames = [
        Block("if frame == 1:", [Block("UsdGeom.XformCommonAPI(part).SetTranslate((0, 2, random.random()))")]),
        Block("stage.SetEditTarget([stage.GetRootLayer(), stage.GetSessionLayer()][frame % 2])"),
        Block("if frame == 2:", [Block("part.GetReferences().ClearReferences()")]),
        Block(
            "if frame == 2:",
            [
                Block(
                    f"stage.MuteLayer({layer})" if has_layer else f"stage.GetRootLayer().subLayerPaths.append({layer})"
                )
            ],
        ),
    ]
    return blocks + scene + after, some.sample(in_frames, some.choice([0, 1, 2]))
