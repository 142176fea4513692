"""Let round things roll over the seams of triangle meshes."""

# Warp structs are no classes to a type checker; Newton declares the arrays of models optional.
# pyright: reportGeneralTypeIssues=false, reportOptionalMemberAccess=false

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    import newton

    from usdsdg_physics.corrections.contacts.contact_arrays import ContactArrays


class MeshSeams:
    """Turns contacts of spheres and capsules at the seams of triangles to the faces beside them."""

    def __init__(self, model: newton.Model, contacts: ContactArrays) -> None:
        import newton
        import warp as wp

        kinds = newton.GeoType
        types, scale = model.shape_type.numpy(), model.shape_scale.numpy()
        is_round = np.isin(types, [int(kinds.SPHERE), int(kinds.CAPSULE)])
        # Closest points are looked for in the mesh's own frame.
        is_mesh = (types == int(kinds.MESH)) & (np.ptp(scale, axis=1) <= 1e-6 * scale[:, 0])
        self._model, self._contacts = model, contacts
        self._any = bool(is_round.any() and is_mesh.any())
        self._is_round, self._is_mesh = (
            wp.array(each, dtype=wp.int32, device=model.device) for each in (is_round, is_mesh)
        )

    def __bool__(self) -> bool:
        return self._any

    def turn_contacts(self, state: newton.State, visited: int) -> None:
        """Turn the contacts that were just found, of which there are at most `visited`."""
        import warp as wp

        from usdsdg_physics.guards.mesh_seams_kernels import turn_to_faces

        model = self._model
        wp.launch(
            turn_to_faces,
            dim=visited,
            inputs=[
                self._is_round,
                self._is_mesh,
                model.shape_source_ptr,
                model.shape_scale,
                model.shape_transform,
                model.shape_body,
                state.body_q,
            ],
            outputs=[self._contacts],
            device=model.device,
        )
