"""Every public name of omni.replicator.core 1.12, with signature, return kind and section of our specification.

The table is the text blocks below, one name per line: `path(parameters) -> return kind`, below the block's module.

- `4.2 ` before a line of a name that exists in 1.12 too: parameters that scripts for 4.2 pass, which must be accepted.
- `6.0 ` likewise for what 6.0 added; before a name of its own: a name that 6.0 added.
- Parameters after `*` are those whose order the specification does not give; `_x` is one whose name it does not give;
  `**_more` says that there may be further ones.
- A default of `...` is one that the specification does not give, or the absence of one.
- A name without parentheses is a value, a property, or a function whose parameters the specification does not give.
"""

from __future__ import annotations

POSE = "position=None, scale=None, rotation=None, look_at=None, look_at_up_axis=None"
PRIM = (
    "position=None, scale=None, pivot=None, rotation=None, look_at=None, look_at_up_axis=None, semantics=None, "
    "material=None, visible=True, as_mesh=True, count=1, name=None, parent=None"
)
LENS = (
    "focal_length=24.0, focus_distance=400.0, f_stop=0.0, horizontal_aperture=20.955, horizontal_aperture_offset=0.0, "
    "vertical_aperture_offset=0.0, clipping_range=(1.0, 1000000.0), projection_type='pinhole', "
    "fisheye_nominal_width=1936.0, fisheye_nominal_height=1216.0, fisheye_optical_centre_x=970.94244, "
    "fisheye_optical_centre_y=600.37482, openCV_focal_x=731.78788, openCV_focal_y=731.78789, fisheye_max_fov=200.0, "
    "fisheye_polynomial_a=0.0, fisheye_polynomial_b=0.00245, fisheye_polynomial_c=0.0, fisheye_polynomial_d=0.0, "
    "fisheye_polynomial_e=0.0, fisheye_polynomial_f=0.0, fisheye_p0=-0.00037, fisheye_p1=-0.00074, "
    "fisheye_s0=-0.00058, fisheye_s1=-0.00022, fisheye_s2=0.00019, fisheye_s3=-0.0002, "
    "cross_camera_reference_name=None"
)
CAMERA = f"position=None, rotation=None, look_at=None, look_at_up_axis=None, {LENS}"
GET_TYPE = (
    "path_pattern=None, path_pattern_exclusion=None, semantics=None, semantics_exclusion=None, cache_result=True, "
    "name=None, path_match=None"
)
COCO_WRITER = (
    "output_dir, semantic_types=None, coco_categories=None, s3_bucket=None, s3_region=None, s3_endpoint=None, "
    "dataset_id=None, frame_padding=4, image_output_format='png', coco_license_info=None"
)
KITTI_WRITER = (
    "output_dir, s3_bucket=None, s3_region=None, s3_endpoint=None, semantic_types=None, omit_semantic_type=False, "
    "bbox_height_threshold=25, partly_occluded_threshold=0.5, fully_visible_threshold=0.95, renderproduct_idxs=None, "
    "mapping_path=None, mapping_dict=None, colorize_instance_segmentation=False, semantic_filter_predicate=None, "
    "use_kitti_dir_names=False"
)
COSMOS_WRITER = (
    "backend=None, output_dir=None, segmentation_mapping=None, use_instance_id=True, canny_threshold_low=10, "
    "canny_threshold_high=100"
)
REGISTER = "register(fn, override=True, fn_name=None)"
TYPES_OF_PRIMS = [
    "camera", "curve", "geomsubset", "graph", "light", "listener", "material", "mesh", "physics", "renderproduct",
    "rendervar", "scope", "shader", "shape", "skelanimation", "skeleton", "sound", "xform",
]  # fmt: skip

TABLE: list[tuple[str, str, str]] = []  # (section, module, lines)


def block(section: str, module: str, lines: str) -> None:
    TABLE.append((section, module, lines))


# ---------------------------------------------------------------------------------------------------- a.1 top level

block(
    "a.1",
    "",
    f"""
    module annotators
    module annotators_default
    module augmentations_default
    module backends
    module create
    module distribution
    module example
    module functional
    module get
    module modify
    module orchestrator
    module physics
    module randomizer
    module settings
    module trigger
    module utils
    module writers
    module writers_default
    module rng
    module vp_manager
    class AnnotatorRegistry
    class NodeConnectionTemplate
    class BackendDispatch
    class Writer
    class WriterRegistry
    class WriterRegistryError
    class BasicWriter
    class CocoWriter({COCO_WRITER})
    class KittiWriter({KITTI_WRITER})
    class FPSWriter()
    class CosmosWriter({COSMOS_WRITER})
    create_mesh_decal
    get_global_seed() -> number
    set_global_seed(seed) -> none
    new_layer(name=None) -> context
    open_stage(path) -> stage
    """,
)
block(
    "a.1",
    "rng",
    """
    class ReplicatorRNG(seed=None, node=None)
    ReplicatorRNG.generator
    ReplicatorRNG.seed
    ReplicatorRNG.initialize(seed, node, node_id)
    ReplicatorRNG.reset() -> none
    """,
)
block(
    "a.1",
    "import",
    """
    omni.replicator.core
    omni.replicator.core.scripts.annotators
    omni.replicator.core.scripts.backends:BackendDispatch
    omni.replicator.core.scripts.backends:BackendGroup
    omni.replicator.core.scripts.backends:BaseBackend
    omni.replicator.core.scripts.functional:utils
    omni.replicator.core.scripts.utils:ReplicatorItem
    omni.replicator.core.scripts.utils:ReplicatorWrapper
    omni.replicator.core.scripts.utils:create_node
    omni.replicator.core.scripts.utils:set_target_prims
    omni.replicator.core.scripts.utils.utils:auto_connect
    omni.replicator.core.scripts.utils.utils:_disconnect
    omni.replicator.core.scripts.utils.utils:create_node
    omni.replicator.core.scripts.writers_default.basicwriter:BasicWriter
    """,
)

# ------------------------------------------------------------------------------------------------ the graph's families

block(
    "a.2",
    "create",
    f"""
    sphere({PRIM}) -> item
    torus({PRIM}) -> item
    disk({PRIM}) -> item
    plane({PRIM}) -> item
    cube({PRIM}) -> item
    cylinder({PRIM}) -> item
    cone({PRIM}) -> item
    xform({POSE}, semantics=None, visible=True, count=1, name=None, parent=None) -> item
    camera({CAMERA}, count=1, parent=None, name=None) -> item
    6.0 camera(tick_rate=...)
    stereo_camera(stereo_baseline, {CAMERA}, count=1, name=None, parent=None) -> item
    light({POSE}, light_type='Distant', color=(1, 1, 1), intensity=1000.0, exposure=None, temperature=6500, \
        texture=None, count=1, name=None, parent=None) -> item
    render_product(camera, resolution, force_new=False, name=None, render_vars=None) -> product
    render_product_tiled(cameras, tile_resolution, force_new=False, name=None) -> product
    tiled_sensor
    from_usd(usd, {POSE}, semantics=None, count=1, name='Ref', parent=None) -> item
    4.2 from_usd(usd, semantics=None, count=1)
    from_dir(dir_path, recursive=False, path_filter=None, semantics=None) -> item
    group(items, semantics=None, name=None) -> item
    material_omnipbr(diffuse=None, diffuse_texture=None, roughness=None, roughness_texture=None, metallic=None, \
        metallic_texture=None, specular=None, emissive_color=None, emissive_texture=None, emissive_intensity=0.0, \
        project_uvw=False, semantics=None, count=1) -> item
    mdl_from_json(material_def=None, material_def_path=None) -> item
    projection_material(proxy_prim, semantics=None, material=None, offset_scale=0.01, input_prims=None, name=None) \
        -> item
    mesh_decal(decal=..., material=..., texture_group=..., diffuse=..., normal=..., roughness=..., metallic=..., \
        opacity=..., semantics=..., position=(0, 0, 0), rotation=..., scale=(1, 1, 1), offset_normal=0.1, \
        offset_depth=0.0, input_prims=..., name=...) -> item
    {REGISTER}
    """,
)
block(
    "a.2",
    "HydraTexture",
    """
    path
    hydra_texture
    destroy()
    hydra_texture.set_updates_enabled
    hydra_texture.get_render_product_path() -> string
    hydra_texture.width
    hydra_texture.height
    """,
)
block(
    "a.3",
    "get",
    """
    prims(path_pattern=None, path_match=None, path_pattern_exclusion=None, prim_types=None, \
        prim_types_exclusion=None, semantics=None, semantics_exclusion=None, cache_result=True, ignore_case=True, \
        name=None) -> item
    """
    + "\n".join(f"{kind}({GET_TYPE}) -> item" for kind in TYPES_OF_PRIMS)
    + """
    prim_at_path(path, name=None) -> item
    normalized_decal_position
    register(func, override=True, fn_name=None)
    """,
)
block(
    "a.4",
    "distribution",
    f"""
    uniform(lower, upper, num_samples=1, seed=None, name=None) -> item
    normal(mean, std, num_samples=1, seed=None, name=None) -> item
    log_uniform(lower, upper, num_samples=1, seed=None, name=None) -> item
    choice(choices, weights=None, num_samples=1, seed=-1, with_replacements=True, name=None) -> item
    sequence(items, ordered=True, seed=-1, name=None, stride=None) -> item
    combine(distributions, name=None) -> item
    {REGISTER}
    """,
)
block(
    "a.5",
    "modify",
    f"""
    semantics(semantics=None, input_prims=None, mode='add') -> item
    4.2 semantics(semantics=None, input_prims=None)
    pose(position=None, position_x=None, position_y=None, position_z=None, rotation=None, rotation_x=None, \
        rotation_y=None, rotation_z=None, rotation_order='XYZ', scale=None, size=None, pivot=None, look_at=None, \
        look_at_up_axis=None, input_prims=None, name=None) -> item
    pose_camera_relative(camera, render_product, distance, horizontal_location=0, vertical_location=0, \
        input_prims=None) -> item
    pose_orbit(barycentre, distance, azimuth, elevation, look_at_barycentre=True, input_prims=None) -> item
    attribute(name, value, attribute_type=None, input_prims=None) -> item
    visibility(value=None, input_prims=None, name=None) -> item
    variant(name, value, input_prims=None) -> item
    material(value, input_prims=None, name=None) -> item
    animation(values, reset_timeline=False, input_prims=None) -> item
    projection_material(position=None, rotation=None, scale=None, texture_group=None, diffuse=None, normal=None, \
        roughness=None, metallic=None, input_prims=None, name=None) -> item
    timeline(value, modify_type=...) -> item
    time(value) -> item
    frame(value) -> item
    {REGISTER}
    """,
)
block(
    "a.6",
    "randomizer",
    f"""
    scatter_2d(surface_prims, no_coll_prims=None, min_samp=(None,)*3, max_samp=(None,)*3, seed=None, offset=0, \
        check_for_collisions=False, input_prims=None, name=None) -> item
    scatter_3d(volume_prims=None, no_coll_prims=None, volume_excl_prims=None, min_samp=(None,)*3, \
        max_samp=(None,)*3, resolution_scaling=1.0, voxel_size=0.0, check_for_collisions=False, \
        prevent_vol_overlap=True, viz_sampled_voxels=False, seed=None, input_prims=None, name=None) -> item
    materials(materials, seed=None, max_cached_materials=0, input_prims=None, name=None) -> item
    instantiate(paths, size, weights=None, mode='scene_instance', with_replacements=True, seed=None, name=None, \
        use_cache=True, semantics=None) -> item
    rotation(min_angle=(-180,)*3, max_angle=(180,)*3, seed=None, input_prims=None) -> item
    texture(textures, texture_scale=None, texture_rotate=None, per_sub_mesh=False, project_uvw=False, seed=None, \
        input_prims=None) -> item
    color(colors, per_sub_mesh=False, seed=None, input_prims=None) -> item
    {REGISTER}
    """,
)
block(
    "a.7",
    "trigger",
    f"""
    on_frame(interval=1, num_frames=0, name='on_frame', rt_subframes=1, max_execs=0) -> item
    4.2 on_frame(interval=1, num_frames=0, name='on_frame', rt_subframes=1)
    on_time(interval=1, num=0, name='on_time', rt_subframes=32, enable_capture_on_play=True, reset_physics=True, \
        max_execs=0) -> item
    4.2 on_time(interval=1, num=0, name='on_time', rt_subframes=32, enable_capture_on_play=True, reset_physics=True)
    on_time_end(interval=1, name='on_time_end', rt_subframes=32, enable_capture_on_play=True, max_execs=0) -> item
    on_key_press(key, modifier=None, name=None) -> item
    on_custom_event(event_name) -> item
    on_condition(condition, max_execs=0, rt_subframes=1) -> item
    {REGISTER}
    """,
)
block(
    "a.8",
    "physics",
    """
    rigid_body(velocity=(0, 0, 0), angular_velocity=None, contact_offset=None, rest_offset=None, overwrite=False, \
        physics_scene=None, input_prims=None) -> item
    4.2 rigid_body(velocity=(0, 0, 0), angular_velocity=None, contact_offset=None, rest_offset=None, input_prims=None)
    collider(approximation_shape='convexHull', contact_offset=None, rest_offset=None, physics_scene=None, \
        input_prims=None) -> item
    mass(mass=None, density=None, center_of_mass=None, diagonal_inertia=None, principal_axes=None, \
        input_prims=None) -> item
    drive_properties(stiffness=0.0, damping=0.0, input_prims=None) -> item
    physics_material(static_friction=None, dynamic_friction=None, restitution=None, input_prims=None) -> item
    simulate(time, step_dt=None, physics_scene=None)
    reset(physics_scene=None)
    """,
)

# -------------------------------------------------------------------------------------------------- running and helpers

RUN = "num_frames=None, start_timeline=False"
STEP = "rt_subframes=-1, pause_timeline=True, delta_time=None, wait_for_render=True"
block(
    "a.9",
    "orchestrator",
    f"""
    run({RUN})
    async run_async({RUN})
    run_until_complete({RUN})
    async run_until_complete_async({RUN})
    step({STEP})
    async step_async({STEP})
    4.2 step(rt_subframes=-1, pause_timeline=True, delta_time=None)
    4.2 step_async(rt_subframes=-1, pause_timeline=True, delta_time=None)
    stop()
    async stop_async()
    pause()
    resume()
    preview()
    async preview_async()
    wait_until_complete()
    async wait_until_complete_async()
    get_is_started() -> bool
    get_is_paused() -> bool
    get_is_stopped() -> bool
    get_status() -> status
    get_sim_times_to_write
    register_status_callback(_callback) -> callback
    set_next_rt_subframes(_count) -> none
    set_minimum_next_rt_subframes(_count) -> none
    set_capture_on_play(_value) -> none
    class OrchestratorError
    class Status
    Status.STOPPED = 0
    Status.STARTED = 1
    Status.STARTING = 2
    Status.LOADING = 3
    Status.STOPPING = 4
    Status.PAUSED = 5
    Status.INITIALIZING = 6
    Status.STEPPING = 7
    Status.STEPPED = 8
    class StatusCallback
    StatusCallback.register()
    StatusCallback.unregister()
    """,
)
block(
    "a.10",
    "settings",
    """
    carb_settings(setting, value)
    get_physx_timestep() -> number
    set_physx_timestep(physx_delta_time) -> none
    set_render_rtx_realtime(antialiasing='FXAA') -> none
    set_render_pathtraced(samples_per_pixel=64) -> none
    set_stage_meters_per_unit(_value) -> none
    set_stage_up_axis(_axis) -> none
    RENDER_MODE
    REALTIME_ANTIALIASING
    PATHTRACED_TOTAL_SAMPLES_PER_PIXEL
    """,
)
block(
    "a.11",
    "utils",
    """
    compute_aabb(bbox_cache, prim, include_children=True)
    create_node(node_type_id, graph=None, node_name=None, input_prims=None, **attributes)
    find_prims(prim_paths, mode='instances') -> list
    get_files_group(folder_path, file_suffixes=None, ignore_case=True, file_type='png')
    get_graph(graph_path=None, is_hidden=False)
    get_node_targets(node, attribute, replicatorXform=True) -> list
    get_non_xform_prims(prim_paths, usd_usdrt=False) -> list
    get_prim_variant_values(prim_path, variant_name) -> list
    get_prims_from_paths(prim_paths) -> list
    get_replicator_graph_exists() -> bool
    get_usd_files(path, recursive=False, path_filter=None) -> list
    legacy_semantics_arg_to_new(legacy_semantics_arg)
    parse_semantics(prim)
    read_prim_transform(prim)
    send_og_event(event_name) -> none
    set_target_prims(node, attribute, target_prims)
    sequential() -> context
    ReplicatorWrapper
    auto_connect(upstream_node, downstream_node, mapping=None, no_exec=False)
    look_at(target, look_at_up_axis=(0, 1, 0), eye=(0, 0, 0), stage_up_axis='Y', use_usdrt=False)
    select_rotation_op(prim)
    set_rotation_by_op(prim, rotation_op, rotation_value)
    create_material(mtl_url, mtl_name, mtl_path)
    is_camera_prim(prim)
    get_reduced_ref_time(numerator, denominator)
    GRAPH_PATH
    REPLICATOR_SCOPE
    open_stage(path)
    """,
)
block(
    "b.4",
    "utils",
    """
    class ReplicatorItem
    ReplicatorItem.node
    ReplicatorItem.inputs
    ReplicatorItem.outputs
    ReplicatorItem.get_inputs()
    ReplicatorItem.get_outputs()
    ReplicatorItem.get_input(name)
    ReplicatorItem.set_input(name, value)
    ReplicatorItem.get_output(name)
    ReplicatorItem.get_input_prims() -> dict
    ReplicatorItem.get_output_prims() -> dict
    ReplicatorItem.__enter__()
    ReplicatorItem.__exit__
    """,
)

# ------------------------------------------------------------------------------------------------- annotators, writers

GET_ANNOTATOR = "(name, init_params=None, render_product_idxs=None, device=None, do_array_copy=True) -> annotator"
AUGMENT = "augmentation, data_out_shape=None, name=None, device=None, **kw"
block(
    "a.12",
    "annotators",
    f"""
    get{GET_ANNOTATOR}
    get_augmentation(name) -> augmentation
    get_registered_annotators() -> list
    register(name, annotator)
    register_augmentation(name, augmentation)
    unregister_augmentation(name)
    augment(source_annotator, {AUGMENT}) -> annotator
    augment_compose(source_annotator, augmentations, name=None) -> annotator
    class AnnotatorError
    class AnnotatorRegistryError
    class AugmentationError
    class Annotator
    Annotator.attach(render_products, render_product_idxs=None) -> annotator
    Annotator.detach(render_products=None)
    Annotator.get_data(device=None, do_array_copy=False, use_legacy_structure=True)
    Annotator.initialize(**init_params)
    Annotator.augment({AUGMENT}) -> annotator
    Annotator.augment_compose(augmentations, name=None) -> annotator
    Annotator.get_name() -> string
    Annotator.get_node()
    Annotator.name
    Annotator.is_attached
    Annotator.documentation
    Annotator.template_name
    class Augmentation(node_type_id, data_out_shape=None, documentation=None, **kw)
    Augmentation.from_function(_function, data_out_shape=None, documentation=None, **kw) -> augmentation
    Augmentation.from_node(node_type_id, attributes_mapping=None, data_out_shape=None, documentation=None, **kw) \
        -> augmentation
    Augmentation.apply(annotator, name=None, **kw)
    """,
)
block(
    "a.12",
    "AnnotatorRegistry",
    f"""
    get_annotator{GET_ANNOTATOR}
    get_registered_annotators() -> list
    register_annotator_from_node(name, input_rendervars, node_type_id, init_params=None, render_product_idxs=(0,), \
        output_rendervars=None, output_data_type=None, output_is_2d=False, output_channels=1, is_gpu_enabled=True, \
        hidden=False, on_attach_callback=None, documentation=None)
    register_annotator_from_aov(aov, output_data_type=None, output_channels=1, on_attach_callback=None, name=None, \
        is_gpu_enabled=True, documentation=None)
    register_augmentation
    unregister_annotator(name)
    detach(annotator, render_products)
    _default_annotators
    """,
)
block(
    "a.12",
    "augmentations_default",
    """
    aug_rgb_to_hsv
    aug_hsv_to_rgb
    """,
)
block(
    "a.12",
    "augmentation",
    """
    rgba_to_rgb
    RgbaToRgb
    ColorizeDepth
    ColorizeNormals
    Sobel
    Canny
    adjust_sigmoid
    brightness
    speckle_noise
    shot_noise
    rgb_to_hsv
    hsv_to_rgb
    glass_blur
    BgRand
    Contrast
    Conv2d
    CropResize
    CutMix
    ImgBlend
    MotionBlur
    Pixellate
    Rotate
    """,
)
# Parameters of the annotators for which section b.2 gives them; those of the others are not checked.
LABELED = "semanticTypes=..., semanticFilter=..."
COLORIZED = "colorize=..., mapping=..., semanticFilter=..."
block(
    "b.2",
    "annotator",
    f"""
    rgb
    LdrColor
    HdrColor
    normals
    distance_to_camera
    distance_to_image_plane
    motion_vectors
    MotionVectors
    cross_correspondence
    CrossCorrespondence
    semantic_segmentation({COLORIZED})
    instance_segmentation({COLORIZED})
    instance_segmentation_fast({COLORIZED})
    instance_id_segmentation({COLORIZED})
    instance_id_segmentation_fast({COLORIZED})
    shaded_semantic_segmentation
    shaded_instance_segmentation
    shaded_instance_id_segmentation
    bounding_box_2d_tight({LABELED})
    bounding_box_2d_tight_fast({LABELED})
    bounding_box_2d_loose({LABELED})
    bounding_box_2d_loose_fast({LABELED})
    bounding_box_3d({LABELED})
    bounding_box_3d_fast({LABELED})
    bounding_box_3d_360({LABELED})
    occlusion
    camera_params
    CameraParams
    pointcloud(includeUnlabelled=False)
    skeleton_data(useSkelJoints=...)
    ReferenceTime
    Attribute(prims=..., attribute=...)
    primPaths
    fabricTime
    rpFabricTime
    DiffuseAlbedo
    Roughness
    SpecularAlbedo
    AmbientOcclusion
    DirectDiffuse
    DirectSpecular
    IndirectDiffuse
    SmoothNormal
    BumpNormal
    Motion2d
    Reflections
    DepthLinearized
    EmissionAndForegroundMask
    PtDirectIllumation
    PtGlobalIllumination
    PtReflections
    PtRefractions
    PtSelfIllumination
    PtBackground
    PtWorldNormal
    PtWorldPos
    PtZDepth
    PtVolumes
    PtDiffuseFilter
    PtReflectionFilter
    PtRefractionFilter
    PtMultiMatte0
    PtMultiMatte1
    PtMultiMatte2
    PtMultiMatte3
    PtMultiMatte4
    PtMultiMatte5
    PtMultiMatte6
    PtMultiMatte7
    DepthSensorDistance
    DepthSensorPointCloudPosition
    DepthSensorPointCloudColor
    DepthSensorImager
    RtxSensorCpu
    RtxSensorGpu
    GenericModelOutput
    RtxSensorMetadata
    StableIdMap
    IsaacNoop
    IsaacReadSimulationTime(resetOnStop=...)
    IsaacReadSystemTime
    LdrColorIsaacConvertRGBAToRGB
    DistanceToImagePlaneSDIsaacConvertDepthToPointCloud
    """,
)
GET_WRITER = "get({name}, init_params=None, render_products=None, trigger=...) -> writer"
block(
    "a.13",
    "writers",
    f"""
    {GET_WRITER.format(name="name")}
    register_writer(cls, category=None)
    unregister_writer(name)
    register_node_writer(name, node_type_id, annotators, category=None, **kw)
    """,
)
block(
    "a.13",
    "WriterRegistry",
    f"""
    register(writer, category=None)
    register_node_writer
    unregister
    unregister_writer
    {GET_WRITER.format(name="writer_name")}
    get_writers(category=None)
    attach
    detach(writer_name, render_products=None)
    detach_all()
    get_attached_writer
    get_attached_writers
    get_annotators
    get_writer_render_products
    _default_writers
    """,
)
ATTACH = "render_products, trigger='omni.replicator.core.OgnOnFrame'"
block(
    "a.13",
    "Writer",
    f"""
    backend = None
    version = '0.0.0'
    annotators
    metadata
    num_written
    data_structure = 'legacy'
    write(data)
    on_final_frame()
    initialize(**kwargs)
    attach({ATTACH})
    async attach_async({ATTACH})
    detach()
    schedule_write()
    get_data()
    get_annotators()
    get_annotator(name)
    get_attached_annotators()
    add_annotator(annotator, name=None)
    augment_annotator(annotator_name, augmentation, **kw)
    get_metadata() -> dict
    write_metadata()
    get_node()
    reset()
    """,
)
block(
    "a.14",
    "backends",
    """
    get(name, init_params=None) -> backend
    register(_class)
    unregister(name)
    class BackendRegistry
    BackendRegistry.register_backend
    BackendRegistry.unregister_backend
    BackendRegistry.get_backend
    BackendRegistry.get_registered_backends
    class BaseBackend
    BaseBackend.initialize(**kw)
    BaseBackend.write_blob(path, data)
    BaseBackend.read_blob(path)
    BaseBackend.schedule(_function, *args, **kw)
    BaseBackend.is_done_writing() -> bool
    BaseBackend.wait_until_done() -> none
    BaseBackend.get_name() -> string
    class DiskBackend(output_dir, overwrite=True)
    DiskBackend.output_dir
    DiskBackend.resolve_path(path)
    class S3Backend(bucket, key_prefix, region=None, endpoint_url=None, overwrite=False)
    class BackendGroup(backends)
    class BackendDispatch(config=None, *, output_dir=..., key_prefix=..., bucket=..., region=..., endpoint_url=..., \
        overwrite=...)
    BackendDispatch.write_image
    BackendDispatch.write_array
    BackendDispatch.write_exr
    BackendDispatch.write_blob
    BackendDispatch.schedule
    BackendDispatch.set_max_queue_size
    io_queue
    io_queue.is_done_writing
    io_queue.wait_until_done
    io_queue.set_max_queue_size
    """,
)

# ---------------------------------------------------------------------------------------------------- immediate mode

PLACE = f"{POSE}, pivot=None, relative_to=None, semantics=None, visible=True"
PLACE_OF_CYLINDER = f"{POSE}, pivot=None, relative_to=None, semantics=None, as_mesh=True, visible=True"
LIGHT = (
    "color=(1, 1, 1), intensity=30000.0, exposure=None, color_temperature=6500, enable_color_temperature=False, "
    "diffuse=1.0, specular=1.0, shaping_cone_angle=180.0, shaping_cone_softness=0.0, shaping_focus_tint=(1, 1, 1)"
)
DOME = (
    "color=(1, 1, 1), texture=None, texture_format='latlong', intensity=1000.0, exposure=1.0, diffuse=1.0, "
    "specular=1.0, color_temperature=6500, enable_color_temperature=False"
)


def immediate(count: str, returns: str) -> str:
    """The lines of functional.create, or of functional.create_batch, which has `count` before `name`.

    Orders are those of Replicator's sources, 1.12.27.
    """
    end = f"{count}name=None, parent=None"
    places = {
        **dict.fromkeys(["plane", "torus", "disk"], PLACE),
        **dict.fromkeys(["sphere", "cube", "cone", "capsule"], f"{PLACE}, as_mesh=True"),
        "cylinder": PLACE_OF_CYLINDER,
    }
    shapes = "".join(
        f"{'6.0 ' if shape == 'capsule' else ''}{shape}({place}, {end}, material=None) -> {returns}\n"
        for shape, place in places.items()
    )
    sizes = {
        "sphere_light": "radius=1.0",
        "disk_light": "radius=1.0",
        "rect_light": "height=1.0, width=1.0",
        "cylinder_light": "radius=1.0, length=1.0",
        "distant_light": "angle=1.0",
    }
    lights = "".join(f"{light}({PLACE}, {LIGHT}, {size}, {end}) -> {returns}\n" for light, size in sizes.items())
    of_clones, dome = ("semantics=None, visible=True, ", f"{POSE}, {DOME}") if count else ("", f"{DOME}, {POSE}")
    return (
        f"""
        scope({end}) -> {returns}
        clone(path, {POSE}, pivot=None, relative_to=None, {of_clones}{end}) -> {returns}
        xform({PLACE}, {end}, material=None) -> {returns}
        camera({POSE}, relative_to=None, {LENS}, {end}) -> {returns}
        reference(usd_path, prim_path=None, {PLACE}, {end}) -> {returns}
        dome_light({dome}, {end}) -> {returns}
        material(mdl, bind_prims=None, {end}, **inputs) -> {returns}
        """
        + shapes
        + lights
    )


block("a.15", "functional.create", immediate("", "prim") + "omni_lidar\nomni_radar\n")
block("a.15", "functional.create_batch", immediate("count=1, ", "list"))
block(
    "a.15",
    "functional",
    """
    module create
    module create_batch
    module modify
    module randomizer
    module physics
    module get
    6.0 module utils
    write_image(path, data, backend_instance=..., **kw)
    write_png(path, data, backend_instance=..., *, compress_level=3, **_more)
    write_jpeg(path, data, backend_instance=..., *, quality=75, **_more)
    write_exr(path, data, backend_instance=..., *, half_precision=False, **_more)
    write_json(path, data, backend_instance=..., **_more)
    write_np(path, data, backend_instance=..., *, allow_pickle=True, **_more)
    write_pickle(path, data, backend_instance=..., **_more)
    read_exr
    6.0 utils.get_world_transform(prim)
    6.0 utils.get_world_position(prim)
    """,
)
block(
    "a.15",
    "functional.modify",
    """
    pose(prims, position_value=None, rotation_value=None, rotation_order=..., scale_value=None, relative_to=None, \
        look_at_value=None, look_at_up_axis=(0, 1, 0), pivot=None)
    6.0 pose(write_to_usd=...)
    position(prims, value, relative_to=None, pivot=None)
    rotation(prims, value, value_rotation_order='XYZ', relative_to=None, pivot=None)
    scale(prims, value)
    look_at(prims, value, look_at_up_axis=(0, 1, 0))
    attribute(prims, attribute_name, value)
    semantics(prims, value, mode='add')
    visibility(prims, value)
    material(prims, material_prim)
    """,
)
block(
    "a.15",
    "functional.randomizer",
    """
    scatter_2d(prims, surface_prims, no_collision_prims=None, extents=None, offset=0.0, check_for_collisions=False, \
        rng=None)
    scatter_3d(prims, volume_prims=None, no_collision_prims=None, volume_excl_prims=None, extents=None, \
        check_for_collisions=False, prevent_vol_overlap=True, viz_sampled_voxels=False, resolution_scaling=1.0, \
        input_voxel_size=0.0, rng=None)
    6.0 display_color(prims, rng=None)
    """,
)
block(
    "a.15",
    "functional.physics",
    """
    create_physics_scene(path='/PhysicsScene', **attributes)
    simulate(time, step_dt=..., physics_scene=None)
    apply_rigid_body(prims, physics_scene=None, overwrite_rigid_body=True, with_collider=True, approximation=None, \
        **attributes)
    apply_collider(prims, physics_scene=None, approximation=..., **attributes)
    remove_rigid_body(prims)
    remove_collider(prims)
    put_to_sleep(prims)
    wake_up(prims)
    reset(prims)
    modify_attribute(prims, attribute_name, value)
    create_camera_collision_prims(camera_prim, camera_coll_radius=0.02, camera_coll_view_dist=0.4)
    """,
)
# Nothing is cached and no node is named in immediate mode: "stage first and ignore_case=False".
FIND = "path_pattern=None, path_pattern_exclusion=None, semantics=None, semantics_exclusion=None"
block(
    "a.15",
    "functional.get",
    """
    prims(stage, path_pattern=None, path_match=None, path_pattern_exclusion=None, prim_types=None, \
        prim_types_exclusion=None, semantics=None, semantics_exclusion=None, ignore_case=False) -> list
    prim_at_path
    prim_at_paths(stage, paths) -> list
    """
    + "\n".join(f"{kind}(stage, {FIND}, path_match=None, ignore_case=False) -> list" for kind in TYPES_OF_PRIMS),
)

# --------------------------------------------------------------------------------------------------------------- YAML

block(
    "b.9",
    "import",
    """
    omni.replicator.replicator_yaml
    omni.replicator.replicator_yaml:parse
    omni.replicator.replicator_yaml:ParserError
    """,
)
