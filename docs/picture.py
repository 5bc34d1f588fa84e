"""The picture at the head of the README: a part file, its mesh, and a rim beside marching cubes.

    python3 docs/picture.py docs/lever.png

Both meshes have `--size 0.05`. Needs Pillow and a monospaced font (the variable FONT); the command is taken from
`target/release` or from the variable RVACHEV.
"""
import os
import subprocess
import sys
import tempfile
from pathlib import Path

from PIL import Image, ImageDraw, ImageFont

ROOT = Path(__file__).resolve().parent.parent
OURS = os.environ.get("RVACHEV", ROOT / "target" / "release" / "rvachev")
FONT = os.environ.get("FONT", "/usr/share/fonts/truetype/dejavu/DejaVuSansMono.ttf")
PART = ROOT / "data" / "lever.py"
# Half of the picture's width, the heights of its rows, and that of the line between them.
WIDE, UPPER, LOWER, HEAD = 800, 450, 496, 40
# The ball that the lower row shows, and the left, upper, right and lower side of what is taken of its picture.
CENTER, RADIUS = (0.35, -0.15, 0.2), 0.33
ZOOMS = {"mc": ("marching cubes", (188, 215, 838, 621)), "leaf": ("rvachev", (205, 205, 855, 611))}
PAPER, INK = (245, 247, 251), (27, 35, 48)


def run(*words):
    subprocess.run([OURS, *(str(w) for w in words), "-q"], check=True)


def cut_out(mesh, out):
    """The triangles of an OBJ file that lie within the ball."""
    nodes, lines = [], []
    for line in mesh.read_text().splitlines():
        kind, *words = line.split() or [""]
        if kind == "v":
            nodes.append([float(w) for w in words])
        if kind == "f":
            corners = [nodes[int(w.split("/")[0]) - 1] for w in words]
            if any(sum((a - b) ** 2 for a, b in zip(p, CENTER)) > RADIUS**2 for p in corners):
                continue
        lines.append(line)
    out.write_text("\n".join(lines) + "\n")


def main():
    sheet = Image.new("RGB", (2 * WIDE, UPPER + HEAD + LOWER), PAPER)
    draw = ImageDraw.Draw(sheet)
    text = "\n".join(PART.read_text().splitlines()[2:])
    draw.multiline_text((30, 44), text, INK, ImageFont.truetype(FONT, 19), spacing=6)
    with tempfile.TemporaryDirectory() as folder:
        at = Path(folder)
        for i, (method, (head, crop)) in enumerate(ZOOMS.items()):
            mesh, whole, zoom = at / f"{method}.obj", at / f"{method}.png", at / "zoom.png"
            run("mesh", PART, "-o", mesh, "--size", 0.05, "--method", method, "--groups", "faces", "--png", whole)
            cut_out(mesh, at / "zoom.obj")
            run("render", at / "zoom.obj", "-o", zoom)
            part = Image.open(zoom).convert("RGB").crop(crop).resize((WIDE - 8, LOWER - 8), Image.Resampling.LANCZOS)
            left, top = i * WIDE + 4, UPPER + HEAD + 4
            sheet.paste(part, (left, top))
            draw.text((left + WIDE / 2, UPPER + 8), head, INK, ImageFont.truetype(FONT, 22), anchor="ma")
        part = Image.open(whole).convert("RGB").crop((0, 120, 1200, 780))
        part = part.resize((WIDE, 440), Image.Resampling.LANCZOS)
        sheet.paste(part, (WIDE, 10))
    sheet.quantize(255, kmeans=8, dither=Image.Dither.NONE).save(sys.argv[1], optimize=True)


main()
