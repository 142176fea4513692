"""Contact sheets: small pictures in rows, each with its name."""

from pathlib import Path

from PIL import Image, ImageDraw

COLUMNS, ROWS, LINE = 8, 6, 14


def save_sheets(pictures: list[tuple[str, Path]], folder: Path, size: tuple[int, int]) -> list[Path]:
    """Write sheets of 48 pictures and return their files."""
    folder.mkdir(parents=True, exist_ok=True)
    sheets = []
    for start in range(0, len(pictures), COLUMNS * ROWS):
        shown = pictures[start : start + COLUMNS * ROWS]
        sheet = Image.new("RGB", (COLUMNS * size[0], -(-len(shown) // COLUMNS) * (size[1] + LINE)), "white")
        draw = ImageDraw.Draw(sheet)
        for index, (name, file) in enumerate(shown):
            at = (index % COLUMNS * size[0], index // COLUMNS * (size[1] + LINE))
            draw.text((at[0] + 2, at[1]), name.encode("latin-1", "replace").decode("latin-1")[:26], fill="black")
            sheet.paste(Image.open(file), (at[0], at[1] + LINE))
        sheets.append(folder / f"sheet_{len(sheets)}.png")
        sheet.save(sheets[-1])
    return sheets
