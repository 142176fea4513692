// Body of closest, occluded and closest_in_instance on CUDA: Warp's query over one mesh of all triangles in the world.
// The start moves to tmin, so that t stays the parameter of the ray that was asked for.
wp::vec_t<5, int> found;
found[3] = -1;
const wp::uint64 mesh = ANY_HIT ? tree.shadow_mesh : tree.mesh;
if (mesh == 0)
    return found;
const wp::vec3 start = wp::add(origin, wp::mul(direction, tmin));
float t = 0.0f, u = 0.0f, v = 0.0f, sign = 0.0f;
wp::vec3 normal;
int face = 0;
if (ANY_HIT) {
    if (wp::mesh_query_ray_anyhit(mesh, start, direction, tmax - tmin))
        found[3] = 0;
    return found;
}
if (!wp::mesh_query_ray(mesh, start, direction, tmax - tmin, t, u, v, sign, normal, face))
    return found;
const int instance = tree.face_instance.data[face];
// Warp's u and v weigh corners 0 and 1.
found[0] = __float_as_int(t + tmin);
found[1] = __float_as_int(v);
found[2] = __float_as_int(1.0f - u - v);
found[3] = instance;
found[4] = face - tree.instances.data[instance].first_face;
return found;
