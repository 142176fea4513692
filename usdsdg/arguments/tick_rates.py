"""The rate of camera sensors, an attribute of Isaac Sim 6."""

from collections.abc import Sequence
from numbers import Real
from typing import Any

from pxr import Sdf, Usd

from usdsdg.arguments.values import shown
from usdsdg.errors import ArgumentError, warn_once

ATTRIBUTE = "omni:sensor:tickRate"


def author_tick_rate(cameras: Sequence[Usd.Prim], rate: Any) -> None:
    """Author the rate of sensors [1/s], one for all or one for each; None authors nothing.

    A rate above 0 warns: captures do not skip cameras.

    Raises:
        ArgumentError: a rate is not a number, 0 or more.
    """
    if rate is None:
        return
    rates = rate if isinstance(rate, (list, tuple)) and len(rate) == len(cameras) else [rate] * len(cameras)
    for prim, each in zip(cameras, rates):
        if not isinstance(each, Real) or not float(each) >= 0.0:
            raise ArgumentError(f"tick_rate is {shown(rate)}; expected frames per second, 0 or more")
        prim.CreateAttribute(ATTRIBUTE, Sdf.ValueTypeNames.Float, custom=False).Set(float(each))
        if each:
            warn_once(
                f"{prim.GetPath()}: tick_rate is authored, but every capture renders every camera. Capture at another "
                "rate with rep.trigger.on_time, or switch render products off with hydra_texture.set_updates_enabled."
            )
