"""What a run has left: how many frames, whether a picture had light in it and a label in view."""

BLACK = 2  # highest value of a pixel of an image that counts as black


class Observations:
    """Counts of what was captured in this process, on all stages; capture and writers fill it, `remarks` read it."""

    def __init__(self) -> None:
        self.frames = 0  # captured with at least one annotator or writer, here or by another process
        self.pictures = 0  # color images
        self.label_frames = 0  # images of render products of which labels were requested
        self.goes_on = False  # earlier frames were made before, and may have had light and labels
        self.light_seen = False  # a color image was not black
        self.label_seen = False  # a labeled prim was in view
        self.writers: list[str] = []  # type names of the writers that have been attached
        self.unattached: list[str] = []  # those of writers that have been initialized, and attached to nothing since
        self.waits_for_calls = False  # one of them was attached with trigger=None
        self.previews = 0
        self.unseen = 0  # captures of which no annotator or writer wanted anything

    def add_writer(self, name: str, *, waits_for_calls: bool) -> None:
        """Add a writer that is attached, by the name of its type; `waits_for_calls` if with trigger=None."""
        self.writers.append(name)
        if name in self.unattached:
            self.unattached.remove(name)
        self.waits_for_calls |= waits_for_calls

    def add_picture(self, highest: float) -> None:
        """Add a color image with its highest value, of 255."""
        self.pictures += 1
        self.light_seen |= highest > BLACK

    def add_labels(self, in_view: bool) -> None:
        """Add an image of which labels were requested, and whether one was in view."""
        self.label_frames += 1
        self.label_seen |= in_view
