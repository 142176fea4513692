"""`rep.randomizer.scatter_2d` and `scatter_3d` in many worlds."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from pxr import Usd

from usdsdg.arguments.prims import prim_at
from usdsdg.errors import Unsupported
from usdsdg.graph.node import Node
from usdsdg.graph.worlds import in_worlds
from usdsdg.modify.posed_prims import PosedPrim
from usdsdg.randomizer.scatter import draws_of, prims_of, surface_in, volume_in
from usdsdg.scatter import surface, volume
from usdsdg.scatter.places_in_worlds import PlacesInWorlds
from usdsdg.scatter.positions import Region
from usdsdg.scatter.stage_bodies import Places, free_places
from usdsdg.stage.geometry.instancers import is_instancer, object_names
from usdsdg.stage.world_values import WorldValues


@in_worlds("OgnScatter2D")
def _on_surfaces_in_worlds(node: Node, executions: np.ndarray, values: WorldValues) -> None:
    surfaces = prims_of(node.inputs, "surfacePrims")
    _scatter(node, executions, values, surfaces, lambda places: surface_in(node, places), surface.COMPONENTS)


@in_worlds("OgnScatter3D")
def _in_volumes_in_worlds(node: Node, executions: np.ndarray, values: WorldValues) -> None:
    if node.inputs["vizSampledVoxels"]:
        raise Unsupported("sampled voxels cannot be shown in worlds")
    volumes = [prim for role in ("volumePrims", "volumeExclPrims") for prim in prims_of(node.inputs, role)]
    _scatter(node, executions, values, volumes, lambda places: volume_in(node, places), volume.COMPONENTS)


def _scatter(
    node: Node, executions: np.ndarray, values: WorldValues, bounding: Sequence[Usd.Prim],
    region_of: Callable[[Places], Region], components: int,
) -> None:  # fmt: skip
    """Set the positions that a node writes, world by world; `bounding` are the prims of which the region is made."""
    prims, inputs = [prim_at(path) for path in node.prims], node.inputs
    for prim in filter(is_instancer, prims):
        raise Unsupported(f"the point instances of {prim.GetPath()} cannot be scattered in worlds")
    if values.only_independent and (inputs.get("noCollPrims") or inputs["checkForCollisions"]):
        # Triangles are rounded about where their prim was. Drawing many frames only to be told so would take long.
        raise Unsupported("the collision test depends, in its rounding, on where prims were in the frame before")
    everywhere, names = PlacesInWorlds(values), object_names(prims)
    differs, obstacles = everywhere.differ(bounding), prims_of(inputs, "noCollPrims")
    positions, region = np.empty((len(executions), len(prims), 3)), None
    for world, execution in enumerate(executions.tolist()):
        places = everywhere.of(world)
        if region is None or differs:
            region = region_of(places)
        positions[world], _ = free_places(
            prims,
            region,
            draws_of(node, names, execution, components),
            obstacles=obstacles,
            avoid_each_other=inputs["checkForCollisions"],
            shapes=node.state.setdefault("shapes", {}),
            places=places,
        )
    for index, prim in enumerate(prims):
        PosedPrim(prim, values, node.describe()).set_world_position(positions[:, index])
