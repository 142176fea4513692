"""What is said at the end of a run that left nothing, or nothing to see."""

from __future__ import annotations

from usdsdg.session import render_products
from usdsdg.session.session import current

# What is advised where pictures are black.
_OPTIONS = (
    "A script that was made in the GUI may count on the light and the units of its stage: --new-stage kit "
    "(centimeters) or --new-stage isaac (meters) gives it those of a new stage, --stage FILE opens one."
)
_CALLS = "Add a light, as in rep.create.light(light_type='Dome'), or move the camera."


def remarks() -> list[str]:
    """Return one sentence for each thing about a run of `usdsdg run` that its author will not have wanted."""
    seen = current().observations
    return _of_pictures(_OPTIONS) if seen.frames else _of_no_frame()


def remarks_of_program() -> list[str]:
    """As `remarks`, of a Python program that imports usdsdg, which may have other reasons to capture no frame."""
    seen = current().observations
    if seen.frames:
        return _of_pictures(_CALLS)
    if seen.writers and not seen.unseen:
        return [
            f"{_attached(seen.writers)}, but no frame was captured: {_why_no_run()}. Call "
            "rep.orchestrator.run(num_frames=10) or step(). A script of the Script Editor, whose tasks wait for an "
            "event loop that runs, is run by `usdsdg run`."
        ]
    return _of_no_frame() if seen.unseen and (seen.writers or seen.unattached) else []


def _of_pictures(remedy: str) -> list[str]:
    """Return what is said of frames; `remedy` is advised for those that are black."""
    seen = current().observations
    found = []
    if seen.goes_on:
        return found  # the pictures that were made now are not those of the run
    if seen.pictures and not seen.light_seen:
        found.append(
            f"{_all(seen.pictures, 'picture')} black: no light reaches what the camera sees, or the camera is inside "
            f"of a prim. {remedy}"
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
        what = f"{_attached(seen.writers)}, but no frame was captured"
    elif seen.unattached and seen.unseen:
        return [
            f"{_listed(seen.unattached, 'was', 'were')} initialized, but not attached to a render product, so "
            f"{_all(seen.unseen, 'step', verb=False)} captured nothing. Call attach(render_product) before the first."
        ]
    elif waiting_triggers() and not render_products.products():
        return [
            "the script made randomizers with triggers, and no render product, so there is nothing to capture. It may "
            "count on a recorder window of the GUI: here create.render_product and a writer do what the window does."
        ]
    elif waiting_triggers():
        what = "the script made randomizers with triggers, but captured no frame"
    else:
        return []
    if seen.unseen and seen.writers and not current().writers:
        return [
            f"{_listed(seen.writers, 'was', 'were')} attached, and detached before the first frame, as by a new stage, "
            "which begins without writers. Attach it afterward."
        ]
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
    return [
        f"{what}: {_why_no_run()}. In the GUI a person presses Start; --frames N does that here, for frames 0 to N. In "
        "a script, rep.orchestrator.run() or step() does."
    ]


def _why_no_run() -> str:
    return "it only made previews" if current().observations.previews else "nothing started a run"


def _attached(writers: list[str]) -> str:
    return f"{_listed(writers, 'is', 'are')} attached"


def _listed(writers: list[str], one: str, several: str) -> str:
    """Return the names of writers, each once, and a verb."""
    names = dict.fromkeys(writers)
    return f"{', '.join(names)} {one if len(names) == 1 else several}"


def _all(count: int, noun: str, *, verb: bool = True) -> str:
    if count == 1:
        return f"the only {noun}{' is' if verb else ''}"
    return f"all {count} {noun}s{' are' if verb else ''}"


def waiting_triggers() -> bool:
    """Whether the graph has triggers that frames or events fire, and not calls of the script."""
    return any(trigger.waits_for_frames for trigger in current().graph.triggers)
