"""Write the gallery anew: run every example and make a page of what it says, its pictures and its code.

python docs/make_gallery.py [EXAMPLE ...]
"""

from __future__ import annotations

import ast
import os
import re
import subprocess
import sys
import tempfile
from pathlib import Path

import cv2
import numpy as np
import trimesh

DOCS = Path(__file__).parent
EXAMPLES = DOCS.parent / "examples"
GALLERY = DOCS / "gallery"
WIDE = 1200
"""pixels of a picture"""


def main(names: list[str]) -> None:
    (GALLERY / "pictures").mkdir(parents=True, exist_ok=True)
    examples = sorted(EXAMPLES.glob("[0-9]*.py"))
    for example in examples:
        if not names or example.stem in names:
            with tempfile.TemporaryDirectory() as folder:
                said = run(example, Path(folder))
                pictures = [p for file in sorted(Path(folder).iterdir()) if (p := picture(example.stem, file))]
            (GALLERY / f"{example.stem}.md").write_text(page(example, said, pictures), encoding="utf-8")
    (GALLERY / "README.md").write_text(index(examples), encoding="utf-8")


def run(example: Path, folder: Path) -> str:
    """What an example says, without the folder that it was told and without times, which differ from run to run."""
    env = {**os.environ, "PYTHONPATH": str(DOCS.parent)}
    done = subprocess.run(
        [sys.executable, example, "."], cwd=folder, capture_output=True, text=True, env=env, check=True
    )
    return "\n".join(line for line in done.stdout.splitlines() if not line.endswith(" s"))


def picture(stem: str, file: Path) -> str | None:
    """A picture of a file that an example wrote, beside its page; None for files that are none."""
    name = f"pictures/{stem}-{file.stem}"
    if file.suffix == ".svg":
        (GALLERY / f"{name}.svg").write_bytes(file.read_bytes())
        return f"{name}.svg"
    if file.suffix == ".pgm" or (file.suffix == ".glb" and not file.with_suffix(".svg").exists()):
        image = cv2.imread(str(file), cv2.IMREAD_GRAYSCALE) if file.suffix == ".pgm" else seen_aslant(file)
        cv2.imwrite(str(GALLERY / f"{name}.png"), image, [cv2.IMWRITE_PNG_COMPRESSION, 9])
        return f"{name}.png"
    return None


def seen_aslant(file: Path) -> np.ndarray:
    """(H, W, 3) BGR: a model from above and the side, what is nearer over what is farther."""
    corners, colors = [], []
    for mesh in trimesh.load_scene(file).dump():
        if isinstance(mesh, trimesh.Trimesh):
            corners.append(mesh.triangles)
            colors.append(np.broadcast_to(mesh.visual.material.main_color[:3], (len(mesh.triangles), 3)))
    triangles, color = np.concatenate(corners), 255 * (np.concatenate(colors) / 255) ** (1 / 2.2)  # glTF: linear
    turn, tilt = np.radians(-25), np.radians(55)
    x, height, z = triangles[..., 0], triangles[..., 1], -triangles[..., 2]  # glTF: y is up
    u, away = x * np.cos(turn) - z * np.sin(turn), x * np.sin(turn) + z * np.cos(turn)
    v, near = away * np.sin(tilt) + height * np.cos(tilt), height * np.sin(tilt) - away * np.cos(tilt)
    scale = (WIDE - 40) / np.ptp(u)
    seen = np.stack([20 + (u - u.min()) * scale, 20 + (v.max() - v) * scale, near], -1)
    normal = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-12)
    lit = color * (0.72 + 0.28 * np.abs(normal @ [0.3, 0.9, 0.3]))[:, None]
    image = np.full((int(np.ptp(v) * scale) + 40, WIDE, 3), 255, np.uint8)
    nearest = np.full(image.shape[:2], -np.inf)
    for corner, shade in zip(seen, lit[:, ::-1], strict=True):
        fill(image, nearest, corner, shade)
    return image


def fill(image: np.ndarray, nearest: np.ndarray, corner: np.ndarray, shade: np.ndarray) -> None:
    """Draw a triangle (3, 3) of x, y [pixels] and nearness where nothing nearer stands yet."""
    (x0, y0), (x1, y1) = np.floor(corner[:, :2].min(0)).astype(int), np.ceil(corner[:, :2].max(0)).astype(int) + 1
    px, py = np.meshgrid(np.arange(x0, x1), np.arange(y0, y1))
    (ax, ay, az), (bx, by, bz), (cx, cy, cz) = corner
    area = (bx - ax) * (cy - ay) - (cx - ax) * (by - ay)
    if abs(area) < 1e-9:
        return
    b = ((px - ax) * (cy - ay) - (cx - ax) * (py - ay)) / area
    c = ((bx - ax) * (py - ay) - (px - ax) * (by - ay)) / area
    depth = az + b * (bz - az) + c * (cz - az)
    here = (b >= 0) & (c >= 0) & (b + c <= 1) & (depth > nearest[y0:y1, x0:x1])
    nearest[y0:y1, x0:x1][here] = depth[here]
    image[y0:y1, x0:x1][here] = shade.astype(np.uint8)


def page(example: Path, said: str, pictures: list[str]) -> str:
    """Title, story, pictures, what it says, and its code."""
    code = example.read_text(encoding="utf-8")
    heading, story, command = told(code)
    shown = "\n\n".join(f"![{heading}]({p})" for p in pictures)
    body = code.split('"""', 2)[2].strip()
    parts = [
        f"# {heading}",
        story,
        shown,
        f"```\n$ {command}\n{said}\n```",
        f"## The code\n\n[`examples/{example.name}`](../../examples/{example.name})\n\n```python\n{body}\n```",
        "[Gallery](README.md)",
    ]
    return "\n\n".join(p for p in parts if p) + "\n"


def told(code: str) -> tuple[str, str, str]:
    """Title, story and command line of an example, as its docstring has them."""
    title, *story, command = (ast.get_docstring(ast.parse(code)) or "").split("\n\n")
    return title.rstrip("."), "\n\n".join(story), re.sub(r" \[.*?\]", "", command.strip())


def index(examples: list[Path]) -> str:
    rows = []
    for example in examples:
        title, story, _ = told(example.read_text(encoding="utf-8"))
        rows.append(f"- [{title}]({example.stem}.md): {story.split('. ')[0].replace(chr(10), ' ').rstrip('.')}.")
    listed = "\n".join(rows)
    story = "What scripts do with a map. `python docs/make_gallery.py` runs them and writes these pages."
    return f"# Gallery\n\n{story}\n\n{listed}\n"


if __name__ == "__main__":
    main(sys.argv[1:])
