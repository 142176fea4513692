"""Modules of kernels are compiled with progress, longest first, and loaded from the cache without a word."""

import threading
from typing import Any

import pytest
import warp as wp

from usdsdg.kernels import compilation
from usdsdg.kernels.compilation import ModuleLoad, kernel_modules, load_modules


class Loads(ModuleLoad):
    """The load of a `Module` of the test."""

    module: Any

    def is_cached(self):
        return self.module.cached

    def run(self):
        self.module.load()


class Module:
    """Notes in `order` when it is loaded; waits for `gate` before it ends."""

    def __init__(self, order, name, *, cached=False, gate=None, error=None):
        self.order, self.name, self.cached, self.gate, self.error = order, name, cached, gate, error

    def load(self):
        self.order.append(self.name)
        if self.gate is not None:
            assert self.gate.wait(30)
        if self.error is not None:
            raise self.error


def load(module, seconds=1.0):
    return Loads(module, wp.get_device("cpu"), seconds=seconds)


def test_cached_modules_are_loaded_without_progress():
    order = []
    loads = [load(Module(order, name, cached=True)) for name in "ab"]
    assert load_modules(loads, what="kernels", threads=1, progress=lambda *_: pytest.fail("nothing compiles")) == []
    assert sorted(order) == ["a", "b"]


def test_those_that_take_longest_come_first_and_cached_ones_last():
    order = []
    given = [
        load(Module(order, "cached", cached=True), 9.0),
        load(Module(order, "short")),
        load(Module(order, "long"), 5.0),
    ]
    compiled = load_modules(given, what="kernels", threads=1)
    assert order == ["long", "short", "cached"]
    assert [each.module.name for each in compiled] == ["long", "short"]


def test_progress_is_the_share_of_the_time_that_modules_take(monkeypatch):
    """One of three seconds is done when the short module is, however many modules that are."""
    monkeypatch.setattr(compilation, "TICK", 0.01)
    gate, heard = threading.Event(), []

    def progress(label, done, total):
        heard.append((label, done, total))
        if done >= 33:
            gate.set()

    monkeypatch.setattr(compilation, "MOST_UNDER_WAY", 0.0)
    loads = [load(Module([], "long", gate=gate), 2.0), load(Module([], "short"), 1.0)]
    load_modules(loads, what="kernels", threads=2, progress=progress)
    assert {label for label, _, _ in heard} == {"compiling kernels (first use), 2 modules, in percent"}
    assert [(done, total) for _, done, total in heard] == [(0, 100), (33, 100), (100, 100)]


def test_a_module_under_way_counts_by_the_pace_of_those_before_it_but_never_as_done():
    work = compilation._Work([], "", None)
    slow, ended = load(Module([], "slow"), 10.0), load(Module([], "ended"), 1.0)
    work._missing, work._total = {slow, ended}, 11.0
    work._begun, work._took = {slow: 100.0, ended: 100.0}, {ended: 2.0}
    assert work._done(104.0) == pytest.approx(1.0 + 4.0 / 2.0)
    assert work._done(1000.0) == pytest.approx(1.0 + 9.0)


def test_a_module_that_does_not_compile_is_an_error():
    broken = load(Module([], "broken", error=RuntimeError("no such function")))
    with pytest.raises(RuntimeError, match="no such function"):
        load_modules([broken], what="kernels", threads=2)


@wp.kernel(enable_backward=False, module="unique")
def number(out: wp.array(dtype=wp.int32)):  # pyright: ignore[reportInvalidTypeForm]
    out[wp.tid()] = 7


def test_a_module_is_in_the_cache_once_it_was_compiled(tmp_path, monkeypatch):
    monkeypatch.setattr(wp.config, "kernel_cache_dir", str(tmp_path))
    cpu = wp.get_device("cpu")
    assert not ModuleLoad(number.module, cpu).is_cached()
    assert len(load_modules([ModuleLoad(number.module, cpu)], what="kernels", threads=1)) == 1
    assert load_modules([ModuleLoad(number.module, cpu)], what="kernels", threads=1) == []
    out = wp.zeros(2, dtype=wp.int32, device=cpu)
    wp.launch(number, dim=2, inputs=[out], device=cpu)
    assert out.numpy().tolist() == [7, 7]


def test_kernels_are_found_below_a_package():
    from usdsdg.annotators.pixels import encoding_kernels, mask_kernels

    found = kernel_modules("usdsdg.annotators")
    assert {encoding_kernels.behind_everything.module, mask_kernels.find_edges.module} <= set(found)
    assert len(found) == len(set(found))
