"""When the triggers of a graph end a run: those with `max_execs`, once they have reached it."""

from usdsdg.app.saved_graph import warn_of_idle_triggers
from usdsdg.app.status import OrchestratorError
from usdsdg.capture.requests import is_watched
from usdsdg.errors import counted
from usdsdg.graph import evaluate
from usdsdg.session import progress, stage_context
from usdsdg.session.session import current
from usdsdg.writers.base import attached_writers, trigger_of
from usdsdg.writers.journal.run import get_run

# The input of `on_time_end`, which fires for the last picture of an interval, and not for the first of the next one.
ON_LAST_FRAME = "triggerOnLastFrame"


def is_endless(num_frames: int | None) -> bool:
    """Return whether nothing ends a run of so many frames: no trigger has a limit, and the command line sets none."""
    limited = any(trigger.max_execs for trigger in evaluate.graph().triggers)
    return num_frames is None and not limited and current().orchestrator.frames_without_end is None


def most_frames(num_frames: int | None) -> int | None:
    """Return how many frames a run has at most, of which a script has given `num_frames`; None: triggers end it.

    Raises:
        OrchestratorError: nothing ends it.
    """
    if is_endless(num_frames):
        warn_of_idle_triggers(stage_context.current_stage())
        raise never_ends()
    if num_frames is None and not any(trigger.max_execs for trigger in evaluate.graph().triggers):
        return current().orchestrator.frames_without_end
    return num_frames


def never_ends() -> OrchestratorError:
    """Return the error of a run that nothing ends."""
    return OrchestratorError(
        "orchestrator.run: nothing ends the run; give num_frames, or a trigger max_execs, or `usdsdg run --frames N`."
    )


def all_ended(captures: int) -> bool:
    """Return whether there are triggers, all of which have come to the end of their `max_execs`, before a frame."""
    triggers = evaluate.graph().triggers
    return bool(triggers) and all(trigger.max_execs and _has_ended(trigger, captures) for trigger in triggers)


def report_end(num_frames: int | None, captures: int, last: int | None) -> None:
    """Report how many frames there are after a run that has not captured all that it was to, and say why.

    num_frames: how many it was to capture; None: as many as the triggers want. captures, last: how many frames there
        are, and how many there would be; None: that was not known.
    """
    if last is not None and captures >= last:
        return
    made = get_run().own_frames(captures)
    progress.report_frames(made, made)
    if last is not None and evaluate.graph().triggers:
        progress.say(
            f"the run ended {counted(last - captures, 'frame')} before the {num_frames} of "
            f"run(num_frames={num_frames}): all triggers have reached their max_execs (num_frames of on_frame)"
        )


def _has_ended(trigger: evaluate.Trigger, captures: int) -> bool:
    """Return whether a trigger would fire once more than it may at the frame `captures`, or would have before.

    What it has drawn last is shown for as many frames as what it drew before.
    """
    if not trigger.exhausted:
        return False
    return trigger.kind != "OgnOnFrame" or captures >= trigger.latest + int(trigger.node.inputs["interval"])


def are_frames_due() -> bool:
    """Return whether a writer, an annotator or a trigger that fires by frames waits for those of a playing timeline."""
    # The nodes of the trigger write the stage, which scripts read without a writer, too.
    waiting = [trigger for trigger in evaluate.graph().triggers if trigger.kind == "OgnOnFrame" and trigger.nodes]
    return is_watched() or any(not trigger.exhausted for trigger in waiting)


def ends_without_picture(fired: list[evaluate.Trigger]) -> bool:
    """Return whether a run ends with the end of a time trigger's last interval, of which the next has no picture.

    A writer that waits for one of the triggers that fired gets its picture.
    """
    begun = [trigger for trigger in fired if trigger.kind == "OgnOnTime" and not trigger.node.inputs.get(ON_LAST_FRAME)]
    if not any(trigger.exhausted for trigger in begun):
        return False
    limited = [trigger for trigger in evaluate.graph().triggers if trigger.max_execs]
    waited_for = [trigger_of(writer) for writer in attached_writers()]
    return all(trigger.exhausted for trigger in limited) and not any(trigger in waited_for for trigger in fired)


def triggers_that_end(last: int | None) -> list[evaluate.Trigger]:
    """Return the triggers that end a run when all of them have reached their limits; `last` is the end of its frames.

    Beside a number of frames, triggers without a limit fire until that is reached.
    """
    triggers = evaluate.graph().triggers
    limited = [trigger for trigger in triggers if trigger.max_execs]
    return limited if last is None or len(limited) == len(triggers) else []


def limits_remain() -> bool:
    """Return whether a trigger has not reached its `max_execs` yet, as one that was made since the last run."""
    return any(trigger.max_execs and not trigger.exhausted for trigger in evaluate.graph().triggers)


def frames_remain(captures: int, last: int | None) -> bool:
    """Return whether a run goes on before the frame `captures`; `last` is its end, None: triggers end it.

    Raises:
        OrchestratorError: triggers are to end it, and none of them can fire any more.
    """
    return triggers_remain(captures) if last is None else captures < last and not all_ended(captures)


def triggers_remain(captures: int) -> bool:
    """Return whether a trigger has not come to the end of its `max_execs` before the frame `captures`.

    Raises:
        OrchestratorError: there are such triggers, but none of them can fire any more.
    """
    limited = [trigger for trigger in evaluate.graph().triggers if trigger.max_execs]
    remaining = [trigger for trigger in limited if not _has_ended(trigger, captures)]
    reasons = [_why_off(trigger) or trigger.blocked() for trigger in remaining]
    if remaining and all(reasons):
        raise OrchestratorError(f"orchestrator.run: nothing ends the run: {'; '.join(reasons)}. Or give num_frames.")
    return bool(remaining)


def _why_off(trigger: evaluate.Trigger) -> str:
    return f"{trigger.node.describe()} is disabled (set_disabled)" if trigger.node.is_off else ""
