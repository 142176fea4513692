"""`omni.isaac.nucleus`: the assets root."""

from usdsdg.stage.assets import assets_root


def get_assets_root_path() -> str:
    return assets_root()


async def get_assets_root_path_async() -> str:
    return assets_root()
