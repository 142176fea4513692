"""Paths of prims in outputs of nodes."""


class PrimPath(str):
    """A path as text which has the methods of a USD path that scripts call, as of the paths that Replicator returns."""

    @property
    def pathString(self) -> str:
        """The path as plain text."""
        return str(self)

    @property
    def name(self) -> str:
        """The last element of the path."""
        return self.rpartition("/")[2]

    def GetString(self) -> str:
        """Return the path as plain text."""
        return str(self)

    def GetText(self) -> str:
        """Return the path as plain text."""
        return str(self)

    def GetName(self) -> str:
        """Return the last element of the path."""
        return self.name

    def GetParentPath(self) -> "PrimPath":
        """Return the path of the prim above, "/" for the topmost."""
        return PrimPath(self.rpartition("/")[0] or "/")

    def AppendChild(self, name: str) -> "PrimPath":
        """Return the path of a prim below."""
        return PrimPath(f"{self.rstrip('/')}/{name}")
