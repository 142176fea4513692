"""Writers by name: `rep.writers` and `rep.WriterRegistry`."""

from collections.abc import Mapping
from typing import Any

from usdsdg.annotators.render_products import render_product_paths
from usdsdg.arguments.registry import Registry
from usdsdg.errors import InvalidWriterError, Unsupported, WriterError, WriterRegistryError
from usdsdg.writers import base
from usdsdg.writers.base import ON_FRAME, Writer

registered: Registry[type[Writer]] = Registry("writer", WriterRegistryError)
_categories: dict[str, str | None] = {}


def get(
    name: str, init_params: Mapping[str, Any] | None = None, render_products: Any = None, trigger: Any = ON_FRAME
) -> Writer:
    """Create a writer by name, without `__init__`; initialize and attach it if the arguments for that are given.

    Args:
        init_params: arguments of `Writer.initialize`.
        render_products: handles, paths, or a list, for `Writer.attach`; `trigger` selects the frames to write.

    Raises:
        WriterRegistryError: there is no such writer; the message lists near misses.
        WriterError: init_params are no dictionary, or as `Writer.initialize`.
    """
    kind = registered.get(name)
    writer = kind.__new__(kind)
    if init_params is not None:
        _check_mapping(name, init_params)
        writer.initialize(**init_params)
    if render_products is not None:
        writer.attach(render_products, trigger)
    return writer


def _check_mapping(writer: str, init_params: Any) -> None:
    if not isinstance(init_params, Mapping):
        raise WriterError(
            f"{writer}: init_params is {init_params!r}; expected a dictionary of the arguments of initialize(), "
            "as in {'output_dir': 'out'}."
        )


def register_writer(cls: type[Writer], category: str | None = None) -> None:
    """Register a subclass of Writer under its class name, for `get` and `get_writers(category)`.

    Raises:
        InvalidWriterError: `cls` is no such class.
    """
    kind = cls if isinstance(cls, type) else type(cls)
    if not issubclass(kind, Writer):
        raise InvalidWriterError(f"{kind.__name__} is not a subclass of Writer.")
    registered.add(kind.__name__, kind)
    _categories[kind.__name__] = category


def unregister_writer(name: str) -> None:
    """Remove a writer from the registry; existing instances keep working.

    Raises:
        WriterRegistryError: there is no such writer; the message lists near misses.
    """
    registered.remove(name)
    _categories.pop(name, None)


def register_node_writer(name: str, node_type_id: str, annotators: Any, category: str | None = None, **kw: Any) -> None:
    """Unsupported: there are no OmniGraph nodes."""
    raise Unsupported(f"Node writer {name!r} ({node_type_id}): there is no OmniGraph; derive a class from Writer.")


def get_writers(category: str | None = None) -> dict[str, type[Writer]]:
    """Return the registered writers by name, or only those of a category."""
    return {name: registered.get(name) for name in registered if category in (None, _categories.get(name))}


class WriterRegistry:
    """The functions of `rep.writers` under Replicator's names, and methods of attached writers by writer name."""

    _default_writers: list[str] = []

    unregister = staticmethod(unregister_writer)
    unregister_writer = staticmethod(unregister_writer)
    register_node_writer = staticmethod(register_node_writer)
    get_writers = staticmethod(get_writers)
    detach_all = staticmethod(base.detach_all)

    @staticmethod
    def register(writer: type[Writer], category: str | None = None) -> None:
        """As `register_writer`."""
        register_writer(writer, category)

    @staticmethod
    def get(
        writer_name: str,
        init_params: Mapping[str, Any] | None = None,
        render_products: Any = None,
        trigger: Any = ON_FRAME,
    ) -> Writer:
        """As `writers.get`."""
        return get(writer_name, init_params, render_products, trigger)

    @staticmethod
    def attach(
        writer: Writer | str,
        render_products: Any,
        init_params: Mapping[str, Any] | None = None,
        trigger: Any = ON_FRAME,
        **kwargs: Any,
    ) -> None:
        """Attach a writer, or create and initialize the one of that name and attach it.

        init_params, kwargs: arguments of `Writer.initialize`, for a writer that is named.

        Raises:
            as `writers.get`, `Writer.initialize` and `Writer.attach`.
            InvalidWriterError: `writer` is neither a writer nor a name.
            WriterRegistryError: a writer that is no name is given arguments.
        """
        _check_mapping(str(writer), init_params or {})
        given = {**(init_params or {}), **kwargs}
        if isinstance(writer, str):
            get(writer, given, render_products, trigger)
            return
        if not isinstance(writer, Writer):
            raise InvalidWriterError(f"{writer!r} is no writer: give a name, or what writers.get(name) returns.")
        if given:
            raise WriterRegistryError(
                f"WriterRegistry.attach: {type(writer).__name__} was given {', '.join(given)}; call its initialize() "
                "with them, before attaching."
            )
        writer.attach(render_products, trigger)

    @staticmethod
    def detach(writer_name: str, render_products: Any = None) -> None:
        """Detach every attached writer of that name, or those that are attached to one of `render_products`.

        As in Replicator a writer is detached from all of its render products, whichever of them are given (handles,
        paths, or a list); `Writer.detach_from` detaches it from some.
        """
        paths = None if render_products is None else set(render_product_paths(render_products))
        for writer in _attached(writer_name):
            if paths is None or not paths.isdisjoint(writer.render_products):
                writer.detach()

    @staticmethod
    def get_attached_writers(render_products: Any = None) -> dict[str, Writer]:
        """Return by name the writers attached to any of `render_products` (handles, paths, or a list), or all.

        Of several writers of one name it is the one attached last; `Writer` objects tell them apart.
        """
        paths = None if render_products is None else set(render_product_paths(render_products))
        return {
            type(writer).__name__: writer
            for writer in base.attached_writers()
            if paths is None or not paths.isdisjoint(writer.render_products)
        }

    @staticmethod
    def get_attached_writer(writer_name: str, render_products: Any = None) -> Writer | None:
        """Return the attached writer of that name, of `render_products` or of any; None if there is none.

        Raises:
            WriterRegistryError: no writer of any name is attached to one of the render products.
        """
        for path in render_product_paths(render_products) if render_products is not None else ():
            if not any(path in writer.render_products for writer in base.attached_writers()):
                raise WriterRegistryError(f"No writer is attached to {path}, so none that is named {writer_name!r}.")
        return WriterRegistry.get_attached_writers(render_products).get(writer_name)

    @staticmethod
    def get_annotators(render_products: Any = None) -> set[Any]:
        """Return what the writers attached to `render_products` (handles, paths, or a list) read, or all writers."""
        attached = WriterRegistry.get_attached_writers(render_products)
        return {annotator for writer in attached.values() for annotator in writer.annotators}

    @staticmethod
    def get_writer_render_products() -> set[tuple[str]]:
        """Return the paths of all render products that have a writer, each in a tuple of its own, as in Replicator."""
        return {(path,) for writer in base.attached_writers() for path in writer.render_products}


def _attached(writer_name: str) -> list[Writer]:
    return [writer for writer in base.attached_writers() if type(writer).__name__ == writer_name]
