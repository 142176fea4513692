"""`omni.kit.async_engine`: run a coroutine in the application's event loop."""

import asyncio
from collections.abc import Coroutine
from typing import Any

from usdsdg.app.app import get_app


def run_coroutine(coroutine: Coroutine[Any, Any, Any]) -> asyncio.Task[Any]:
    """Start a coroutine, which runs during updates; return its task."""
    get_app().open_loop()
    return asyncio.ensure_future(coroutine)
