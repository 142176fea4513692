"""The four indoor rooms of the panoramas that the object-based scenario's dome light chooses from."""

from usdsdg.demo.skies.patterns import plain, planks, rug, shelf, slats, tiles, wainscot
from usdsdg.demo.skies.room import Block, Lamp, Point, Room

DOWN: Point = (0.0, 0.0, -1.0)
WHITE_LIGHT: Point = (46.0, 47.0, 48.0)
WARM_LIGHT: Point = (50.0, 38.0, 24.0)
DAYLIGHT: Point = (9.0, 10.5, 12.0)


def autoshop() -> Room:
    """Concrete hall with tube lamps, two roller doors with daylight strips, cabinets and a lift."""
    low, high = (-6.0, -5.0, 0.0), (6.0, 5.0, 4.4)
    steel, red = plain((0.34, 0.36, 0.38)), plain((0.45, 0.05, 0.04))
    tubes = [
        Lamp((x - 0.7, y - 0.09, 4.38), (x + 0.7, y + 0.09, 4.38), DOWN, WHITE_LIGHT)
        for x in (-4.0, -1.3, 1.3, 4.0)
        for y in (-2.6, 0.0, 2.6)
    ]
    strips = [
        Lamp((x - 1.5, 4.99, 2.2), (x + 1.5, 4.99, 3.0), (0.0, -1.0, 0.0), DAYLIGHT, sky=True) for x in (-3.0, 3.0)
    ]
    doors = [Block((x - 1.7, 4.9, 0.0), (x + 1.7, 4.98, 2.15), slats((0.55, 0.56, 0.55), 0.25)) for x in (-3.0, 3.0)]
    cabinets = [
        Block((-5.95, y, 0.0), (-5.3, y + 0.9, 1.1), shelf((0.4, 0.05, 0.04), [(0.5, 0.06, 0.05)], (0.9, 0.2)))
        for y in (-4.0, -3.0, -2.0, 1.0, 2.0)
    ]
    shelves = shelf((0.25, 0.27, 0.3), [(0.6, 0.4, 0.1), (0.1, 0.2, 0.5), (0.5, 0.5, 0.5), (0.6, 0.1, 0.1)])
    lift = [
        Block((2.2, -2.4, 0.0), (2.5, -2.1, 3.2), red),
        Block((4.6, -2.4, 0.0), (4.9, -2.1, 3.2), red),
        Block((1.9, -3.6, 1.3), (5.2, -0.9, 1.45), steel),
        Block((2.3, -4.2, 1.45), (4.8, -0.4, 2.0), plain((0.08, 0.16, 0.34))),
        Block((2.6, -3.2, 2.0), (4.5, -1.2, 2.6), plain((0.05, 0.07, 0.1))),
    ]
    furniture = [
        Block((-3.2, -4.95, 0.0), (0.6, -4.3, 2.3), shelves),
        Block((-3.2, 2.6, 0.75), (-1.2, 3.4, 0.85), planks((0.45, 0.3, 0.16))),
        Block((-3.1, 2.7, 0.0), (-1.3, 3.3, 0.75), plain((0.2, 0.22, 0.24))),
        Block((-1.2, -1.9, 0.0), (-0.6, -1.3, 0.95), plain((0.06, 0.15, 0.4))),
    ]
    walls = wainscot(plain((0.16, 0.24, 0.34)), plain((0.62, 0.62, 0.58)), 1.3)
    return Room(
        low,
        high,
        (0.3, 0.4, 1.6),
        floor=plain((0.34, 0.34, 0.33), 0.7),
        ceiling=slats((0.45, 0.46, 0.47), 0.5, 0.2),
        walls=walls,
        lamps=[*tubes, *strips],
        blocks=(*doors, *cabinets, *lift, *furniture),
    )


def carpentry_shop() -> Room:
    """Brick walls, planked floor, three tall windows, workbenches and stacks of timber."""
    low, high = (-5.0, -4.0, 0.0), (5.0, 4.0, 3.6)
    oak, pine = planks((0.46, 0.29, 0.14), 0.11), planks((0.66, 0.48, 0.26), 0.09, 2.4)
    windows = [
        Lamp((-4.99, y - 0.7, 0.9), (-4.99, y + 0.7, 3.0), (1.0, 0.0, 0.0), DAYLIGHT, sky=True)
        for y in (-2.4, 0.0, 2.4)
    ]
    lamps = [Lamp((x - 0.25, -0.25, 3.55), (x + 0.25, 0.25, 3.55), DOWN, WARM_LIGHT) for x in (-2.5, 0.5, 3.5)]
    benches = [
        block
        for x, y in ((-1.8, -2.2), (1.2, 2.0))
        for block in (
            Block((x - 1.0, y - 0.4, 0.78), (x + 1.0, y + 0.4, 0.88), oak),
            Block((x - 0.9, y - 0.3, 0.0), (x - 0.75, y + 0.3, 0.78), oak),
            Block((x + 0.75, y - 0.3, 0.0), (x + 0.9, y + 0.3, 0.78), oak),
            Block((x - 0.5, y - 0.2, 0.88), (x - 0.1, y + 0.15, 1.06), pine),
        )
    ]
    stacks = [
        Block((3.9, -3.9, 0.25 * layer), (4.9, 0.3 - 0.3 * layer, 0.25 * layer + 0.22), pine) for layer in range(5)
    ]
    tools = shelf(
        (0.4, 0.26, 0.13), [(0.3, 0.3, 0.32), (0.55, 0.1, 0.06), (0.6, 0.45, 0.1), (0.12, 0.2, 0.3)], (0.24, 0.4)
    )
    saw = [
        Block((2.3, -1.2, 0.0), (3.1, -0.5, 0.8), plain((0.1, 0.28, 0.2))),
        Block((2.1, -1.4, 0.8), (3.3, -0.3, 0.88), plain((0.5, 0.5, 0.5))),
    ]
    return Room(
        low,
        high,
        (-0.2, 0.2, 1.6),
        floor=planks((0.4, 0.27, 0.15), 0.18, 2.2),
        ceiling=planks((0.55, 0.42, 0.27), 0.25, 4.0),
        walls=tiles((0.42, 0.2, 0.14), (0.5, 0.47, 0.42), (0.25, 0.09), running=True),
        lamps=[*windows, *lamps],
        blocks=(*benches, *stacks, *saw, Block((-2.5, 3.85, 0.9), (2.5, 3.99, 2.6), tools)),
    )


def hotel_room() -> Room:
    """Carpet, a double bed between two lamps, curtains beside a broad window, a desk."""
    low, high = (-3.4, -2.8, 0.0), (3.4, 2.8, 2.7)
    linen, wood = plain((0.78, 0.76, 0.72), 0.15), planks((0.3, 0.17, 0.09), 0.3, 1.2)
    window = Lamp((-1.5, 2.79, 0.7), (1.5, 2.79, 2.3), (0.0, -1.0, 0.0), DAYLIGHT, sky=True)
    shades = [Lamp((3.0, y - 0.14, 1.12), (3.2, y + 0.14, 1.12), (0.0, 0.0, 1.0), WARM_LIGHT) for y in (-1.5, 1.1)]
    spots = [
        Lamp((x - 0.1, y - 0.1, 2.69), (x + 0.1, y + 0.1, 2.69), DOWN, WARM_LIGHT)
        for x in (-2.0, 0.0, 2.0)
        for y in (-1.5, 1.2)
    ]
    bed = [
        Block((1.0, -1.1, 0.1), (3.3, 0.7, 0.4), wood),
        Block((1.0, -1.1, 0.4), (3.2, 0.7, 0.62), linen),
        Block((0.98, -1.12, 0.3), (1.9, 0.72, 0.66), plain((0.16, 0.22, 0.32))),
        Block((2.7, -1.0, 0.62), (3.2, -0.3, 0.8), linen),
        Block((2.7, -0.1, 0.62), (3.2, 0.6, 0.8), linen),
        Block((3.25, -1.5, 0.0), (3.38, 1.1, 1.25), slats((0.36, 0.26, 0.2), 0.3, 0.25, upright=True)),
    ]
    stands = [Block((2.95, y - 0.25, 0.0), (3.35, y + 0.25, 0.5), wood) for y in (-1.5, 1.1)]
    curtains = [
        Block((x - 0.35, 2.62, 0.05), (x + 0.35, 2.76, 2.5), slats((0.42, 0.3, 0.22), 0.12, 0.5, upright=True))
        for x in (-1.85, 1.85)
    ]
    desk = [
        Block((-3.35, -1.6, 0.72), (-2.7, 0.4, 0.78), wood),
        Block((-3.35, -1.6, 0.0), (-2.8, -1.1, 0.72), wood),
        Block((-3.38, -0.9, 1.0), (-3.3, 0.3, 1.75), plain((0.02, 0.02, 0.025))),
        Block((-2.5, -0.8, 0.0), (-2.0, -0.3, 0.48), plain((0.5, 0.36, 0.2))),
    ]
    return Room(
        low,
        high,
        (-0.5, 0.1, 1.5),
        floor=rug(plain((0.3, 0.25, 0.2), 0.5), (0.18, 0.08, 0.07), (-1.6, -1.6), (0.6, 1.4)),
        ceiling=plain((0.75, 0.73, 0.68), 0.08),
        walls=wainscot(plain((0.4, 0.33, 0.25), 0.15), plain((0.68, 0.6, 0.47), 0.12), 1.0),
        lamps=[window, *shades, *spots],
        blocks=(*bed, *stands, *curtains, *desk),
    )


def wooden_lounge() -> Room:
    """Paneled walls, sofas around a low table, bookshelves, pendant lamps and a garden window."""
    low, high = (-4.2, -3.6, 0.0), (4.2, 3.6, 3.0)
    panel = planks((0.36, 0.2, 0.1), 0.22, 3.0, upright=True)
    leather, oak = plain((0.3, 0.12, 0.06), 0.3), planks((0.42, 0.26, 0.13), 0.2, 1.6)
    window = Lamp((4.19, -1.8, 0.4), (4.19, 1.8, 2.6), (-1.0, 0.0, 0.0), DAYLIGHT, sky=True)
    pendants = [
        Lamp((x - 0.22, y - 0.22, 2.92), (x + 0.22, y + 0.22, 2.92), DOWN, WARM_LIGHT)
        for x, y in ((-1.8, -1.4), (-1.8, 1.4), (1.4, -1.4), (1.4, 1.4))
    ]
    sofas = [
        block
        for y, back in ((-2.6, -2.8), (2.0, 2.6))
        for block in (
            Block((-1.4, y, 0.1), (1.4, y + 0.8, 0.45), leather),
            Block((-1.4, back, 0.1), (1.4, back + 0.3, 0.95), leather),
            Block((-1.6, y, 0.1), (-1.35, y + 0.8, 0.65), leather),
            Block((1.35, y, 0.1), (1.6, y + 0.8, 0.65), leather),
        )
    ]
    table = [
        Block((-0.8, -0.5, 0.36), (0.8, 0.5, 0.42), oak),
        Block((-0.7, -0.4, 0.0), (-0.6, 0.4, 0.36), oak),
        Block((0.6, -0.4, 0.0), (0.7, 0.4, 0.36), oak),
        Block((-0.3, -0.2, 0.42), (0.05, 0.05, 0.47), plain((0.1, 0.22, 0.4))),
        Block((0.3, 0.1, 0.42), (0.5, 0.3, 0.62), plain((0.6, 0.55, 0.4))),
    ]
    books = shelf(
        (0.34, 0.2, 0.1), [(0.4, 0.1, 0.08), (0.1, 0.2, 0.3), (0.5, 0.42, 0.2), (0.14, 0.26, 0.16)], (0.06, 0.36)
    )
    return Room(
        low,
        high,
        (-0.9, 0.1, 1.5),
        floor=rug(planks((0.44, 0.28, 0.15), 0.15, 1.8), (0.25, 0.06, 0.05), (-1.8, -1.3), (1.8, 1.3)),
        ceiling=planks((0.5, 0.36, 0.22), 0.3, 4.0),
        walls=wainscot(panel, plain((0.6, 0.52, 0.4), 0.15), 1.8),
        lamps=[window, *pendants],
        blocks=(*sofas, *table, Block((-4.15, -2.2, 0.0), (-3.8, 2.2, 2.3), books)),
    )
