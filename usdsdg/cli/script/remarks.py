"""What is said at the end of a run that left nothing, or nothing to see, and of one whose script hid an error."""

from __future__ import annotations

from usdsdg.session import render_products
from usdsdg.session.session import current


def remarks() -> list[str]:
    """Return one sentence for each thing about the run that its author will not have wanted."""
    seen = current().observations
    if not seen.frames:
        return _of_no_frame()
    found = []
    if seen.goes_on:
        return found  # the pictures that were made now are not those of the run
    if seen.pictures and not seen.light_seen:
        found.append(
            f"{_all(seen.pictures, 'picture')} black: no light reaches what the camera sees, or the camera is inside "
            "of a prim. A script that was made in the GUI may count on the light and the units of its stage: "
            "--new-stage kit (centimeters) or --new-stage isaac (meters) gives it those of a new stage, --stage FILE "
            "opens one."
        )
    if seen.label_frames and not seen.label_seen:
        found.append(
            f"no label is in view in {_all(seen.label_frames, 'picture', verb=False)}: what the camera sees has no "
            "semantics. Give labels to the prims, as in semantics=[('class', 'cube')], or point the camera at those "
            "that have some."
        )
    return found


def _of_no_frame() -> list[str]:
    seen = current().observations
    if seen.writers:
        names = ", ".join(dict.fromkeys(seen.writers))
        what = f"{names} {'is' if len(set(seen.writers)) == 1 else 'are'} attached, but no frame was captured"
    elif waiting_triggers() and not render_products.products():
        return [
            "the script made randomizers with triggers, and no render product, so there is nothing to capture. It may "
            "count on a recorder window of the GUI: here create.render_product and a writer do what the window does."
        ]
    elif waiting_triggers():
        what = "the script made randomizers with triggers, but captured no frame"
    else:
        return []
    if seen.unseen and seen.waits_for_calls:
        return [
            f"{what}: a writer that is attached with trigger=None writes the next frame after each call of its "
            "schedule_write() alone. Call that before a step, or attach it without trigger=None."
        ]
    if seen.unseen:
        return [
            f"{what}: at {_all(seen.unseen, 'step', verb=False)} no annotator or writer was attached to a render "
            "product that updates. Attach one, for example rep.annotators.get('rgb').attach(render_product)."
        ]
    why = "it only made previews" if seen.previews else "nothing started a run"
    return [
        f"{what}: {why}. In the GUI a person presses Start; --frames N does that here, for frames 0 to N. In a script, "
        "rep.orchestrator.run() or step() does."
    ]


def _all(count: int, noun: str, *, verb: bool = True) -> str:
    if count == 1:
        return f"the only {noun}{' is' if verb else ''}"
    return f"all {count} {noun}s{' are' if verb else ''}"


def waiting_triggers() -> bool:
    """Whether the graph has triggers that frames or events fire, and not calls of the script."""
    return any(trigger.waits_for_frames for trigger in current().graph.triggers)
