"""Let things roll and slide over the seams of triangle meshes."""

# Warp structs are no classes to a type checker; Newton declares the arrays of models optional.
# pyright: reportGeneralTypeIssues=false, reportOptionalMemberAccess=false

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    import newton

    from usdsdg_physics.corrections.contacts.contact_arrays import ContactArrays


class MeshSeams:
    """Turns contacts at the seams of triangles to the faces beside them."""

    def __init__(self, model: newton.Model, contacts: ContactArrays) -> None:
        import newton
        import warp as wp

        kinds = newton.GeoType
        types, scale = model.shape_type.numpy(), model.shape_scale.numpy()
        is_round = np.isin(types, [int(kinds.SPHERE), int(kinds.CAPSULE)])
        flat_kinds = (kinds.BOX, kinds.CYLINDER, kinds.CONE, kinds.CONVEX_MESH)
        is_hull = np.isin(types, [int(kind) for kind in flat_kinds]) & (model.shape_body.numpy() >= 0)
        # Closest points are looked for in the mesh's own frame.
        is_mesh = (types == int(kinds.MESH)) & (np.ptp(scale, axis=1) <= 1e-6 * scale[:, 0])
        self._model, self._contacts = model, contacts
        self._any_round, self._any_hull = (bool(each.any() and is_mesh.any()) for each in (is_round, is_hull))
        is_of_revolution = np.isin(types, [int(kinds.CYLINDER), int(kinds.CONE)])
        self._is_round, self._is_hull, self._is_mesh, self._is_of_revolution = (
            wp.array(each, dtype=wp.int32, device=model.device)
            for each in (is_round, is_hull, is_mesh, is_of_revolution)
        )

        # The origins of meshes may be at their bottom, or far off.
        lower, upper = model.shape_collision_aabb_lower.numpy(), model.shape_collision_aabb_upper.numpy()
        middle = np.where(is_hull[:, None], (lower + upper) / 2.0, 0.0)
        self._middle = wp.array(middle, dtype=wp.vec3, device=model.device)

    def __bool__(self) -> bool:
        return self._any_round or self._any_hull

    def turn_contacts(self, state: newton.State, visited: int) -> None:
        """Turn the contacts that were just found, of which there are at most `visited`."""
        import warp as wp

        from usdsdg_physics.guards.mesh_seams_kernels import turn_hulls_to_faces, turn_to_faces

        model, kernels = self._model, []
        if self._any_round:
            kernels.append((turn_to_faces, self._is_round, []))
        if self._any_hull:
            kernels.append((turn_hulls_to_faces, self._is_hull, [self._middle, self._is_of_revolution]))
        for kernel, turned, more in kernels:
            wp.launch(
                kernel,
                dim=visited,
                inputs=[
                    turned,
                    self._is_mesh,
                    model.shape_source_ptr,
                    model.shape_scale,
                    model.shape_transform,
                    model.shape_body,
                    *more,
                    state.body_q,
                ],
                outputs=[self._contacts],
                device=model.device,
            )
