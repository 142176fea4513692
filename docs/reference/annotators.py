# %% setting
import numpy as np
from PIL import Image

import usdsdg as rep

rep.create.light(light_type="Dome", intensity=400)
rep.create.plane(scale=10)
crate = rep.create.cube(position=(0, 0.3, 0.5), semantics=[("class", "crate")])
ball = rep.create.sphere(position=(0.9, -0.3, 0.4), scale=0.8, semantics=[("class", "ball")])
camera, other = (rep.create.camera(position=(4, y, 2), look_at=(0, 0, 0.4), clipping_range=(0.1, 100)) for y in (0, 1))
view, second = (rep.create.render_product(each, (64, 48)) for each in (camera, other))


def get(name, **init_params):
    """Return what an annotator gives for one frame."""
    annotator = rep.annotators.get(name, init_params=init_params or None).attach(view)
    rep.orchestrator.step()
    data = annotator.get_data()
    annotator.detach()
    return data


# %% rgb, LdrColor, LdrColorIsaacConvertRGBAToRGB
Image.fromarray(get("rgb")).convert("RGB").save("picture.png")

# %% HdrColor
radiance = get("HdrColor")[..., :3].astype(np.float32)
assert radiance.max() > 0

# %% distance_to_camera, distance_to_image_plane, DepthLinearized, PtZDepth
depth = get("distance_to_image_plane")
nearest = depth[np.isfinite(depth)].min()
assert 2 < nearest < 4

# %% pointcloud, DistanceToImagePlaneSDIsaacConvertDepthToPointCloud
points = get("pointcloud", includeUnlabelled=True)["data"]
assert points.shape[1] == 3

# %% normals, SmoothNormal, BumpNormal, PtWorldNormal
normals = get("normals")[..., :3]

# %% PtWorldPos
positions = get("PtWorldPos")[..., :3]

# %% motion_vectors, MotionVectors, Motion2d
motion = get("motion_vectors")[..., :2]  # pixels since the last frame
assert not motion.any()

# %% semantic_segmentation, instance_segmentation, instance_segmentation_fast
ids = get("semantic_segmentation")
names = ids["info"]["idToLabels"]
crates = np.isin(ids["data"], [int(key) for key, labels in names.items() if labels.get("class") == "crate"])
assert crates.any()

# %% instance_id_segmentation, instance_id_segmentation_fast
gprims = get("instance_id_segmentation")["data"]  # every gprim, labeled or not

# %% shaded_semantic_segmentation, shaded_instance_segmentation, shaded_instance_id_segmentation
Image.fromarray(get("shaded_semantic_segmentation")).save("shaded.png")

# %% bounding_box_2d_tight, bounding_box_2d_tight_fast, bounding_box_2d_loose, bounding_box_2d_loose_fast
boxes = get("bounding_box_2d_tight")
for box in boxes["data"]:
    label = boxes["info"]["idToLabels"][str(box["semanticId"])]["class"]
    print(label, box["x_min"], box["y_min"], box["x_max"] + 1, box["y_max"] + 1, box["occlusionRatio"])

# %% bounding_box_2d_amodal, truncation
whole = get("bounding_box_2d_amodal")["data"]  # also behind others, and beyond the picture's edges
assert (whole["truncationRatio"] == 0).all()

# %% oriented_bounding_box_2d, oriented_bounding_box_2d_amodal
turned = get("oriented_bounding_box_2d")["data"]

# %% bounding_box_3d, bounding_box_3d_fast, bounding_box_3d_360
box = get("bounding_box_3d")["data"][0]
corner = np.array([box["x_max"], box["y_max"], box["z_max"], 1]) @ box["transform"]  # in the world

# %% occlusion, visibility, occlusion_graph
hidden = get("visibility")
print(hidden)

# %% amodal_instance_segmentation
masks = get("amodal_instance_segmentation")["data"]  # (N, H, W): each object as if it were alone

# %% object_coordinates
coordinates = get("object_coordinates")["data"][..., :3]  # x, y, z from 0 to 1 in the object's box

# %% keypoints
prim = ball.get_output_prims()["prims"][0]
rep.functional.modify.keypoints(prim, {"top": (0, 0, 0.5)})
print(get("keypoints"))

# %% dense_correspondence
there = get("dense_correspondence", camera=second.path)["data"]  # column and row in the other picture

# %% cross_correspondence, CrossCorrespondence
beside = rep.create.camera(position=(4, 0.5, 2), look_at=(0, 0, 0.4), cross_camera_reference_name="Camera")
annotator = rep.annotators.get("cross_correspondence").attach(rep.create.render_product(beside, (64, 48)))
rep.orchestrator.step()
shift = annotator.get_data()  # pixels to where the other camera sees the same point
annotator.detach()

# %% camera_params, CameraParams
focal = get("camera_params")["cameraFocalLength"]
assert focal == 24

# %% pose, dope
poses = get("pose")

# %% skeleton_data
joints = get("skeleton_data")  # empty: there is no skeleton in view

# %% Attribute
value = get("Attribute", prims=["/Replicator/Camera_Xform/Camera"], attribute="focalLength")

# %% primPaths
paths = get("primPaths")["primPaths"]

# %% ReferenceTime, fabricTime, rpFabricTime, IsaacReadSimulationTime, IsaacReadSystemTime, IsaacNoop
seconds = get("IsaacReadSimulationTime")["simulationTime"]

# %% DiffuseAlbedo, SpecularAlbedo, Roughness, PtDiffuseFilter, PtReflectionFilter, PtRefractionFilter
albedo = get("DiffuseAlbedo")[..., :3] / 255

# %% EmissionAndForegroundMask, PtSelfIllumination, PtBackground
glow = get("PtSelfIllumination")

# %% DirectDiffuse, DirectSpecular, IndirectDiffuse, PtDirectIllumation, PtGlobalIllumination
direct, bounced = get("PtDirectIllumation"), get("PtGlobalIllumination")

# %% PtReflections, Reflections, PtRefractions, PtVolumes
mirrored = get("Reflections")

# %% AmbientOcclusion
open_sky = get("AmbientOcclusion")[..., 0]

# %% PtMultiMatte0, PtMultiMatte1, PtMultiMatte2, PtMultiMatte3
rep.settings.carb_settings("/rtx/pathtracing/multimatte/channelCount", 24)
mattes = get("PtMultiMatte0")

# %% PtMultiMatte4, PtMultiMatte5, PtMultiMatte6, PtMultiMatte7
mattes = get("PtMultiMatte4")

# %% DepthSensorDistance, DepthSensorPointCloudPosition, DepthSensorPointCloudColor
measured = get("DepthSensorDistance")  # of a simulated stereo camera, with its noise; 0 where it sees nothing

# %% DepthSensorImager, DepthSensorOutputVisualization
gray = get("DepthSensorImager")
