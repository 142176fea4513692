"""What scripts ask `omni.usd.get_context()` beside the stage."""

import asyncio

from usdsdg.app.app import get_app
from usdsdg.compat.omni import timeline, usd
from usdsdg.session import stage_context


def test_nothing_is_pending(stage):
    context = usd.get_context()
    assert not context.get_stage_streaming_status()
    assert context.can_save_stage()
    context.reset_renderer_accumulation()


def test_the_context_has_the_timeline(stage):
    context = usd.get_context()
    assert context.get_timeline() is timeline.get_timeline_interface()
    assert context.get_timeline_name() == ""


def test_a_coroutine_waits_for_a_frame_and_opens_the_stage_again(tmp_path):
    file = str(tmp_path / "stage.usda")
    stage_context.new_stage()
    stage_context.save_stage(file)
    stage_context.open_stage(file)
    context, updates = usd.get_context(), []
    stage_context.current_stage().DefinePrim("/Unsaved")

    async def wait():
        subscription = get_app().get_update_event_stream().create_subscription_to_pop(lambda _: updates.append(1))
        await context.next_frame_async(0)
        await context.next_usd_async()
        subscription.unsubscribe()
        return await context.reopen_stage_async()

    assert asyncio.run(wait()) == (True, "")
    assert len(updates) >= 2
    assert not context.get_stage().GetPrimAtPath("/Unsaved")
