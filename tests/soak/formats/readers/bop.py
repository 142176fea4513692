"""Read a BOP dataset with bop_toolkit and run its scripts: `python bop.py ROWS.json DATASET SPLIT WIDTH HEIGHT`.

It runs in a Python of its own, which has bop_toolkit as a checkout (its scripts are not in the package), vispy and
PyOpenGL; nothing here is of usdsdg. bop_toolkit knows the datasets of the benchmark only, so ours
takes the place of one.
"""

import json
import multiprocessing
import os
import subprocess
import sys
import tempfile
import warnings
from pathlib import Path

import numpy as np

os.environ.setdefault("EGL_PLATFORM", "surfaceless")
NAME = "lm"  # of the benchmark
DELTA = 15  # mm by which a surface that is visible may be behind the depth image
NEAR = "near.json"  # pixels of each object that are hidden by less
TARGETS = "test_targets_bop19.json"


def main() -> None:
    where, dataset, split, *size = sys.argv[1:]
    with tempfile.TemporaryDirectory() as folder:
        rows = read(Path(dataset) / split) + scripts(Path(folder), Path(dataset), split, tuple(map(int, size)))
    Path(where).write_text(json.dumps(rows))


def read(folder: Path) -> list:
    """Load every picture of every scene."""
    from bop_toolkit_lib.dataset import bop_scenewise

    pictures = objects = 0
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        for scene in sorted(folder.iterdir()):
            infos = bop_scenewise.read_scene_infos(scene, read_image_ids=True)
            assert all(infos[f"has_{each}"] for each in ("rgb", "depth", "mask", "mask_visib", "gt", "gt_info"))
            gt = bop_scenewise.load_scene_data(scene)["scene_gt"]
            for number in infos["image_ids"]:
                # It cannot load the masks of a picture without any.
                masks = bool(gt[number])
                image = bop_scenewise.load_image_data(
                    scene, number, load_mask=masks, load_mask_visib=masks, load_gt=True, load_gt_info=True
                )
                assert image["im_rgb"].shape[:2] == image["im_depth"].shape
                assert len(image["gt"]) == len(image["gt_info"])
                assert not masks or len(image["mask"]) == len(image["mask_visib"]) == len(image["gt"])
                pictures, objects = pictures + 1, objects + len(image["gt"])
    texts = {str(each.message) for each in said}
    found = f"{pictures} pictures, {objects} objects; {texts or 'none'}"
    return [["bop_scenewise loads without a warning", found, not said]]


def scripts(folder: Path, dataset: Path, split: str, size: tuple) -> list:
    """Run bop_toolkit's scripts over the dataset, as one of its name in `folder`."""
    base = folder / NAME
    base.mkdir()
    for name in (split, "models", "models_eval", "camera.json"):
        (base / name).symlink_to(dataset.resolve() / name.removesuffix("_eval"))
    for name in ("BOP_PATH", "BOP_RESULTS_PATH", "BOP_EVAL_PATH", "BOP_OUTPUT_PATH"):
        os.environ[name] = str(folder)
    os.environ["BOP_NUM_WORKERS"] = "1"
    _as_ours(folder, split, size)
    _from_centers()
    return [
        *_cameras(folder, dataset),
        *_models(folder, dataset),
        *_infos(folder, dataset / split),
        *_scores(folder, split),
    ]


def _as_ours(folder: Path, split: str, size: tuple) -> None:
    """Let bop_toolkit know our objects, scenes and sizes; what its scripts write goes into `folder`."""
    from bop_toolkit_lib import dataset_params

    models, splits = dataset_params.get_model_params, dataset_params.get_split_params

    def model_params(path: str, name: str, kind: object = None) -> dict:
        known = models(str(folder), NAME, "eval" if kind == "eval" else None)
        ids = sorted(int(each.stem[4:]) for each in (folder / NAME / "models").glob("obj_*.ply"))
        known |= {"obj_ids": ids}
        if kind != "eval":
            known["models_info_path"] = str(folder / "models_info.json")
        return known

    def split_params(path: str, name: str, part: str, kind: object = None) -> dict:
        known = splits(str(folder), NAME, *split.split("_"))
        scenes = sorted(int(each.name) for each in (folder / NAME / split).iterdir())
        known |= {"im_size": size, "scene_ids": scenes, "eval_sensor": None, "eval_modality": None}
        if kind == "computed":
            known["scene_gt_info_tpath"] = str(folder / "info_{scene_id:06d}.json")
        return known

    dataset_params.get_model_params, dataset_params.get_split_params = model_params, split_params


def _from_centers() -> None:
    """Let bop_toolkit's renderers count pixels from the center of the first, as its `misc` and OpenCV do.

    They pass the principal point to OpenGL, which counts from the first pixel's corner.
    """
    from bop_toolkit_lib.rendering import renderer

    create = renderer.create_renderer

    def created(*arguments: object, **options: object) -> object:
        made = create(*arguments, **options)
        render = made.render_object

        def shifted(number: int, rotation: object, at: object, fx: float, fy: float, cx: float, cy: float) -> object:
            return render(number, rotation, at, fx, fy, cx + 0.5, cy + 0.5)

        made.render_object = shifted
        return made

    renderer.create_renderer = created


def _run(script: str, *arguments: str, **changed: object) -> None:
    """Run a script of bop_toolkit, with other values of its parameters `p`, in a process that knows our dataset."""
    child = multiprocessing.get_context("fork").Process(
        target=_run_here, args=(Path(os.environ["BOP_PATH"]), script, arguments, changed)
    )
    child.start()
    child.join()
    if child.exitcode:
        raise RuntimeError(f"{script} ended with {child.exitcode}")


def _run_here(folder: Path, script: str, arguments: tuple, changed: dict) -> None:
    import bop_toolkit_lib
    from bop_toolkit_lib import visibility

    near, estimate = [], visibility.estimate_visib_mask_gt

    def estimated(scene: np.ndarray, model: np.ndarray, *others: object, **options: object) -> np.ndarray:
        behind = model - scene
        near.append(int(((model > 0) & (scene > 0) & (behind > 1.0) & (behind <= DELTA)).sum()))
        return estimate(scene, model, *others, **options)

    visibility.estimate_visib_mask_gt = estimated
    path = Path(bop_toolkit_lib.__file__).parents[1] / "scripts" / script
    sys.argv = [str(path), *arguments]
    text = path.read_text()
    if changed:
        before, mark, after = text.partition("\n}\n")
        assert mark, f"{script} has no parameters"
        text = f"{before}{mark}p.update({changed!r})\n{after}"
    exec(compile(text, str(path), "exec"), {"__name__": "__main__", "__file__": str(path)})
    if near:
        (folder / NEAR).write_text(json.dumps(near))


def _cameras(folder: Path, dataset: Path) -> list:
    from bop_toolkit_lib import dataset_params, inout

    camera = dataset_params.get_camera_params(str(folder), NAME)
    (scene, *_) = sorted(folder.joinpath(NAME).glob("*/*/scene_camera.json"))
    first = next(iter(inout.load_scene_camera(str(scene)).values()))
    same = np.allclose(camera["K"], first["cam_K"]) and camera["depth_scale"] == first["depth_scale"]
    return [["get_camera_params reads camera.json", f"{camera['im_size']}, as scene_camera.json: {same}", bool(same)]]


def _models(folder: Path, dataset: Path) -> list:
    """Compare models_info.json with what calc_model_info.py computes of the models."""
    from bop_toolkit_lib import inout

    _run("calc_model_info.py")
    theirs = json.loads((folder / "models_info.json").read_text())
    ours = json.loads((dataset / "models/models_info.json").read_text())
    off = max(abs(ours[number][name] - each[name]) for number, each in theirs.items() for name in each)
    lacking = [
        name
        for name in ("pts", "normals", "faces")
        if name not in inout.load_ply(str(dataset / "models/obj_000001.ply"))
    ]
    return [
        ["calc_model_info.py and models_info.json agree", f"{len(theirs)} models, at most {off:.2g} mm apart",
         sorted(ours) == sorted(theirs) and off < 1e-3],
        ["models have points, faces and normals", f"lacking: {lacking or 'none'}", not lacking],
    ]  # fmt: skip


def _infos(folder: Path, scenes: Path) -> list:
    """Compare scene_gt_info.json with what calc_gt_info.py computes of depths, models and poses.

    It counts as visible what is hidden by up to 15 mm, where ours is exact: so many pixels more are allowed, and boxes
    of such objects are not compared.
    """
    # The kind of the split tells the function above where to write.
    _run("calc_gt_info.py", dataset=NAME, dataset_split_type="computed", modality=None, sensor=None, delta=DELTA)
    near = iter(json.loads((folder / NEAR).read_text()))
    worst: dict = {}
    objects = touching = 0
    for scene in sorted(scenes.iterdir()):
        ours = json.loads((scene / "scene_gt_info.json").read_text())
        theirs = json.loads((folder / f"info_{int(scene.name):06d}.json").read_text())
        for number, listed in theirs.items():
            for index, (their, our) in enumerate(zip(listed, ours[number], strict=True)):
                hidden = next(near)
                objects, touching = objects + 1, touching + (hidden > 0)
                for name, off in _off(our, their, hidden):
                    place = f"{scene.name}/{number}, object {index}: {our[name]}, {their[name]}"
                    worst[name] = max(worst.get(name, (0.0, "")), (off, place))
    return [
        [
            "objects in scene_gt_info",
            f"{objects}, of which {touching} are hidden by less than {DELTA} mm somewhere",
            True,
        ],
        *(
            [f"{name} as by calc_gt_info.py", f"at most {off:.2f} of what is allowed ({place})", off <= 1.0]
            for name, (off, place) in sorted(worst.items())
        ),
    ]


def _off(our: dict, their: dict, hidden: int) -> list:
    """Return how far values are off, in parts of what is allowed: 1 % and 8 pixels, a hundredth, a pixel."""
    found = [
        (name, abs(our[name] - their[name]) / (0.01 * their[name] + 8 + more))
        for name, more in (("px_count_all", 0), ("px_count_valid", 0), ("px_count_visib", hidden))
    ]
    allowed = 0.01 + hidden / max(their["px_count_all"], 1)
    found.append(("visib_fract", abs(our["visib_fract"] - their["visib_fract"]) / allowed))
    for name in ("bbox_obj", "bbox_visib"):
        (x, y, width, height), (left, top, wide, high) = our[name], their[name]
        ends = (x - left, y - top, x + width - left - wide, y + height - top - high)
        found.append((name, 0.0 if hidden else float(max(map(abs, ends)))))
    return found


def _scores(folder: Path, split: str) -> list:
    """Score the ground truth as a prediction, by eval_bop19_pose.py."""
    kind = split.split("_")
    results = "gt_" + "-".join([NAME, *kind])
    _run("enumerate_test_targets.py", dataset=NAME, dataset_split="", dataset_split_type=None,
         min_visib_fract=0.1, im_subset_filename=None, test_targets_filename=TARGETS)  # fmt: skip
    _run("create_pose_results_file_from_gt.py", "--dataset", NAME, "--split", kind[0], "--targets_filename", TARGETS)
    (made,) = folder.glob("*_pose.csv")
    made.rename(folder / f"{results}.csv")
    # The script starts one process for each threshold; here they are calls.
    subprocess.call = lambda command: _run(Path(command[1]).name, *command[2:]) or 0
    _run("eval_bop19_pose.py", "--result_filenames", f"{results}.csv", "--num_workers", "1")
    scores = json.loads((folder / results / "scores_bop19.json").read_text())
    targets = sum(each["inst_count"] for each in json.loads((folder / NAME / TARGETS).read_text()))
    return [
        [f"{name} of the ground truth", f"{value:.6f} of {targets} objects", value == 1.0]
        for name, value in scores.items()
        if "recall" in name
    ]


if __name__ == "__main__":
    main()
