"""Random scripts of Replicator: scenes, graphs of every kind of node, writers, and ways to make the frames."""

from __future__ import annotations

import random

from tests.programs.blocks import OWN_WRITER, Block, Script
from tests.programs.layers import in_layers


class RandomScript:
    """Makes the script of a seed."""

    def __init__(self, seed: int) -> None:
        self._some = random.Random(seed)
        self._layers = random.Random(f"layers {seed}")  # so that all else of a seed stays as it is
        self._names = 0
        self._events: list[str] = []
        self._in_frames: list[Block] = []  # what is done to layers before each step

    def make(self) -> Script:
        """Return the script."""
        some = self._some
        self.features: set[str] = set()
        self._physics = some.random() < 0.3
        scene = self._scene()
        if self._layers.random() < 0.5:
            self.features.add("layers")
            scene, self._in_frames = in_layers(scene, self._layers)
        blocks = scene + self._views()
        functions = self._randomizers()
        triggers = [self._trigger() for _ in range(some.choice([1, 2, 2, 3]))]
        middle = functions + triggers
        outside = [self._node() for _ in range(some.choice([0, 0, 1]))]
        writers = self._writers()
        order = [middle, outside, writers]
        if some.random() < 0.4:
            some.shuffle(order)
        blocks += [block for part in order for block in part] + self._drive()
        return Script(blocks, self.features)

    # --- the scene ---
    def _scene(self) -> list[Block]:
        some, n = self._some, self._some.choice
        lines = [
            "floor = rep.create.plane(scale=8, position=(0, 0, -1.5), semantics=[('class', 'floor')])",
            (
                f"cubes = rep.create.cube(count={n([1, 3])}, semantics=[('class', 'cube')], "
                f"scale={n(['0.6', 'uniform(0.4, 0.8)'])})"
            ),
            (
                f"balls = rep.create.sphere(count={n([1, 2])}, "
                f"position={n(['(1, 1, 0)', 'uniform((-1, -1, 0), (1, 1, 1))'])}, semantics=[('class', 'ball')])"
            ),
            (
                "cones = rep.create.cone(count=2, position=(-1, 1, 0.5), semantics=[('class', 'cone'), ('size', "
                "'small')])"
            ),
            "torus = rep.create.torus(position=(-1, -1, 1), rotation=(30, 20, 10))",
            "volume = rep.create.cube(scale=(3, 3, 2), position=(0, 0, 1), visible=False)",
            "rep.create.light(light_type='dome', intensity=600)",
            "lamp = rep.create.light(light_type='sphere', intensity=20000, position=(2, 2, 3), scale=0.3)",
            "sun = rep.create.light(light_type='distant', intensity=uniform(300, 900), rotation=(30, 0, 0))",
            (
                "materials = rep.create.material_omnipbr(count=2, diffuse=uniform((0, 0, 0), (1, 1, 1)), "
                "roughness=uniform(0, 1))"
            ),
            "group = rep.create.group([cubes, torus])",
        ]
        blocks = [Block(line) for line in lines]
        if self._physics:
            self.features.add("physics")
            with_ = Block("with rep.create.group([cubes, balls]):")
            with_.below += [
                Block(
                    n(["rep.physics.rigid_body()", "rep.physics.rigid_body(velocity=uniform((-1, -1, 0), (1, 1, 2)))"])
                ),
                Block("rep.physics.collider()"),
            ]
            if some.random() < 0.5:
                with_.below.append(Block("rep.physics.mass(mass=uniform(0.5, 2))"))
            blocks += [with_, Block("with floor:", [Block("rep.physics.collider(approximation_shape='none')")])]
        return blocks

    def _views(self) -> list[Block]:
        some = self._some
        blocks = [Block("camera = rep.create.camera(position=(8, 1, 3), look_at=(0, 0, 0))")]
        products = ["rep.create.render_product(camera, (64, 48))"]
        if some.random() < 0.4:
            blocks.append(
                Block("second = rep.create.camera(position=(0, -7, 4), look_at=torus, focal_length=uniform(20, 30))")
            )
            products.append("rep.create.render_product(second, (48, 32), name='side')")
        else:
            blocks.append(Block("second = camera"))
        blocks.append(Block(f"products = [{', '.join(products)}]"))
        return blocks

    # --- draws ---
    def _seed(self) -> str:
        return self._some.choice(["", "", "", f", seed={self._some.randrange(9)}"])

    def _point(self, reach: float = 2.0) -> str:
        r = reach
        return self._some.choice([
            f"uniform((-{r}, -{r}, 0), ({r}, {r}, {r}){self._seed()})",
            f"rep.distribution.normal((0, 0, 0.5), ({r / 2}, {r / 2}, 0.3){self._seed()})",
            f"choice([(0, 0, {r}), ({r}, 0, 0), (0, {r}, 0)]{self._seed()})",
            f"choice([(0, 0, {r}), ({r}, 0, 0), (0, {r}, 0), (1, 1, 1), (0, 1, 1)], with_replacements=False)",
            f"sequence([(0, 0, {r}), ({r}, 0, 0), (0, {r}, 0), (0, 0, 0)])",
            f"sequence([(0, 0, {r}), ({r}, 0, 0), (0, {r}, 0), (0, 0, 0)], ordered=False)",
            f"rep.distribution.combine([uniform(-{r}, {r}), 0.3, rep.distribution.normal(0.5, 0.3)])",
            "rep.distribution.combine([choice([-1, 1]), sequence([0, 1, 2]), rep.distribution.log_uniform(0.1, 1)])",
        ])  # fmt: skip

    def _number(self, low: float, high: float) -> str:
        return self._some.choice([
            f"uniform({low}, {high}{self._seed()})", f"choice([{low}, {high}], weights=[1, 2])",
            f"sequence([{low}, {high}])",
            f"rep.distribution.log_uniform({max(low, 0.01)}, {high})",
        ])  # fmt: skip

    def _tint(self) -> str:
        return self._some.choice(["uniform((0, 0, 0), (1, 1, 1))", "choice([(1, 0, 0), (0, 1, 0), (0, 0, 1)])"])

    # --- nodes ---
    def _randomizers(self) -> list[Block]:
        blocks = []
        if self._some.random() < 0.5:
            inner = [self._on_target("items") for _ in range(self._some.choice([1, 2]))]
            blocks = [
                Block("def shuffled(items):", [Block("with items:", inner), Block("return items.node")]),
                Block("rep.randomizer.register(shuffled)"),
            ]
            self._registered = True
        else:
            self._registered = False
        return blocks

    def _trigger(self) -> Block:
        some = self._some
        kinds = ["frame"] * 6 + ["event", "condition", "time"]
        kind = some.choice(kinds)
        if kind == "frame":
            options = some.choice([
                "", "", "", "interval=2", "interval=3", "max_execs=3", "max_execs=6", "interval=2, max_execs=2",
                "rt_subframes=3", "interval=2, rt_subframes=2",
            ])  # fmt: skip
            head = f"rep.trigger.on_frame({options})"
        elif kind == "event":
            event = f"event_{len(self._events)}"
            self._events.append(event)
            head = f"rep.trigger.on_custom_event({event!r})"
            self.features.add("event")
        elif kind == "condition":
            self.features.add("condition")
            head = "rep.trigger.on_condition(lambda: random.random() < 0.6)"
        else:
            self.features.add("time")
            options = some.choice(["", ", max_execs=4"]) + some.choice(["", ", reset_physics=False"])
            head = f"rep.trigger.on_time(interval={some.choice([0.05, 0.1, 0.02])}, rt_subframes=1{options})"
        return Block(f"with {head}:", [self._node() for _ in range(some.choice([1, 2, 3]))])

    def _target(self) -> str:
        return self._some.choice(["cubes", "balls", "cones", "torus", "group", "cubes", "balls"])

    def _node(self) -> Block:
        some = self._some
        roll = some.random()
        if roll < 0.5:
            inner = [self._on_target("") for _ in range(some.choice([1, 1, 2]))]
            return Block(f"with {self._target()}:", inner)
        if roll < 0.6 and self._registered:
            return Block(f"rep.randomizer.shuffled({self._target()})")
        tint = self._tint()
        line = some.choice([
            f"rep.modify.pose(position={self._point()}, input_prims={self._target()})",
            (
                "rep.modify.pose(position=uniform((4, -9, 1), (9, -5, 4)), "
                f"look_at={some.choice(['(0, 0, 0)', 'torus', 'cubes'])}, input_prims=camera)"
            ),
            (
                f"rep.modify.pose_orbit({some.choice(['(0, 0, 0)', 'torus'])}, uniform(6, 9), uniform(0, 360), "
                f"{self._number(10, 60)}, input_prims=second)"
            ),
            f"rep.modify.attribute('intensity', {self._number(1000, 40000)}, input_prims=lamp)",
            f"rep.modify.attribute('color', {tint}, input_prims=sun)",
            f"rep.modify.attribute('focalLength', {self._number(18, 35)}, input_prims=camera)",
            f"rep.modify.material(materials, input_prims={self._target()})",
            f"rep.randomizer.materials(materials, input_prims={self._target()}{self._seed()})",
            f"rep.create.sphere(position={self._point()}, scale=0.3, semantics=[('class', 'extra')])",
            f"rep.create.cube(position={self._point()}, scale=0.2, count=2)",
            f"rep.create.material_omnipbr(diffuse={tint})",
            (
                "rep.randomizer.instantiate(['/Isaac/Props/YCB/Axis_Aligned/008_pudding_box.usd', "
                "'/Isaac/Props/YCB/Axis_Aligned/006_mustard_bottle.usd'], "
                f"size={some.choice(['2', '1', 'choice([1, 2, 3])'])}, "
                f"mode={some.choice(['scene_instance', 'point_instance', 'reference'])!r}{self._seed()})"
            ),
            (
                "with_instances = rep.randomizer.instantiate([str(p.GetPath()) for p in cones.get_output_prims("
                ")['prims']], size=2, with_replacements=False)"
            ),
            (
                "rep.randomizer.scatter_2d(floor, "
                f"input_prims={self._target()}{self._seed()}{some.choice(['', ', check_for_collisions=True'])})"
            ),
            (
                "rep.randomizer.scatter_3d(volume, "
                f"input_prims={self._target()}{self._seed()}{some.choice(['', ', check_for_collisions=True'])})"
            ),
            "rep.randomizer.rotation(input_prims=rep.get.prims(semantics=[('class', 'cube')]))",
            (
                "rep.modify.visibility(choice([True, False]), input_prims=rep.get.prims(path_pattern='Cone', "
                f"prim_types=['Xform'], cache_result={some.choice(['True', 'False'])}))"
            ),
        ])  # fmt: skip
        return Block(line)

    def _on_target(self, name: str) -> Block:
        some = self._some
        lines = [
            f"rep.modify.pose(position={self._point()})",
            "rep.modify.pose(rotation=uniform((0, 0, 0), (360, 360, 360)))",
            f"rep.modify.pose(scale={self._number(0.3, 0.9)}, rotation_x={self._number(0, 90)})",
            f"rep.modify.pose(position_z={self._number(0, 2)}, look_at={self._point()})",
            "rep.randomizer.rotation()",
            f"rep.randomizer.color(colors={self._tint()}{self._seed()})",
            "rep.randomizer.materials(materials)",
            "rep.modify.visibility(choice([True, True, False]))",
            f"rep.modify.semantics([('class', 'changed')], mode={some.choice(['add', 'replace', 'clear'])!r})",
            (
                "rep.modify.semantics(choice([[('class', 'one')], [('class', 'two')], [('class', 'three'), ("
                "'size', 'big')]]))"
            ),
            f"rep.randomizer.scatter_2d(floor{self._seed()})",
            f"rep.randomizer.scatter_3d(volume, check_for_collisions={some.choice([True, False])})",
            f"rep.modify.attribute('xformOp:translate', {self._point()})",
        ]
        if self._physics:
            lines += [
                "rep.physics.rigid_body(velocity=uniform((-1, -1, 0), (1, 1, 3)), overwrite=True)",
                "rep.physics.mass(mass=uniform(0.5, 3))",
                "rep.physics.physics_material(restitution=uniform(0, 1), dynamic_friction=0.5)",
            ]
        return Block(some.choice(lines))

    # --- writers ---
    def _writers(self) -> list[Block]:
        some = self._some
        names = "bounding_box_2d_tight bounding_box_3d semantic_segmentation instance_segmentation camera_params"
        labels = ", ".join(f"{name}=True" for name in f"{names} distance_to_camera occlusion".split())
        kinds = {
            "basic": ("BasicWriter", labels),
            "rgb": ("BasicWriter", "rgb=True, normals=True, bounding_box_2d_loose=True"),
            "motion": ("BasicWriter", "motion_vectors=True, instance_id_segmentation=True"),
            "kitti": ("KittiWriter", "bbox_height_threshold=2"),
            "coco": ("CocoWriter", "splits={'train': 2, 'val': 1}"),
            "yolo": ("YoloWriter", "task='segment', splits={'train': 2, 'val': 1}"),
            "pose": ("PoseWriter", some.choice(["", "skip_empty_frames=True", "format='dope'"])),
            "voc": ("VocWriter", ""),
            "cvat": ("CvatWriter", ""),
            "own": ("OwnWriter", ""),
        }
        names = some.sample(list(kinds), some.choice([1, 1, 2, 3]))
        if not {"basic", "motion", "rgb"} & set(names):
            names.append("basic")
        blocks = []
        if "own" in names:
            blocks.append(Block(OWN_WRITER))
        for name in names:
            kind, options = kinds[name]
            products = some.choice(["products", "products", "products[0]"])
            trigger = ""
            if some.random() < 0.15:
                trigger = ", trigger=rep.trigger.on_frame(interval=2)"
            get = "OwnWriter()" if kind == "OwnWriter" else f"rep.writers.get({kind!r})"
            initialize = f"{name}.initialize(output_dir=OUT + '/{name}'{', ' if options else ''}{options})"
            blocks += [Block(f"{name} = {get}"), Block(initialize), Block(f"{name}.attach({products}{trigger})")]
        self._writer_names = names
        return blocks

    # --- frames ---
    def _change(self) -> list[Block]:
        """What a script does itself before a step."""
        some = self._some
        blocks = [
            Block(f"rep.utils.send_og_event({event!r})")
            if some.random() < 0.5
            else Block("if frame % 2:", [Block(f"rep.utils.send_og_event({event!r})")])
            for event in self._events
        ]
        prim = "cubes.get_output_prims()['prims'][0]"
        options = [
            Block("np.random.seed(frame)"),
            Block(f"{prim}.GetAttribute('xformOp:translate').Set(tuple(np.random.uniform(-1, 1, 3)))"),
            Block(f"{prim}.GetAttribute('xformOp:translate').Set(Gf.Vec3d(random.random(), random.random(), 1))"),
            Block(
                "with torus:",
                [Block("rep.modify.pose(position=(random.uniform(-1, 1), 0, 1), rotation=(0, 0, 30 * frame))")],
            ),
            Block(
                "if random.random() < 0.5:",
                [Block("rep.create.sphere(position=(random.random(), 1, 1), semantics=[('class', f'new_{frame}')])")],
            ),
            Block("if frame == 2:", [Block(f"{self._writer_names[0]}.detach()")]),
            Block("if frame == 1:", [Block("products[0].hydra_texture.set_updates_enabled(False)")]),
            Block("products[-1].hydra_texture.set_updates_enabled(frame % 3 != 1)"),
            Block("if frame == 2:", [Block("rep.modify.semantics([('class', 'late')], input_prims=torus)")]),
            Block(
                "if frame == 3:",
                [
                    Block(
                        "omni.usd.get_context().get_stage().RemovePrim(str(torus.get_output_prims()['prims'][0].GetPath()))"
                    )
                ],
            ),
            Block(
                "if frame == 2:",
                [
                    Block(
                        "with rep.trigger.on_frame(max_execs=2), cones:",
                        [Block("rep.modify.pose(position=uniform((0, 0, 0), (1, 1, 1)))")],
                    )
                ],
            ),
            Block("if frame == 2:", [Block("rep.set_global_seed(77)")]),
            Block(
                "numbers = rep.rng.ReplicatorRNG().generator.uniform(0, 1, 3)\n"
                "if torus.get_output_prims()['prims'][0]:\n"
                "    UsdGeom.XformCommonAPI(torus.get_output_prims()['prims'][0]).SetTranslate(Gf.Vec3d(*numbers))"
            ),
        ]
        return blocks + some.sample(options, some.choice([0, 1, 2, 3]))

    def _drive(self) -> list[Block]:
        some, count = self._some, self._some.choice([4, 5, 6])
        how = some.choice(["run", "run", "steps", "steps", "async", "run_async", "two_runs", "play"])
        self.features.add(how)
        plays = self._physics or "time" in self.features
        start = ", start_timeline=True" if plays else ""
        if how == "run":
            return [Block(f"rep.orchestrator.run(num_frames={count}{start})")]
        if how == "run_async":
            run = f"await rep.orchestrator.run_until_complete_async(num_frames={count}{start})"
            return [Block("async def main():", [Block(run)]), Block("asyncio.ensure_future(main())")]
        if how == "two_runs":
            between = some.choice(["rep.orchestrator.stop()", "rep.orchestrator.wait_until_complete()"])
            return [
                Block(f"rep.orchestrator.run_until_complete(num_frames=2{start})"),
                *[Block(f"rep.utils.send_og_event({event!r})") for event in self._events],
                Block("with cubes:", [Block("rep.modify.pose(position=(0, random.random(), 1))")]),
                Block(between),
                Block(f"rep.orchestrator.run_until_complete(num_frames={count - 2})"),
            ]
        play = [Block("omni.timeline.get_timeline_interface().play()")] if plays or how == "play" else []
        options = some.choice(["", "", "delta_time=0.0", "delta_time=1 / 30", "rt_subframes=2", "pause_timeline=False"])
        inner = self._change() + self._in_frames
        if how == "play":
            update = Block("omni.kit.app.get_app().update()")
            inner.append(Block(f"for _ in range({some.choice([1, 3])}):", [update]))
        step = "await rep.orchestrator.step_async" if how == "async" else "rep.orchestrator.step"
        loop = Block(f"for frame in range({count}):", [*inner, Block(f"{step}({options})")])
        if how != "async":
            return [*play, loop]
        end = Block("await rep.orchestrator.wait_until_complete_async()")
        return [*play, Block("async def main():", [loop, end]), Block("asyncio.ensure_future(main())")]


if __name__ == "__main__":
    import sys

    print(RandomScript(int(sys.argv[1])).make().text)
