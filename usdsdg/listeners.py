"""Functions that are called when something happens, and what ends each subscription."""

from collections.abc import Callable
from operator import attrgetter
from typing import Any, Generic, ParamSpec
from weakref import WeakMethod

from usdsdg.errors import name_callback

P = ParamSpec("P")


class Listeners(Generic[P]):
    """Functions by the order that they ask for, those of the same one as they subscribed."""

    def __init__(self) -> None:
        self._subscriptions: list[_Subscription] = []

    def __bool__(self) -> bool:
        """Return whether anybody hears of what happens now."""
        return any(each.heard is None or each.heard() for each in self._now())

    def subscribe(
        self, listener: Callable[P, Any], *, order: int = 0, heard: Callable[[], bool] | None = None
    ) -> Callable[[], None]:
        """Add a function behind those of its `order` and of lower ones, and return the unsubscriber.

        It ends this subscription alone, also where the same function is subscribed again, and may be called several
        times, also by what is called before this function.

        Args:
            heard: of a function that passes on what it hears, whether there is anybody to pass it to.
        """
        subscription = _Subscription(listener, order, heard)
        self._subscriptions.append(subscription)

        def unsubscribe() -> None:
            subscription.has_ended = True
            if subscription in self._subscriptions:
                self._subscriptions.remove(subscription)

        return unsubscribe

    def call(self, *args: P.args, **kwargs: P.kwargs) -> None:
        """Call all functions; one may subscribe others, which hear of the next event, or end those that come after it.

        An error of a script's function gets a note with its name and place.
        """
        for each in self._now():
            if not each.has_ended:
                try:
                    each.listener(*args, **kwargs)
                except Exception as error:
                    name_callback(error, "which was subscribed")
                    raise

    def _now(self) -> list["_Subscription"]:
        """Return the subscriptions in order.

        They are copied at once and sorted then, since garbage may be collected, and end some, wherever Python code runs
        or a container is made.
        """
        return sorted(self._subscriptions, key=attrgetter("order"))


class _Subscription:
    """One subscription. It equals no other, while a function, or a method, equals itself in a later subscription."""

    def __init__(self, listener: Callable[..., Any], order: int, heard: Callable[[], bool] | None) -> None:
        self.listener, self.order, self.heard = listener, order, heard
        self.has_ended = False


def weakly(method: Callable[[Any], None]) -> Callable[[Any], None]:
    """Return a function that calls a method for as long as its object lives."""
    reference = WeakMethod(method)

    def call(argument: Any) -> None:
        if (alive := reference()) is not None:
            alive(argument)

    return call
