"""Training from memory: a small detector learns from frames that are rendered while it trains.

    python examples/train_live_detector.py [--out FOLDER] [--width PIXELS] [--steps N] [--workers N] [--job CONFIG]

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
from torch.utils.data import DataLoader

from usdsdg.torch import LiveDataset

CONFIG = Path(__file__).parent.parent / "configs" / "detection.yaml"
STRIDE = 8  # pixels of the picture for one of the heat map
MOST_CLASSES = 32


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


def example(sample: dict) -> tuple[torch.Tensor, torch.Tensor, torch.Tensor]:
    """Turn a sample into a picture (3, H, W), heat maps (classes, h, w), and sizes (3, h, w), the last one a mask."""
    picture = sample["rgb"][..., :3].permute(2, 0, 1).float() / 255.0
    rows, columns = picture.shape[1] // STRIDE, picture.shape[2] // STRIDE
    heat, sizes = torch.zeros(MOST_CLASSES, rows, columns), torch.zeros(3, rows, columns)
    boxes = sample["bounding_box_2d_tight"]  # class ids are small: one for each mesh of the job
    y, x = torch.meshgrid(torch.arange(rows), torch.arange(columns), indexing="ij")
    edges = zip(boxes["classId"], boxes["x_min"], boxes["y_min"], boxes["x_max"], boxes["y_max"])
    for label, left, top, right, bottom in edges:
        # Edges are of the first and the last pixel.
        width, height = (right + 1 - left) / STRIDE, (bottom + 1 - top) / STRIDE
        column = min(int((left + right + 1) / 2 / STRIDE), columns - 1)
        row = min(int((top + bottom + 1) / 2 / STRIDE), rows - 1)
        spread = max(float(width), float(height)) / 6 + 0.5
        bump = torch.exp(-((x - column) ** 2 + (y - row) ** 2) / (2 * spread**2))
        heat[int(label)] = torch.maximum(heat[int(label)], bump)
        sizes[:, row, column] = torch.tensor([float(width), float(height), 1.0])
    return picture, heat, sizes


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
    parser.add_argument("--job", default=str(CONFIG), help="a configuration or a script")
    parser.add_argument("--steps", type=int, default=60, help="batches to train on")
    parser.add_argument("--batch", type=int, default=4)
    parser.add_argument("--width", type=int, default=320, help="size of the square pictures [pixels]")
    parser.add_argument("--workers", type=int, default=1, help="processes that render")
    parser.add_argument("--out", default="_out/train_live_detector", help="folder of the weights")
    options = parser.parse_args()
    device = "cuda" if torch.cuda.is_available() else "cpu"
    frames = options.steps * options.batch
    dataset = LiveDataset(
        options.job,
        ["rgb", "bounding_box_2d_tight"],
        arguments=[f"num_frames={frames}", f"resolution=[{options.width},{options.width}]"],
        transform=example,
    )
    # Rendering on CUDA needs processes that were not forked.
    method = "spawn" if device == "cuda" else None
    loader = DataLoader(dataset, options.batch, num_workers=options.workers, multiprocessing_context=method)
    detector = Detector().to(device)
    optimizer = torch.optim.AdamW(detector.parameters(), 1e-3)
    started = asked = time.perf_counter()
    waited, losses, last = 0.0, [], torch.zeros(0, 3, options.width, options.width)
    for step, batch in enumerate(loader):
        if step == 0:
            started = time.perf_counter()  # from the first picture on
        else:
            waited += time.perf_counter() - asked
        loss = loss_of(detector, *(each.to(device) for each in batch))
        optimizer.zero_grad()
        loss.backward()
        optimizer.step()
        losses.append(loss.item())
        last = batch[0][:4].to(device)
        asked = time.perf_counter()
    seconds = time.perf_counter() - started
    tenth = max(len(losses) // 10, 1)
    print(f"{sum(p.numel() for p in detector.parameters()) / 1e6:.1f} million parameters, on {device}")
    print(f"loss: {sum(losses[:tenth]) / tenth:.2f} at first, {sum(losses[-tenth:]) / tenth:.2f} at the end")
    print(f"{len(losses) * options.batch / seconds:.1f} samples/s; {100 * waited / seconds:.0f} % of the time waiting")
    folder = Path(options.out)
    folder.mkdir(parents=True, exist_ok=True)
    torch.save(detector.state_dict(), folder / "detector.pt")
    save_found(detector, last, folder / "detector.png")


if __name__ == "__main__":
    main()
