"""Random graphs of nodes that worlds can draw, under triggers of different intervals and limits."""

import random
from collections.abc import Callable

import usdsdg as rep

uniform, choice = rep.distribution.uniform, rep.distribution.choice


class RandomGraph:
    """Calling it authors a scene with a graph, both from `seed`, and returns its camera; `nodes` names what it made."""

    def __init__(self, seed: int) -> None:
        self.seed, self.nodes = seed, []

    def __call__(self):
        self._random, self.nodes = random.Random(self.seed), []
        self._make_prims()
        for _ in range(self._random.choice([1, 2, 3])):
            with self._trigger():
                for _ in range(self._random.choice([1, 2, 3])):
                    self._node()
        return self.camera

    def _make_prims(self):
        some = self._random
        rep.create.light(light_type="dome", intensity=600)
        self.cubes = rep.create.cube(count=some.choice([1, 3]), semantics=[("class", "cube")])
        self.balls = rep.create.sphere(count=some.choice([1, 2]), position=(1, 1, 0), semantics=[("class", "ball")])
        self.torus = rep.create.torus(position=(-1, 1, 1), rotation=(30, 20, 10), semantics=[("class", "torus")])
        self.group = rep.create.group([self.cubes, self.torus])
        self.floor = rep.create.plane(scale=8, position=(0, 0, -2))
        self.lamp = rep.create.light(light_type="sphere", intensity=20000, position=(2, 2, 3), scale=0.3)
        self.sun = rep.create.light(light_type="distant", intensity=500, rotation=(30, 0, 0))
        self.material = rep.create.material_omnipbr(diffuse=(0.7, 0.2, 0.1))
        rep.modify.material(self.material, input_prims=self.balls)
        self.camera = rep.create.camera(position=(8, 1, 3), look_at=(0, 0, 0))

    def _trigger(self):
        options = self._random.choice(
            [
                {},
                {},
                {"interval": 2},
                {"interval": 3},
                {"max_execs": 2},
                {"max_execs": 4},
                {"interval": 2, "max_execs": 2},
            ]
        )
        self.nodes.append(f"on_frame({options})")
        return rep.trigger.on_frame(**options)

    def _node(self):
        name, make = self._random.choice(list(self._makers().items()))
        self.nodes.append(name)
        make()

    def _point(self, reach=2.0):
        """A distribution of points."""
        corners = [(0, 0, reach), (reach, 0, 0), (0, reach, 0)]
        return self._random.choice(
            [
                uniform((-reach,) * 3, (reach,) * 3),
                rep.distribution.normal((0, 0, 0), (reach / 2,) * 3),
                choice(corners),
                rep.distribution.sequence([*corners, (0, 0, 0)]),
                rep.distribution.combine([uniform(-reach, reach), 0.3, rep.distribution.normal(0, reach / 3)]),
            ]
        )

    def _number(self, low, high):
        """A distribution of numbers."""
        return self._random.choice([uniform(low, high), choice([low, high]), rep.distribution.sequence([low, high])])

    def _makers(self) -> dict[str, Callable[[], object]]:
        some = self._random
        pose, attribute = rep.modify.pose, rep.modify.attribute
        shapes, single = [self.cubes, self.balls, self.torus, self.group], [self.cubes, self.balls, self.torus]
        turned, tint = uniform((0, 0, 0), (360, 360, 360)), uniform((0, 0, 0), (1, 1, 1))
        shader = f"{self.material.prims[0]}/Shader"
        return {
            "position": lambda: pose(position=self._point(), input_prims=some.choice(shapes)),
            "rotation": lambda: pose(rotation=turned, input_prims=some.choice(shapes)),
            "scale": lambda: pose(scale=self._number(0.5, 1.5), input_prims=some.choice(single)),
            "axes": lambda: pose(
                rotation_x=self._number(0, 90), position_z=self._number(-1, 1), input_prims=some.choice(shapes)
            ),
            "look_at": lambda: pose(
                look_at=some.choice([*single, (0, 0, 9)]),
                position=uniform((4, -9, 1), (9, -5, 4)),
                input_prims=self.camera,
            ),
            "orbit": lambda: rep.modify.pose_orbit(
                some.choice([*single, (0, 0, 0)]), uniform(6, 9), uniform(0, 360), self._number(10, 60),
                input_prims=self.camera,
            ),
            "color": lambda: rep.randomizer.color(colors=tint, input_prims=some.choice(single)),
            "any rotation": lambda: rep.randomizer.rotation(input_prims=some.choice(shapes)),
            "scattered": lambda: rep.randomizer.scatter_2d(
                self.floor,
                no_coll_prims=some.choice([None, self.torus]),
                check_for_collisions=some.choice([True, False]),
                min_samp=(-3, -3, None),
                max_samp=(3, 3, None),
                input_prims=some.choice([self.cubes, self.balls]),
            ),
            "filled": lambda: rep.randomizer.scatter_3d(self.torus, input_prims=self.balls),
            "in a box": lambda: rep.randomizer.scatter_3d(
                min_samp=(-2, -2, 0), max_samp=(2, 2, 2), input_prims=self.cubes
            ),
            "visibility": lambda: rep.modify.visibility(choice([True, False]), input_prims=some.choice(single)),
            "translate": lambda: attribute("xformOp:translate", self._point(), input_prims=some.choice(single)),
            "lamp": lambda: attribute("intensity", self._number(1000, 40000), input_prims=self.lamp),
            "light": lambda: attribute("color", tint, input_prims=some.choice([self.lamp, self.sun])),
            "sun": lambda: pose(rotation=uniform((-60, 0, 0), (60, 0, 0)), input_prims=self.sun),
            "lamp moves": lambda: pose(position=uniform((0, 0, 2), (3, 3, 4)), input_prims=self.lamp),
            "roughness": lambda: attribute(
                "inputs:reflection_roughness_constant", self._number(0, 1), input_prims=shader
            ),
            "diffuse": lambda: attribute("inputs:diffuse_color_constant", tint, input_prims=shader),
        }  # fmt: skip
