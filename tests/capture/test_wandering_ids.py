"""Ids and colors over frames in which a script edits the stage: the same in all frames, and in parts of a run."""

from __future__ import annotations

import json
import random
from collections.abc import Callable
from pathlib import Path

import pytest
from pxr import Gf, Usd, UsdGeom

import usdsdg as rep
from tests.capture.part_runs import differences, run, run_again, run_parts
from tests.sampled_cases import sampled
from usdsdg.session.stage_context import current_stage
from usdsdg.stage.semantics.labels import add_labels

FRAMES = 6
TABLES = {
    "instance_segmentation": "instance_segmentation_mapping",
    "instance_id_segmentation": "instance_id_segmentation_mapping",
    "semantic_segmentation": "semantic_segmentation_labels",
}
Edit = Callable[[Usd.Stage, random.Random], None]


def solid(stage: Usd.Stage, path: str, place: tuple[float, float, float], label: str = "", kind: str = "Cube") -> None:
    prim = stage.DefinePrim(path, kind)
    UsdGeom.XformCommonAPI(prim).SetTranslate(Gf.Vec3d(*place))
    UsdGeom.XformCommonAPI(prim).SetScale(Gf.Vec3f(0.3))
    if label:
        add_labels(prim, {"class": [label]})


def trees(stage: Usd.Stage, path: str, numbers: list[int]) -> None:
    """Set the points of an instancer, with their ids."""
    instancer = UsdGeom.PointInstancer(stage.GetPrimAtPath(path))
    instancer.CreateProtoIndicesAttr([number % 2 for number in numbers])
    instancer.CreateIdsAttr(numbers)
    instancer.CreatePositionsAttr([(number % 5 - 2, number // 5 - 1, 1) for number in numbers])


def forest(stage: Usd.Stage) -> None:
    for index in range(4):
        solid(stage, f"/World/Box_{index}", (2 * index - 3, 0, 0), f"box{index % 2}" if index != 2 else "")
    instancer = UsdGeom.PointInstancer.Define(stage, "/World/Trees")
    solid(stage, "/World/Trees/Oak/Trunk", (0, 0, 0), "oak")
    solid(stage, "/World/Trees/Fir/Trunk", (0, 0, 0), "fir", "Sphere")
    instancer.CreatePrototypesRel().SetTargets(["/World/Trees/Oak", "/World/Trees/Fir"])
    trees(stage, "/World/Trees", [0, 1, 2])
    group = stage.DefinePrim("/World/Var", "Xform")
    looks = group.GetVariantSets().AddVariantSet("look")
    for name in "xy":
        looks.AddVariant(name)
        looks.SetVariantSelection(name)
        with looks.GetVariantEditContext():
            solid(stage, f"/World/Var/Part_{name}", (0, -3, 0), f"part_{name}")


def add(stage: Usd.Stage, draws: random.Random) -> None:
    number = draws.randrange(100)
    place = (draws.uniform(-3, 3), draws.uniform(-2, 2), draws.uniform(0, 2))
    solid(stage, f"/World/{draws.choice('AZ')}_{number}", place, draws.choice(["", "new", "box0"]))


def remove(stage: Usd.Stage, draws: random.Random) -> None:
    stage.RemovePrim(f"/World/Box_{draws.randrange(4)}")


def toggle(stage: Usd.Stage, draws: random.Random) -> None:
    path = draws.choice(["/World/Trees", "/World/Trees/Oak/Trunk", "/World/Box_0", "/World/Box_2"])
    if prim := stage.GetPrimAtPath(path):
        UsdGeom.Imageable(prim).CreateVisibilityAttr(draws.choice(["inherited", "invisible"]))


def plant(stage: Usd.Stage, draws: random.Random) -> None:
    trees(stage, "/World/Trees", draws.sample(range(15), draws.randrange(1, 6)))


def hide_points(stage: Usd.Stage, draws: random.Random) -> None:
    instancer = UsdGeom.PointInstancer(stage.GetPrimAtPath("/World/Trees"))
    instancer.CreateInvisibleIdsAttr([number for number in range(15) if draws.random() < 0.5])


def switch(stage: Usd.Stage, draws: random.Random) -> None:
    stage.GetPrimAtPath("/World/Var").GetVariantSet("look").SetVariantSelection(draws.choice("xy"))


def relabel(stage: Usd.Stage, draws: random.Random) -> None:
    if prim := stage.GetPrimAtPath(draws.choice(["/World/Box_1", "/World/Trees/Fir/Trunk", "/World/Var"])):
        add_labels(prim, {draws.choice(["class", "part"]): [draws.choice(["other", "box0", "fir"])]})


EDITS: list[Edit] = [add, remove, toggle, toggle, plant, plant, hide_points, switch, relabel]


def wandering(seed: int) -> Callable[[Path], None]:
    """Return a script that edits its stage between frames."""

    def script(folder: Path) -> None:
        draws, stage = random.Random(seed), current_stage()
        forest(stage)
        products = [
            rep.create.render_product(rep.create.camera(position=place, look_at=(0, 0, 0)), (48, 36), name=name)
            for place, name in (((0, -9, 5), "front"), ((7, -2, 4), "side"))
        ]
        ids = {f"colorize_{name}": False for name in TABLES}
        shown = dict.fromkeys((*TABLES, "bounding_box_2d_tight"), True)
        for name, options in (("ids", ids), ("colors", {"semantic_types": ["class", "part"]})):
            writer = rep.writers.get("BasicWriter")
            writer.initialize(output_dir=str(folder / name), **shown, **options)
            writer.attach(products)
        late = rep.writers.get("VocWriter")
        late.initialize(output_dir=str(folder / "voc"))
        late.attach(products[1])
        for _ in range(FRAMES):
            for edit in draws.choices(EDITS, k=draws.randrange(3)):
                edit(stage, draws)
            for product in products:
                product.hydra_texture.set_updates_enabled(draws.random() < 0.8)
            rep.orchestrator.step()

    return script


def meanings(folder: Path, table: str) -> list[tuple[str, str]]:
    """Return pairs of id, or color, and what it means, of all tables of a folder."""
    found = [json.loads(file.read_text()) for file in sorted(folder.rglob(f"{table}_*.json"))]
    return sorted({(key, json.dumps(value, sort_keys=True)) for each in found for key, value in each.items()})


@pytest.mark.parametrize("seed", sampled(range(6), 2))
def test_ids_are_those_of_all_frames_and_of_all_processes(tmp_path, seed):
    script = wandering(seed)
    run(script, tmp_path / "whole")
    for name in ("ids", "colors"):
        for table in TABLES.values():
            pairs = meanings(tmp_path / "whole" / name, table)
            assert len(pairs) > 2
            assert len({key for key, _ in pairs}) == len({meaning for _, meaning in pairs}) == len(pairs)
    run_parts(script, tmp_path / "shards", "0/2", "1/2")
    assert differences(tmp_path / "shards", tmp_path / "whole") == []
    run_again(script, tmp_path / "again", tmp_path / "whole", 1 + seed % 4)
    assert differences(tmp_path / "again", tmp_path / "whole") == []


def moving_labels(folder: Path) -> None:
    """A script in which time samples decide labels, and which points there are, also where nothing is in view."""
    stage = current_stage()
    stage.SetTimeCodesPerSecond(24)
    forest(stage)
    box = stage.GetPrimAtPath("/World/Box_0")
    add_labels(box, {"state": ["new"]})
    label = next(each for each in box.GetAuthoredAttributes() if each.GetName() == "semantics:labels:state")
    instancer = UsdGeom.PointInstancer(stage.GetPrimAtPath("/World/Trees"))
    for frame, (name, numbers) in enumerate([("worn", [7, 1]), ("bent", [8, 2]), ("apart", [3, 9]), ("gone", [6, 4])]):
        label.Set([name], frame)
        instancer.GetIdsAttr().Set(numbers, frame)
        instancer.GetProtoIndicesAttr().Set([0, 1], frame)
        instancer.GetPositionsAttr().Set([(-1, 1, 1), (1, 1, 1)], frame)
    product = rep.create.render_product(rep.create.camera(position=(0, -9, 5), look_at=(0, 0, 0)), (48, 36))
    writer = rep.writers.get("BasicWriter")
    shown = dict.fromkeys(TABLES, True)
    writer.initialize(output_dir=str(folder / "basic"), **shown, semantic_types=["class", "state"])
    writer.attach(product)
    for frame in range(4):
        for path, is_shown in (("/World/Trees", frame != 1), ("/World/Box_0", frame != 2)):
            UsdGeom.Imageable(stage.GetPrimAtPath(path)).CreateVisibilityAttr("inherited" if is_shown else "invisible")
        rep.orchestrator.step(delta_time=1 / 24 if frame else 0.0)


def test_time_samples_number_the_same_in_all_processes(tmp_path):
    run(moving_labels, tmp_path / "whole")
    names = {json.loads(meaning) for _, meaning in meanings(tmp_path / "whole/basic", TABLES["instance_segmentation"])}
    assert {"/World/Trees/Oak/Trunk[7]", "/World/Trees/Fir/Trunk[4]"} <= names
    run_parts(moving_labels, tmp_path / "shards", "1/2", "0/2")
    assert differences(tmp_path / "shards", tmp_path / "whole") == []
    run_parts(moving_labels, tmp_path / "parts", "3:9", "0:3")
    assert differences(tmp_path / "parts", tmp_path / "whole") == []


def nested(folder: Path) -> None:
    """A script of instancers in an instancer, which grow while they are hidden."""
    stage = current_stage()
    forest(stage)
    outer = UsdGeom.PointInstancer.Define(stage, "/World/Parks")
    outer.CreatePrototypesRel().SetTargets(["/World/Trees"])
    outer.CreateProtoIndicesAttr([0, 0])
    outer.CreatePositionsAttr([(-1, 0, 0), (1, 0, 0.5)])
    product = rep.create.render_product(rep.create.camera(position=(0, -9, 5), look_at=(0, 0, 0)), (48, 36))
    writer = rep.writers.get("BasicWriter")
    writer.initialize(output_dir=str(folder / "basic"), **dict.fromkeys(TABLES, True))
    writer.attach(product)
    for frame in range(4):
        UsdGeom.Imageable(outer).CreateVisibilityAttr("invisible" if frame == 1 else "inherited")
        if frame:
            trees(stage, "/World/Trees", [2 * frame, 3 * frame])
            outer.GetProtoIndicesAttr().Set([0] * (1 + frame % 3))
            outer.GetPositionsAttr().Set([(each - 1, 0, each / 2) for each in range(1 + frame % 3)])
        if frame == 2:
            solid(stage, "/World/A", (0, -2, 0), "late")
        rep.orchestrator.step()


def test_points_of_nested_instancers_number_the_same_in_all_processes(tmp_path):
    run(nested, tmp_path / "whole")
    pairs = meanings(tmp_path / "whole/basic", TABLES["instance_segmentation"])
    assert any("][" in meaning for _, meaning in pairs)
    assert len({key for key, _ in pairs}) == len({meaning for _, meaning in pairs}) == len(pairs)
    run_parts(nested, tmp_path / "shards", "1/2", "0/2")
    assert differences(tmp_path / "shards", tmp_path / "whole") == []


def test_the_list_of_ycb_video_is_empty_where_no_frame_is_written(tmp_path):
    def script(folder: Path) -> None:
        solid(current_stage(), "/World/Box", (0, 0, 0), "box")
        product = rep.create.render_product(rep.create.camera(position=(0, -9, 5), look_at=(0, -90, 0)), (48, 36))
        writer = rep.writers.get("YCBVideoWriter")
        writer.initialize(output_dir=str(folder / "ycb"), num_frames=3, rgb=True, pose=True)
        writer.attach(product)
        for _ in range(3):
            rep.orchestrator.step()

    run(script, tmp_path / "whole")
    assert (tmp_path / "whole/ycb/data/YCB_Video/train.txt").read_text() == ""
    run_parts(script, tmp_path / "shards", "1/2", "0/2")
    assert differences(tmp_path / "shards", tmp_path / "whole") == []
    run_again(script, tmp_path / "again", tmp_path / "whole", 1)
    assert differences(tmp_path / "again", tmp_path / "whole") == []
