"""Warp structs of the scene: the device form of `scene.Scene`, and of a camera.

Colors are linear Rec.709, light in nits, lengths in stage units. `world_to_local` and `local_to_world` are 3x3
matrices for column vectors plus an offset: p_world = local_to_world @ p_local + world_origin. Large tables are held by
address (uint64), so that one prototype or texture can be added without copying the others; the owner of a record
keeps the memory alive.
"""

# Code of Warp kernels is not Python to a type checker.
# pyright: reportGeneralTypeIssues=false, reportInvalidTypeForm=false

import warp as wp


@wp.struct
class Lens:
    """Device form of `stage.cameras.lens.Lens`, without focal length and center, which are in `Camera`."""

    kind: wp.int32
    curve: wp.int32
    k0: wp.float32
    k1: wp.float32
    k2: wp.float32
    k3: wp.float32
    k4: wp.float32
    k5: wp.float32
    limit: wp.float32
    limit_value: wp.float32
    is_asymmetric: wp.int32  # 1 = with tangential or thin-prism distortion
    p1: wp.float32
    p2: wp.float32
    s1: wp.float32
    s2: wp.float32
    s3: wp.float32
    s4: wp.float32
    eye_offset: wp.float32  # stereo panorama: offset of the eye to the right of the forward direction [stage units]
    table_width: wp.int32
    table_height: wp.int32
    table: wp.uint64  # address of the table, see `lens_table`


@wp.struct
class Triangle:
    """One triangle of a prototype for shading: corners, normals, UVs, contiguous in memory."""

    p0: wp.vec3
    p1: wp.vec3
    p2: wp.vec3
    n0: wp.vec3
    n1: wp.vec3
    n2: wp.vec3
    uv0: wp.vec2
    uv1: wp.vec2
    uv2: wp.vec2
    slot: wp.int32
    face: wp.int32  # of the source mesh


@wp.struct
class Instance:
    """A prototype with a transform and materials."""

    world_to_local: wp.mat33
    local_to_world: wp.mat33
    world_origin: wp.vec3
    nodes: wp.uint64  # of the BLAS
    blocks: wp.uint64  # triangles of the BLAS: in blocks of eight on a CPU, single ones on CUDA
    triangles: wp.uint64  # Triangle records
    slot_offset: wp.int32
    casts_shadow: wp.int32
    cutout: wp.int32  # 1 = one of its materials may be transparent


@wp.struct
class Tlas:
    """Top-level acceleration structure over the instances."""

    nodes: wp.uint64  # of the TLAS
    instances: wp.array(dtype=Instance)
    instance_count: wp.int32
    order: wp.array(dtype=wp.int32)  # instances in leaf order (CUDA only)


# Material.thin; 0 = a solid body.
THIN_WALLED, CLEAR_PANE = (wp.constant(code) for code in (1, 2))


@wp.struct
class Material:
    """A material. Hosts keep arrays of it as well: `scene.MATERIAL` is its NumPy dtype.

    A texture, where there is one, is multiplied by the constant beside it. *_texture is a row of the textures or
    NO_TEXTURE; *_channel picks r g b a (0-3).
    """

    base_color: wp.vec3
    base_color_texture: wp.int32
    metallic: wp.float32
    metallic_texture: wp.int32
    metallic_channel: wp.int32
    roughness: wp.float32
    roughness_texture: wp.int32
    roughness_channel: wp.int32
    metal_f90: wp.float32  # reflectance of a metal at grazing incidence (F90): 0 = its color, 1 = white
    specular: wp.vec3  # reflectance at normal incidence of the dielectric part
    specular_texture: wp.int32
    opacity: wp.float32
    opacity_texture: wp.int32
    opacity_channel: wp.int32
    opacity_threshold: wp.float32  # > 0: cut-out; 0: stochastic transparency
    transmission: wp.float32  # fraction of the light that is not reflected which passes through, as through glass
    ior: wp.float32  # index of refraction of the glass
    thin: wp.int32  # THIN_WALLED: without refraction; CLEAR_PANE: also without roughness and tint
    emission: wp.vec3  # nits
    emission_texture: wp.int32
    normal_texture: wp.int32  # tangent space; texel * 2 - 1
    normal_scale: wp.float32
    detail_texture: wp.int32  # a second normal map, whose slopes are added
    detail_scale: wp.float32
    coat_f0: wp.float32  # reflectance at normal incidence of the coat
    clearcoat: wp.float32
    clearcoat_texture: wp.int32
    clearcoat_channel: wp.int32
    clearcoat_roughness: wp.float32
    clearcoat_roughness_texture: wp.int32
    clearcoat_roughness_channel: wp.int32


@wp.struct
class Texture:
    """How one image is looked up: texels are little-endian RGBA, 8 or 16 bits each, row 0 at the top."""

    texels: wp.uint64
    width: wp.int32
    height: wp.int32
    format: wp.int32  # scene.TEXELS_*
    wrap_s: wp.int32
    wrap_t: wp.int32
    # UV transform: image coordinates are the products of both rows with (u, v, 1) of the surface.
    u_row: wp.vec3
    v_row: wp.vec3
    special: wp.int32  # 1 = texels are scaled and biased, 2 = has tiles, 3 = both
    scale: wp.vec4
    bias: wp.vec4
    # UDIM: rows of ten tiles, each the index of a texture, and last that of the texture beyond all tiles; 0 = none
    tiles: wp.uint64
    tile_rows: wp.int32


# Light.kind. LIGHT_MESH is an emissive instance: the device makes these rows, from the materials.
LIGHT_SPHERE, LIGHT_DISTANT, LIGHT_RECT, LIGHT_DISK, LIGHT_CYLINDER, LIGHT_ELLIPSOID, LIGHT_MESH = (
    wp.constant(kind) for kind in range(7)
)


@wp.struct
class Light:
    """A light. Hosts keep the authored fields: `scene.LIGHT` is made of them."""

    kind: wp.int32
    # Unit axes in world space. A light emits along -z (rect, disk, distant); a cylinder's axis is x.
    x_axis: wp.vec3
    y_axis: wp.vec3
    z_axis: wp.vec3
    position: wp.vec3
    radiance: wp.vec3  # nits of the surface; for distant: nits over its cone
    # Half axes [stage units, world scale applied] are radius and aspect times radius: of a disk x, y, of an
    # ellipsoid x, y, z, of a cylinder y, z; a sphere has the radius alone.
    radius: wp.float32
    aspect: wp.vec2
    width: wp.float32  # rect: x extent
    height: wp.float32  # rect: y extent; cylinder: x extent (its length)
    cos_angle: wp.float32  # distant: cosine of half its angle; 1 = a delta light, then radiance holds lux
    shaping_cos: wp.float32  # cosine of shaping:cone:angle; -1 = no cone
    shaping_softness: wp.float32
    shaping_focus: wp.float32
    focus_tint: wp.vec3
    diffuse: wp.float32
    specular: wp.float32
    visible: wp.int32  # 1 = seen by camera rays

    # The rest is made on the device.
    emission_profile: wp.uint64  # address of an EmissionProfile; 0 = uniform emission
    links: wp.uint64  # address of a LightLinks; 0 = lights everything and casts full shadows
    strength: wp.float32  # see `lights.power`
    extent: wp.float32
    # Of an emissive instance: its row, the CDF of its triangles, their number, and luminance times area summed over
    # them [nit * stage unit^2].
    instance: wp.int32
    face_cdf: wp.uint64
    face_count: wp.int32
    luminance_area: wp.float32


@wp.struct
class EmissionProfile:
    """`scene.EmissionProfile`; address 0 = none."""

    ies: wp.uint64  # float32, row by row
    ies_height: wp.int32
    ies_width: wp.int32
    texels: wp.uint64  # vec3, row by row
    height: wp.int32
    width: wp.int32


@wp.struct
class LightLinks:
    """`scene.LightLinks`."""

    masks: wp.uint64  # uint8 per instance: bit 1 = is lit, bit 2 = casts the shadow; address 0 = all do both
    shadow_color: wp.vec3
    shadow_distance: wp.float32
    shadow_falloff: wp.float32
    shadow_gamma: wp.float32


@wp.struct
class Dome:
    """A lat-long environment map, and a coarse grid of constant cells for importance sampling (see `environment`)."""

    texels: wp.array(dtype=wp.uint32)  # width * height, packed by `environment.packed`
    unit: wp.vec3  # radiance of one step at exponent 0 [nits]
    width: wp.int32
    height: wp.int32  # 0 = no dome
    dome_from_world: wp.mat33
    visible: wp.int32
    diffuse: wp.float32
    specular: wp.float32
    grid_width: wp.int32
    grid_height: wp.int32
    cells: wp.array(dtype=wp.uint32)  # per cell two words: packed radiance, and the bits of its pdf [1/sr]
    row_cdf: wp.array(dtype=wp.float32)  # grid_height + 1, from 0 to 1
    cell_cdf: wp.array(dtype=wp.float32)  # per row grid_width + 1, from 0 to 1
    strength: wp.float32  # typical irradiance [lux]; 0 = black


@wp.struct
class World:
    """What one of many worlds has of its own. Instances and materials of all worlds are in the same tables."""

    nodes: wp.uint64  # of its TLAS
    instance_count: wp.int32  # in its TLAS
    first_instance: wp.int32
    lights: wp.uint64  # Light records
    # Of its dome:
    unit: wp.vec3
    strength: wp.float32
    dome_from_world: wp.mat33


@wp.struct
class SceneTables:
    """The whole scene on the device, or many worlds of one scene (see `kernels.scene.worlds`)."""

    worlds: wp.array(dtype=World)  # empty: there is one, which the other fields describe
    first_instance: wp.int32  # of the world that the other fields describe
    tlas: Tlas
    slots: wp.array(dtype=wp.int32)
    materials: wp.array(dtype=Material)
    textures: wp.array(dtype=Texture)
    texel_values: wp.array(dtype=wp.float32)  # 512: linear values of 8-bit sRGB texels, then of raw ones
    albedo_table: wp.array(dtype=wp.vec2)  # see `device.albedo_table`
    lights: wp.array(dtype=Light)
    light_count: wp.int32
    surface_count: wp.int32  # lights that a ray can hit come first: this many
    instance_light: wp.array(dtype=wp.int32)  # row of an emissive instance in `lights`, or -1; empty if there is none
    emissive_count: wp.int32  # lights that are emissive instances
    dome: Dome
    cutouts: wp.int32  # 1 = some material may be transparent


@wp.struct
class Camera:
    """A camera: looks along -z of its frame, +y up, pixel row 0 at the top."""

    origin: wp.vec3
    rotation: wp.mat33  # camera to world, columns x, y, z
    fx: wp.float32  # focal length [pixels]
    fy: wp.float32
    cx: wp.float32  # principal point [pixels]
    cy: wp.float32
    width: wp.int32
    height: wp.int32
    world: wp.int32  # that it is in
    near: wp.float32  # clipping range along the axis [stage units]
    far: wp.float32
    orthographic: wp.int32  # 1 = parallel rays; fx, fy are then pixels per stage unit
    lens_radius: wp.float32  # 0 = no depth of field
    focus_distance: wp.float32
    # Approximate fraction of the environment's and distant lights' light that reaches the visible surfaces, > 0.
    environment_weight: wp.float32
    lens_kind: wp.int32  # NONE for pinhole and orthographic cameras, else that of `lens`
    lens: Lens


@wp.struct
class Hit:
    """Intersection of a ray with a triangle: barycentric weights of corners 1 and 2, and the ray parameter t."""

    t: wp.float32
    u: wp.float32
    v: wp.float32
    instance: wp.int32  # -1 = nothing
    triangle: wp.int32
