"""URLs of the demo assets, and the functions that make them."""

from collections.abc import Callable

from usdsdg.demo.asset import Asset
from usdsdg.demo.props import groceries, hospital, office, warehouse
from usdsdg.demo.skies import indoor_rooms
from usdsdg.demo.skies.room import Room

WAREHOUSE = "/Isaac/Environments/Simple_Warehouse"
OFFICE = "/Isaac/Environments/Office"
HOSPITAL = "/Isaac/Environments/Hospital"
YCB = "/Isaac/Props/YCB/Axis_Aligned"
YCB_PHYSICS = "/Isaac/Props/YCB/Axis_Aligned_Physics"
SKIES = "/NVIDIA/Assets/Skies/Indoor"

GROCERIES: dict[str, Callable[[], Asset]] = {
    "003_cracker_box.usd": groceries.cracker_box,
    "004_sugar_box.usd": groceries.sugar_box,
    "005_tomato_soup_can.usd": groceries.tomato_soup_can,
    "006_mustard_bottle.usd": groceries.mustard_bottle,
    "008_pudding_box.usd": groceries.pudding_box,
    "010_potted_meat_can.usd": groceries.potted_meat_can,
    "011_banana.usd": groceries.banana,
    "035_power_drill.usd": groceries.power_drill,
}

PROPS: dict[str, Callable[[], Asset]] = {
    f"{WAREHOUSE}/Props/SM_CardBoxD_04_1847.usd": warehouse.card_box_d,
    f"{WAREHOUSE}/Props/SM_CardBoxA_01_414.usd": warehouse.card_box_a,
    f"{WAREHOUSE}/Props/S_TrafficCone.usd": warehouse.traffic_cone,
    f"{WAREHOUSE}/Props/S_WetFloorSign.usd": warehouse.wet_floor_sign,
    f"{WAREHOUSE}/Props/SM_BarelPlastic_B_03.usd": warehouse.plastic_barrel,
    f"{OFFICE}/Props/SM_Board.usd": office.board,
    f"{OFFICE}/Props/SM_Book_03.usd": office.book_03,
    f"{OFFICE}/Props/SM_Book_34.usd": office.book_34,
    f"{OFFICE}/Props/SM_BookOpen_01.usd": office.book_open,
    f"{OFFICE}/Props/SM_Briefcase.usd": office.briefcase,
    f"{OFFICE}/Props/SM_Extinguisher.usd": office.extinguisher,
    f"{HOSPITAL}/Props/SM_GasCart_01b.usd": hospital.gas_cart,
    f"{HOSPITAL}/Props/SM_MedicalBag_01a.usd": hospital.medical_bag,
    f"{HOSPITAL}/Props/SM_MedicalBox_01g.usd": hospital.medical_box,
    f"{HOSPITAL}/Props/SM_Toweldispenser_01a.usd": hospital.towel_dispenser,
}

PANORAMAS: dict[str, Callable[[], Room]] = {
    f"{SKIES}/autoshop_01_4k.hdr": indoor_rooms.autoshop,
    f"{SKIES}/carpentry_shop_01_4k.hdr": indoor_rooms.carpentry_shop,
    f"{SKIES}/hotel_room_4k.hdr": indoor_rooms.hotel_room,
    f"{SKIES}/wooden_lounge_4k.hdr": indoor_rooms.wooden_lounge,
}

WAREHOUSE_STAGE = f"{WAREHOUSE}/warehouse.usd"
GRID_STAGE = "/Isaac/Environments/Grid/default_environment.usd"
