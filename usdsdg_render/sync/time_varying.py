"""Time samples, splines and value clips: which a stage has, and which prims get some by an edit."""

from collections.abc import Collection, Sequence

from pxr import Sdf, Usd

# Splines are of numbers.
_NUMBERS = frozenset({Sdf.ValueTypeNames.Double, Sdf.ValueTypeNames.Float, Sdf.ValueTypeNames.Half})


def has_splines_or_clips(stage: Usd.Stage, root: Sdf.Path) -> bool:
    """Return whether a prim at or below `root`, or in what these are instances of, has any.

    No layer lists these, as it does time samples.
    """
    unread, prototypes, has_spline = [stage.GetPrimAtPath(root)], set(), Usd.Attribute.HasSpline
    while unread:
        start = unread.pop()
        for prim in Usd.PrimRange(start) if start else ():
            if prim.HasAuthoredMetadata("clips") or any(map(has_spline, prim.GetAuthoredAttributes())):
                return True
            if prim.IsInstance() and (prototype := prim.GetPrototype()).GetPath() not in prototypes:
                # Each once: a thousand instances of one cost no more.
                prototypes.add(prototype.GetPath())
                unread.append(prototype)
    return False


class Samples:
    """Which prims of a stage have time samples, by the properties that change on them."""

    def __init__(self, stage: Usd.Stage) -> None:
        self._stage = stage
        # Properties of which nothing but layers of the stage itself says anything: these know them by the same path.
        self._local: set[Sdf.Path] = set()
        self._last: Sequence[Sdf.Path] = ()  # properties, as most frames change, all of which are local

    def of(self, properties: Sequence[Sdf.Path], recomposed: Collection[Sdf.Path]) -> set[Sdf.Path]:
        """Return those of the prims with these properties of which one has samples, in whichever layer they are.

        recomposed: properties of which other layers say something than before.
        """
        found: set[Sdf.Path] = set()
        for layer in self._stage.GetLayerStack():
            samples_of = layer.GetNumTimeSamplesForPath
            if not layer.empty and any(map(samples_of, properties)):
                found.update(path.GetPrimPath() for path in properties if samples_of(path))
        if recomposed:
            self._local.difference_update(recomposed)
            self._last = ()
        if properties is not self._last:
            # In variants and in layers that are referenced, prims have other paths.
            elsewhere = [path for path in properties if path not in self._local and not self._is_local(path)]
            attributes = map(self._stage.GetAttributeAtPath, elsewhere)
            found.update(each.GetPrimPath() for each in attributes if each and each.GetNumTimeSamples())
            self._last = () if elsewhere else properties
        return found

    def _is_local(self, path: Sdf.Path) -> bool:
        """Return whether only layers of the stage itself have opinions of a property, and note it if so."""
        attribute = self._stage.GetAttributeAtPath(path)
        specs = attribute.GetPropertyStack() if attribute else []
        # A variant has the layer, and not the path.
        is_local = bool(specs) and all(spec.path == path and self._stage.HasLocalLayer(spec.layer) for spec in specs)
        if is_local:
            self._local.add(path)
        return is_local

    def forget(self) -> None:
        """Forget what was found, since prims were made anew."""
        self._local.clear()
        self._last = ()


class Splines:
    """Which prims of a stage have splines, by the properties that change on them."""

    def __init__(self, stage: Usd.Stage) -> None:
        self._stage = stage
        # Each frame of a simulation writes thousands of properties, mostly those of the frame before.
        self._numbers: dict[Sdf.Path, Usd.Attribute | None] = {}  # None: it cannot have a spline
        self._last: tuple[Sequence[Sdf.Path], list[Usd.Attribute]] = (), []  # properties, and those of numbers

    def of(self, properties: Sequence[Sdf.Path]) -> set[Sdf.Path]:
        """Return those of the prims with these properties of which one has a spline."""
        if properties is not self._last[0]:
            self._last = properties, self._of_numbers(properties)
        found = self._last[1]
        # Not looked up on the attributes, which takes pxr longer than to answer.
        have_splines = map(Usd.Attribute.HasSpline, found)
        return {attribute.GetPrimPath() for attribute, has_spline in zip(found, have_splines) if has_spline}

    def _of_numbers(self, properties: Sequence[Sdf.Path]) -> list[Usd.Attribute]:
        numbers = self._numbers
        for path in properties:
            if path not in numbers:
                attribute = self._stage.GetAttributeAtPath(path)
                numbers[path] = attribute if attribute and attribute.GetTypeName() in _NUMBERS else None
        return list(filter(None, map(numbers.get, properties)))

    def forget(self) -> None:
        """Forget which properties are of numbers, since prims were made anew."""
        self._numbers = {}
        self._last = (), []
