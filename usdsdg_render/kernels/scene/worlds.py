"""Many worlds of one scene: the tables as rays in one of them see it."""

import warp as wp

from usdsdg_render.scene.structs import Light, SceneTables


@wp.func
def in_world(tables: SceneTables, index: int):
    """Return the tables with what a world has of its own; a scene that is not divided into worlds stays as it is."""
    if tables.worlds.shape[0] > 0:
        world = tables.worlds[index]
        tables.first_instance = world.first_instance
        tables.tlas.nodes = world.nodes
        tables.tlas.instance_count = world.instance_count
        tables.lights = wp.array(ptr=world.lights, shape=(tables.light_count,), dtype=Light)
        tables.dome.unit = world.unit
        tables.dome.strength = world.strength
        tables.dome.dome_from_world = world.dome_from_world
    return tables
