"""A stand-in for Kit's test framework: test cases whose methods are coroutines."""

import inspect
import sys
import unittest
from collections.abc import Generator
from types import ModuleType


class _Done:
    """May be awaited or not: tests call `super().setUp()` both ways."""

    def __await__(self) -> Generator:
        return iter(())  # pyright: ignore[reportReturnType]


class AsyncTestCase(unittest.TestCase):
    """A test case of one method, run by `run_async`."""

    @property
    def name(self) -> str:
        return self._testMethodName

    def setUp(self) -> _Done:  # pyright: ignore[reportIncompatibleMethodOverride]
        return _Done()

    def tearDown(self) -> _Done:  # pyright: ignore[reportIncompatibleMethodOverride]
        return _Done()

    async def run_async(self) -> None:
        """Run the method between setUp and tearDown; raises what it raises."""
        await _awaited(self.setUp())
        try:
            await _awaited(getattr(self, self.name)())
        finally:
            await _awaited(self.tearDown())


class TimedAsyncTestCase(AsyncTestCase):
    """A test case that knows the root of the assets."""

    async def setUp(self) -> None:  # pyright: ignore[reportIncompatibleMethodOverride]
        from isaacsim.storage.native import get_assets_root_path

        self._assets_root_path = get_assets_root_path()


async def _awaited(result: object) -> None:
    if inspect.isawaitable(result):
        await result


def install() -> None:
    """Make `omni.kit.test` importable, and the test case of `isaacsim.test.utils`."""
    import isaacsim.test.utils
    import omni.kit
    import omni.kit.app
    import omni.timeline
    import omni.usd

    module = ModuleType("omni.kit.test")
    module.AsyncTestCase = AsyncTestCase  # pyright: ignore[reportAttributeAccessIssue]
    sys.modules[module.__name__] = omni.kit.test = module
    isaacsim.test.utils.TimedAsyncTestCase = TimedAsyncTestCase
