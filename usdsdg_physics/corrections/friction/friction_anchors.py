"""Let the friction of a face act around the center of what lies on it, whatever contacts stand for the face."""

# The solver keeps its rows and patches in private arrays.
# pyright: reportOptionalMemberAccess=false

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import newton


def center_friction(solver: Any) -> bool:
    """Have Newton's solver put the two points of friction of a face on opposite sides of the body that lies on it.

    It puts them at the ends of the contacts that it has of the face. Of a round one these are four corners of a
    pentagon, whose ends are not opposite, so that disks wandered that turn in place.

    Returns:
        Whether this version and configuration of the solver are known.
    """
    import warp as wp

    patches = getattr(solver, "_friction_patches", None)
    if patches is None or not getattr(solver, "_friction_anchors_enabled", False):
        return False
    try:
        from usdsdg_physics.corrections.friction.friction_anchors_kernels import center_anchors
    except ImportError:  # another version of Newton has its patches elsewhere
        return False
    build = patches.build

    def build_centered(model: newton.Model, state: newton.State, contacts: newton.Contacts, **options: object) -> None:
        build(model, state, contacts, **options)
        wp.launch(
            center_anchors,
            dim=patches.capacity,
            inputs=[contacts.rigid_contact_count, model.gravity, model.body_com, state.body_q],
            outputs=[patches.current, patches.view],
            device=model.device,
        )

    patches.build = build_centered
    return True
