"""Training from memory: a small detector learns from frames that are rendered while it trains.

    python examples/train_live_detector.py [--out FOLDER] [--width PIXELS] [--steps N] [--batch N] [--job SCRIPT]

Every batch is as many worlds of a scene, which are drawn and rendered together and stay on the device.
One fully convolutional network of 1.3 million parameters finds the centers of boxes, with a heat map for each class,
and their sizes. Prints how the loss falls and how much of the time it waits for frames; writes detector.pt, and
detector.png with what it finds in the last pictures, to FOLDER (_out/train_live_detector). Needs torch.
"""

import argparse
import time
from pathlib import Path

import torch
from PIL import Image, ImageDraw
from torch import nn
from torch.nn import functional as F

from usdsdg.torch import LiveDataset

SCENE = Path(__file__).parent / "scenes" / "moving_shapes.py"
STRIDE = 8  # pixels of the picture for one of the heat map
MOST_CLASSES = 32
LEAST_PIXELS = 20  # of an object that is to be found
WARM_UP = 3  # batches that are not timed


def block(inputs: int, outputs: int, stride: int = 1) -> nn.Sequential:
    return nn.Sequential(nn.Conv2d(inputs, outputs, 3, stride, 1, bias=False), nn.BatchNorm2d(outputs), nn.ReLU())


class Detector(nn.Module):
    """From pictures (N, 3, H, W) of 0 to 1: heat maps of classes as logits, and widths and heights in cells."""

    def __init__(self) -> None:
        super().__init__()
        self.body = nn.Sequential(
            block(3, 32, 2), block(32, 64, 2), block(64, 64), block(64, 128, 2), *(block(128, 128) for _ in range(8))
        )
        self.heat = nn.Conv2d(128, MOST_CLASSES, 1)
        self.size = nn.Conv2d(128, 2, 1)
        nn.init.constant_(self.heat.bias, -4.0)  # few cells are centers

    def forward(self, pictures: torch.Tensor) -> tuple[torch.Tensor, torch.Tensor]:
        features = self.body(pictures)
        return self.heat(features), self.size(features)


def examples(batch: dict) -> tuple[torch.Tensor, torch.Tensor, torch.Tensor]:
    """Turn a batch of worlds into pictures (N, 3, H, W), heat maps (N, classes, h, w), and sizes (N, 3, h, w).

    The last one of the sizes is a mask of the cells with a center. All is computed where the batch is.
    """
    pictures = batch["rgb"][..., :3].permute(0, 3, 1, 2).float() / 255.0
    count, rows, columns = len(pictures), pictures.shape[2] // STRIDE, pictures.shape[3] // STRIDE
    boxes = batch["bounding_box_2d_tight"].float()  # (N, prims, 5): visible pixels, first and last column and row
    seen = boxes[..., 0] >= LEAST_PIXELS
    width, height = (boxes[..., 3] + 1 - boxes[..., 1]) / STRIDE, (boxes[..., 4] + 1 - boxes[..., 2]) / STRIDE
    column = ((boxes[..., 1] + boxes[..., 3] + 1) / 2 / STRIDE).long().clamp(0, columns - 1)
    row = ((boxes[..., 2] + boxes[..., 4] + 1) / 2 / STRIDE).long().clamp(0, rows - 1)
    spread = torch.maximum(width, height) / 6 + 0.5
    x, y = torch.arange(columns, device=boxes.device), torch.arange(rows, device=boxes.device)
    across = torch.exp(-((x - column[..., None]) ** 2) / (2 * spread[..., None] ** 2))
    down = torch.exp(-((y - row[..., None]) ** 2) / (2 * spread[..., None] ** 2))
    bumps = torch.where(seen[..., None, None], down[..., :, None] * across[..., None, :], 0.0)  # (N, prims, h, w)
    heat = torch.zeros(count, MOST_CLASSES, rows, columns, device=boxes.device)
    labels = batch["class_ids"][None, :, None, None].expand(count, -1, rows, columns)
    heat.scatter_reduce_(1, labels, bumps, "amax")
    sizes = torch.zeros(count, 3, rows, columns, device=boxes.device)
    world, prim = seen.nonzero(as_tuple=True)
    values = torch.stack([width, height, torch.ones_like(width)], -1)[world, prim]
    sizes[world, :, row[world, prim], column[world, prim]] = values
    return pictures, heat, sizes


def loss_of(detector: Detector, pictures: torch.Tensor, heat: torch.Tensor, sizes: torch.Tensor) -> torch.Tensor:
    """Return the focal loss of the heat maps, and the error of the sizes at centers."""
    logits, found = detector(pictures)
    probability = logits.sigmoid()
    is_center = heat == 1.0
    weight = torch.where(is_center, (1 - probability) ** 2, (1 - heat) ** 4 * probability**2)
    focal = F.binary_cross_entropy_with_logits(logits, is_center.float(), weight.detach(), reduction="sum")
    mask = sizes[:, 2:]
    error = ((found - sizes[:, :2]).abs() * mask).sum()
    return (focal + 0.1 * error) / mask.sum().clamp(min=1.0)


def boxes_found(heat: torch.Tensor, size: torch.Tensor, least: float = 0.3) -> list[list[float]]:
    """Return the boxes [left, top, right, bottom] of one picture, in pixels, at the peaks of its heat maps."""
    score, _ = heat.sigmoid().max(0)
    is_peak = (score == F.max_pool2d(score[None], 3, 1, 1)[0]) & (score > least)
    found = []
    for row, column in is_peak.nonzero().tolist():
        width, height = (size[:, row, column].clamp(min=1.0) * STRIDE).tolist()
        x, y = (column + 0.5) * STRIDE, (row + 0.5) * STRIDE
        found.append([x - width / 2, y - height / 2, x + width / 2, y + height / 2])
    return found


def save_found(detector: Detector, pictures: torch.Tensor, file: Path) -> None:
    """Draw what the detector finds into pictures side by side."""
    detector.eval()
    with torch.no_grad():
        heat, size = detector(pictures)
    width = pictures.shape[3]
    sheet = Image.new("RGB", (width * len(pictures), pictures.shape[2]))
    for place, picture in enumerate(pictures):
        image = Image.fromarray((picture * 255).byte().permute(1, 2, 0).cpu().numpy())
        for box in boxes_found(heat[place], size[place]):
            ImageDraw.Draw(image).rectangle(box, outline=(0, 255, 0), width=2)
        sheet.paste(image, (width * place, 0))
    sheet.save(file, optimize=True)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--job", default=str(SCENE), help="a script whose arguments are frames and width")
    parser.add_argument("--steps", type=int, default=60, help="batches to train on")
    parser.add_argument("--batch", type=int, default=8, help="worlds, which are the pictures of a batch")
    parser.add_argument("--width", type=int, default=320, help="size of the square pictures [pixels]")
    parser.add_argument("--out", default="_out/train_live_detector", help="folder of the weights")
    options = parser.parse_args()
    device = "cuda" if torch.cuda.is_available() else "cpu"
    batches = LiveDataset(
        options.job,
        ["rgb", "bounding_box_2d_tight"],
        arguments=[str(options.steps * options.batch), str(options.width)],
        worlds=options.batch,
        device=device,
    )
    detector = Detector().to(device)
    optimizer = torch.optim.AdamW(detector.parameters(), 1e-3)
    started = asked = time.perf_counter()
    waited, losses, last = 0.0, [], torch.zeros(0, 3, options.width, options.width)
    for step, batch in enumerate(batches):
        if step == WARM_UP:
            started = time.perf_counter()  # kernels are compiled, and memory is there
        elif step > WARM_UP:
            waited += time.perf_counter() - asked
        pictures, heat, sizes = examples(batch)
        loss = loss_of(detector, pictures, heat, sizes)
        optimizer.zero_grad()
        loss.backward()
        optimizer.step()
        losses.append(loss.item())
        last = pictures[:4]
        asked = time.perf_counter()
    seconds = time.perf_counter() - started
    taken = max(len(losses) - WARM_UP, 1) * options.batch
    tenth = max(len(losses) // 10, 1)
    print(f"{sum(p.numel() for p in detector.parameters()) / 1e6:.1f} million parameters, on {device}")
    print(f"loss: {sum(losses[:tenth]) / tenth:.2f} at first, {sum(losses[-tenth:]) / tenth:.2f} at the end")
    print(f"{taken / seconds:.1f} samples/s; {100 * waited / seconds:.0f} % of the time waiting")
    if device == "cuda":
        free, total = torch.cuda.mem_get_info()
        print(f"{(total - free) / 1e9:.2f} GB of device memory in use")
    folder = Path(options.out)
    folder.mkdir(parents=True, exist_ok=True)
    torch.save(detector.state_dict(), folder / "detector.pt")
    save_found(detector, last, folder / "detector.png")


if __name__ == "__main__":
    main()
