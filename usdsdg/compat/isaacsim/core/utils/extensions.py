"""`isaacsim.core.utils.extensions`: everything there is, is enabled."""


def enable_extension(extension_name: str) -> bool:
    return True


def disable_extension(extension_name: str) -> bool:
    return True
