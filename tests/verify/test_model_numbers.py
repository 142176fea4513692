"""`usdsdg verify` compares the models that BOP's objects are of with the classes of the record."""

import usdsdg as rep
from tests.verify.label_faults import edit_json
from usdsdg.verify import verify


def test_numbers_of_classes_whose_models_are_alike_cannot_be_swapped(stage, tmp_path):
    create = rep.functional.create
    rep.create.light(light_type="dome")
    for index, label in enumerate(("ant", "bee", "cow")):
        create.cube(position=(index, 0, 0), scale=0.5, semantics={"class": label})
    writer = rep.writers.get("BopWriter")
    writer.initialize(output_dir=str(tmp_path))
    camera = create.camera(position=(1, -6, 0), look_at=(1, 0, 0))
    writer.attach(rep.create.render_product(camera, (64, 48)))
    rep.orchestrator.step(delta_time=0.0)
    rep.orchestrator.wait_until_complete()
    assert verify(tmp_path).faults == []

    def swap(values):
        first, second = values["0"][:2]
        first["obj_id"], second["obj_id"] = second["obj_id"], first["obj_id"]

    edit_json(tmp_path / "train_pbr/000000/scene_gt.json", swap)
    what = [fault.what for fault in verify(tmp_path).faults]
    assert len(what) == 2
    assert all(each.startswith("obj_id of object ") for each in what)
