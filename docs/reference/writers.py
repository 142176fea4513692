# %% setting
import usdsdg as rep

rep.create.light(light_type="Dome", intensity=400)
rep.create.plane(scale=10)
rep.create.cube(position=(0, 0.3, 0.5), semantics=[("class", "crate")])
rep.create.sphere(position=(0.9, -0.5, 0.4), scale=0.8, semantics=[("class", "ball")])
camera = rep.create.camera(position=(4, 0, 2), look_at=(0, 0, 0.4), clipping_range=(0.1, 100))
view = rep.create.render_product(camera, (64, 48))


def write(name, **options):
    """Write one frame with a writer."""
    writer = rep.writers.get(name)
    writer.initialize(**options)
    writer.attach(view)
    rep.orchestrator.step()
    rep.orchestrator.wait_until_complete()
    writer.detach()


# %% BasicWriter
write("BasicWriter", output_dir="basic", rgb=True, bounding_box_2d_tight=True, distance_to_camera=True)

# %% CocoWriter
write("CocoWriter", output_dir="coco", splits={"train": 0.8, "val": 0.2}, panoptic=True)

# %% YoloWriter
write("YoloWriter", output_dir="yolo", task="segment", min_visibility=0.1)

# %% BopWriter
write("BopWriter", output_dir="bop", depth_scale=0.1)

# %% KittiWriter
write("KittiWriter", output_dir="kitti", plain_names=True)

# %% VocWriter
write("VocWriter", output_dir="voc", image_output_format="png")

# %% CvatWriter
write("CvatWriter", output_dir="cvat", shape="polygon")

# %% PoseWriter
write("PoseWriter", output_dir="poses", exact_camera_frame=True, write_debug_images=True)

# %% DOPEWriter
write("DOPEWriter", output_dir="dope", class_name_to_index_map={"crate": 0, "ball": 1}, exact=True)

# %% YCBVideoWriter
write(
    "YCBVideoWriter",
    output_dir="ycb",
    num_frames=1,
    class_name_to_index_map={"crate": 1, "ball": 2},
    exact=True,
    rgb=True,
    bounding_box_2d_tight=True,
    semantic_segmentation=True,
    distance_to_image_plane=True,
    pose=True,
)

# %% WebDatasetWriter
write("WebDatasetWriter", output_dir="shards", masks=True, shard_samples=1000)

# %% ParquetWriter
write("ParquetWriter", output_dir="parquet")  # with pip install 'usdsdg[parquet]'

# %% CosmosWriter
write("CosmosWriter", output_dir="cosmos")

# %% DataVisualizationWriter
write("DataVisualizationWriter", output_dir="drawn", bounding_box_2d_tight=True, bounding_box_3d=True)

# %% RerunWriter
write("RerunWriter", output_dir="rerun")  # with pip install 'usdsdg[rerun]'

# %% FPSWriter
write("FPSWriter")  # prints the rate of frames

# %% PytorchWriter
try:
    write("PytorchWriter", listener=None)  # needs a listener, and PyTorch; usdsdg.stream is the way without
except rep.errors.UsdsdgError as error:
    print(error)
