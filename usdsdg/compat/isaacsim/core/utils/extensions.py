"""`isaacsim.core.utils.extensions`: there are no extensions, so enabling and disabling do nothing."""


def enable_extension(extension_name: str) -> bool:
    return True


def disable_extension(extension_name: str) -> bool:
    return True
