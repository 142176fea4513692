"""Which prims bind what, so that only theirs are found again where a material comes or goes."""

from __future__ import annotations

from collections.abc import Collection, Sequence

from pxr import Sdf

from usdsdg.stage.changes import is_below


class BindingOwners:
    """The prims with material bindings that were read, and the prims that these bindings name."""

    def __init__(self) -> None:
        self._named: dict[Sdf.Path, Sequence[Sdf.Path] | None] = {}

    def note(self, owner: Sdf.Path, named: Sequence[Sdf.Path] | None) -> None:
        """Note the paths that the bindings of `owner` name, of which none need exist.

        None: they depend on any prim, as those of collections, which may include others.
        """
        self._named[owner] = named

    def take_concerned(self, roots: Collection[Sdf.Path]) -> set[Sdf.Path]:
        """Forget, and return, the owners outside of subtrees whose bindings name a prim inside of one.

        Bindings inside of the subtrees are forgotten, too, since all that is there is read again.
        """
        inside: set[Sdf.Path] = set()
        concerned: set[Sdf.Path] = set()
        for owner, named in self._named.items():
            if is_below(owner, roots):
                inside.add(owner)
            elif named is None or any(is_below(path, roots) for path in named):
                concerned.add(owner)
        for owner in inside | concerned:
            del self._named[owner]
        return concerned
