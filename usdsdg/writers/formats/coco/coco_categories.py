"""COCO categories by label, with id, color and supercategory."""

import itertools
from collections.abc import Mapping
from typing import Any

from usdsdg.annotators.class_table import ClassTable
from usdsdg.annotators.colors import FIRST_LABELED, colors_of_ids
from usdsdg.errors import WriterError, warn_once
from usdsdg.session.session import current

Category = dict[str, Any]  # name, id, supercategory, color (r, g, b), isthing

OTHER, UNLABELLED, BACKGROUND = "other", "unlabelled", "background"
_NO_CLASS = (UNLABELLED, BACKGROUND)  # what is behind objects, and what has no label
_RESERVED = tuple(name.upper() for name in _NO_CLASS)


class Categories:
    """Categories by label; case, and whether words are separated by blanks or by underscores, do not matter."""

    def __init__(self, own: Mapping[str, Mapping[str, Any]] | None = None) -> None:
        """own: by label, at least {"name", "id"} each; None: `semantic_classes`, where the user has fixed these, else
            those of COCO's panoptic challenge, and "other".

        Raises:
            WriterError: a category has no name or id, or two have the same id.
        """
        builtin = _builtin()
        own = _semantic_classes() if own is None else own
        given = builtin if own is None else {label: _checked(label, each) for label, each in own.items()}
        self._by_label = {_key(label): each for label, each in given.items()}
        self.reserve: Category | None = None  # of labels that an own table lacks; listed only where an object has it
        if own is not None:
            _check_ids(self._by_label)
            self.reserve = None if OTHER in self._by_label else _other(builtin[OTHER]["id"], self._by_label)
        self._no_class = {label: self._by_label.get(label, builtin[label]) for label in _NO_CLASS}
        if own is None:  # an object may be called so, too; it is no background
            self._by_label = {label: each for label, each in self._by_label.items() if label not in _NO_CLASS}

    def all(self) -> list[Category]:
        """Return the categories of a dataset by id, each once, whether or not a picture shows them."""
        by_id = {each["id"]: each for each in self._by_label.values()}
        return [by_id[number] for number in sorted(by_id)]

    def of(self, labels: Mapping[str, str]) -> Category:
        """Return the category of {type: "label[,label]"}: that of the last known label, or "other" with a warning."""
        if known := self._known(labels):
            return known[-1]
        other = self.reserve or self._by_label[OTHER]
        listed = ", ".join(f"{kind}:{text}" for kind, text in labels.items())
        warn_once(
            f"CocoWriter: no category is called {listed}: it becomes 'other', id {other['id']}. Add one to "
            "coco_categories."
        )
        return other

    def color(self, labels: Mapping[str, str]) -> list[int]:
        """Return the color (r, g, b) of pixels with these labels, which may be those of the background."""
        return (self._reserved(labels) or self.of(labels))["color"]

    def _known(self, labels: Mapping[str, str]) -> list[Category]:
        names = [_key(name) for text in labels.values() for name in (text, *text.split(","))]
        return [self._by_label[name] for name in names if name in self._by_label]

    def _reserved(self, labels: Mapping[str, str]) -> Category | None:
        # In capitals, which labels of prims never have.
        return next((self._no_class[text.lower()] for text in labels.values() if text in _RESERVED), None)


def _semantic_classes() -> dict[str, dict[str, Any]] | None:
    """Return the classes that the user has fixed as categories, with the ids that they have in masks."""
    rows = ClassTable(current().class_tables.given).listed()
    return {row["name"]: {"name": row["name"], "id": row["id"], "color": row["color"][:3]} for row in rows} or None


def _key(label: str) -> str:
    return label.lower().replace("_", " ")


def _checked(label: str, given: Mapping[str, Any]) -> Category:
    """Check a category and fill in its optional keys."""
    if not isinstance(given, Mapping) or not isinstance(given.get("id"), int) or "name" not in given:
        raise WriterError(
            f"CocoWriter: coco_categories[{label!r}] is {given!r}; expected at least "
            "{'name': text, 'id': whole number}."
        )
    color = given.get("color", _color_of(given["id"]))
    if len(color) != 3 or not all(0 <= channel <= 255 for channel in color):
        raise WriterError(f"CocoWriter: color of coco_categories[{label!r}] is {color!r}; expected (r, g, b) to 255.")
    defaults = {"supercategory": str(given["name"]), "isthing": 1}
    return {**defaults, **given, "color": [int(channel) for channel in color]}


def _color_of(number: int) -> list[int]:
    """Return the color of a category that has none of its own; never black, which is the background's."""
    return colors_of_ids([number if number >= FIRST_LABELED else number + 1000])[0, :3].tolist()


def _check_ids(by_label: Mapping[str, Category]) -> None:
    names: dict[int, str] = {}
    for category in by_label.values():
        other = names.setdefault(category["id"], category["name"])
        if other != category["name"]:
            raise WriterError(
                f"CocoWriter: the categories {other!r} and {category['name']!r} have one id, {category['id']}; give "
                "each its own."
            )


def _other(first: int, by_label: Mapping[str, Category]) -> Category:
    """Return the category of objects that a table has none for, with the first id from `first` on that is free."""
    taken = {each["id"] for each in by_label.values()}
    number = next(each for each in itertools.count(first) if each not in taken)
    return {"name": OTHER, "id": number, "supercategory": OTHER, "color": _color_of(number), "isthing": 1}


def _builtin() -> dict[str, Category]:
    found: dict[str, Category] = {}
    for line in _TABLE.strip().splitlines():
        head, _, members = line.partition(": ")
        kind, _, supercategory = head.partition(" ")
        for member in members.split("; "):
            number, _, named = member.partition(" ")
            name, _, color = named.partition("=")
            found[name] = {
                "name": name,
                "id": int(number),
                "supercategory": supercategory,
                "color": _builtin_color(name, int(number), color),
                "isthing": int(kind == "thing"),
            }
    return found


def _builtin_color(name: str, number: int, color: str) -> list[int]:
    if color:
        return [int(channel) for channel in color.split(",")]
    return [0, 0, 0] if name in _NO_CLASS else _color_of(number)


# Categories of COCO's detection, stuff and panoptic challenges (cocodataset.org), and the three that Replicator adds:
# one or more lines per supercategory, with members "id name=r,g,b"; those without a color get one from their id.
_TABLE = """
stuff unlabelled: 0 unlabelled
thing person: 1 person=220,20,60
thing vehicle: 2 bicycle=119,11,32; 3 car=0,0,142; 4 motorcycle=0,0,230; 5 airplane=106,0,228; 6 bus=0,60,100
thing vehicle: 7 train=0,80,100; 8 truck=0,0,70; 9 boat=0,0,192
thing outdoor: 10 traffic light=250,170,30; 11 fire hydrant=100,170,30; 12 street sign; 13 stop sign=220,220,0
thing outdoor: 14 parking meter=175,116,175; 15 bench=250,0,30
thing animal: 16 bird=165,42,42; 17 cat=255,77,255; 18 dog=0,226,252; 19 horse=182,182,255; 20 sheep=0,82,0
thing animal: 21 cow=120,166,157; 22 elephant=110,76,0; 23 bear=174,57,255; 24 zebra=199,100,0; 25 giraffe=72,0,118
thing accessory: 26 hat; 27 backpack=255,179,240; 28 umbrella=0,125,92; 29 shoe; 30 eye glasses; 31 handbag=209,0,151
thing accessory: 32 tie=188,208,182; 33 suitcase=0,220,176
thing sports: 34 frisbee=255,99,164; 35 skis=92,0,73; 36 snowboard=133,129,255; 37 sports ball=78,180,255
thing sports: 38 kite=0,228,0; 39 baseball bat=174,255,243; 40 baseball glove=45,89,255; 41 skateboard=134,134,103
thing sports: 42 surfboard=145,148,174; 43 tennis racket=255,208,186
thing kitchen: 44 bottle=197,226,255; 45 plate; 46 wine glass=171,134,1; 47 cup=109,63,54; 48 fork=207,138,255
thing kitchen: 49 knife=151,0,95; 50 spoon=9,80,61; 51 bowl=84,105,51
thing food: 52 banana=74,65,105; 53 apple=166,196,102; 54 sandwich=208,195,210; 55 orange=255,109,65
thing food: 56 broccoli=0,143,149; 57 carrot=179,0,194; 58 hot dog=209,99,106; 59 pizza=5,121,0; 60 donut=227,255,205
thing food: 61 cake=147,186,208
thing furniture: 62 chair=153,69,1; 63 couch=3,95,161; 64 potted plant=163,255,0; 65 bed=119,0,170
thing furniture: 67 dining table=0,182,199; 70 toilet=0,165,120
thing window: 68 window=255,73,97
thing furniture-stuff: 71 door
thing electronic: 72 tv=183,130,88; 73 laptop=95,32,0; 74 mouse=130,114,135; 75 remote=110,129,133
thing electronic: 76 keyboard=166,74,118; 77 cell phone=219,142,185
thing appliance: 78 microwave=79,210,114; 79 oven=178,90,62; 80 toaster=65,70,15; 81 sink=127,167,115
thing appliance: 82 refrigerator=59,105,106; 83 blender
thing indoor: 84 book=142,108,45; 85 clock=196,172,0; 86 vase=95,54,80; 87 scissors=128,76,255; 88 teddy bear=201,57,1
thing indoor: 89 hair drier=246,0,122; 90 toothbrush=191,162,208; 91 hair brush
stuff textile: 92 banner=255,255,128; 93 blanket=147,211,203; 104 cloth; 105 clothes; 109 curtain=210,170,100; 131 mat
stuff textile: 137 napkin; 141 pillow=76,91,113; 152 rug=250,141,255; 167 textile-other; 168 towel=225,199,255
stuff textile: 200 rug-merged=250,141,255
stuff plant: 94 branch; 97 bush; 99 cage; 119 flower=241,129,0; 124 grass=152,251,152; 129 leaves; 134 moss
stuff plant: 142 plant-other; 146 railing; 163 straw; 164 structural-other; 169 tree=107,142,35
stuff plant: 184 tree-merged=107,142,35; 193 grass-merged=152,251,152
stuff building: 95 bridge=150,100,100; 96 building-other=116,112,0; 128 house=70,70,70; 151 roof=92,82,55
stuff building: 158 skyscraper; 166 tent=169,164,131; 197 building-other-merged=116,112,0
stuff furniture-stuff: 98 cabinet=134,199,156; 107 counter=146,112,198; 108 cupboard; 110 desk=209,226,140
stuff furniture-stuff: 112 door-stuff=92,136,89; 123 furniture-other=104,84,109; 130 light=255,228,255
stuff furniture-stuff: 133 mirror=154,208,0; 156 shelf=255,160,98; 161 stairs=104,84,109; 165 table=209,226,140
stuff furniture-stuff: 188 cabinet-merged=134,199,156; 189 table-merged=209,226,140
stuff raw-material: 100 cardboard=168,171,172; 132 metal; 139 paper; 143 plastic; 195 paper-merged=206,186,171
stuff floor: 101 carpet=96,36,108; 114 floor-marble=96,36,108; 115 floor-other=96,36,108; 116 floor-stone=96,36,108
stuff floor: 117 floor-tile=96,36,108; 118 floor-wood=218,88,184; 190 floor-other-merged=96,36,108
stuff ceiling: 102 ceiling-other=146,139,141; 103 ceiling-tile=146,139,141; 186 ceiling-merged=146,139,141
stuff sky: 106 clouds=70,130,180; 157 sky-other=70,130,180; 187 sky-other-merged=70,130,180
stuff ground: 111 dirt=208,229,228; 125 gravel=124,74,181; 126 ground-other; 136 mud; 140 pavement
stuff ground: 144 platform=255,180,195; 145 playingfield=106,154,176; 147 railroad=230,150,140; 149 road=128,64,128
stuff ground: 154 sand=254,212,124; 159 snow=255,255,255; 191 pavement-merged=96,96,96; 194 dirt-merged=208,229,228
stuff structural: 113 fence=190,153,153; 138 net=193,0,92; 185 fence-merged=190,153,153
stuff water: 120 fog; 148 river=60,143,255; 155 sea=73,77,174; 178 water-other=58,41,149; 179 waterdrops
stuff food-stuff: 121 food-other=152,161,64; 122 fruit=217,17,255; 153 salad; 170 vegetable
stuff food-stuff: 196 food-other-merged=152,161,64
stuff solid: 127 hill; 135 mountain; 150 rock=0,114,143; 160 solid-other; 162 stone; 182 wood
stuff solid: 192 mountain-merged=64,170,64; 198 rock-merged=0,114,143
stuff wall: 171 wall-brick=137,54,74; 172 wall-concrete=102,102,156; 173 wall-other=102,102,156
stuff wall: 174 wall-panel=102,102,156; 175 wall-stone=135,158,223; 176 wall-tile=7,246,231; 177 wall-wood=107,255,200
stuff wall: 199 wall-other-merged=102,102,156
stuff window: 180 window-blind=183,121,142; 181 window-other=255,73,97
stuff other: 201 other
stuff background: 202 background
"""
