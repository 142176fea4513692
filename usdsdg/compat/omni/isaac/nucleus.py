"""`omni.isaac.nucleus`: the assets root."""

from usdsdg.session.stage_context import assets_root


def get_assets_root_path() -> str:
    return assets_root()


async def get_assets_root_path_async() -> str:
    return assets_root()
