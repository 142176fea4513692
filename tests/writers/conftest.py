import pytest

from tests.annotators.ray_caster import known
from usdsdg import writers
from usdsdg.session import render_products
from usdsdg.session.stage_context import current_stage


@pytest.fixture(autouse=True)
def detached():
    """One render product to attach to; no test leaves a writer attached."""
    current_stage()  # a first stage that a test makes would forget the product
    known("/Render/HydraTextures/rp1")
    yield
    writers.detach_all()
    render_products.reset()
