import pytest

from tests.annotators.ray_caster import known
from usdsdg import writers
from usdsdg.stage import render_products


@pytest.fixture(autouse=True)
def detached():
    """One render product to attach to; no test leaves a writer attached."""
    known("/Render/HydraTextures/rp1")
    yield
    writers.detach_all()
    render_products.reset()
