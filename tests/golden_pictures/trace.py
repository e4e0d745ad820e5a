#!/usr/bin/env python3
"""Traces traced.png with POV-Ray (Debian's povray), for tests/traced_picture_test.cpp. Only who changes the scene runs it:

    tests/golden_pictures/trace.py tests/golden_pictures/traced.png

Nothing of Palpate takes part: bodies are POV-Ray's own sphere, box and cylinder, the camera is its own pinhole, and the
equations below are written from docs/conventions.md. World: m, y up. Camera: x right, y down, z forward; pixel (0, 0) is
the centre of the first one. Light: of the lamp by Lambert's law, of the room more from above than from below.
"""
import math
import pathlib
import struct
import subprocess
import sys
import tempfile
import zlib

WIDTH, HEIGHT = 640, 480
FX, FY, CX, CY = 560.0, 561.5, 318.7, 242.1
EYE, AT = (0.02, -0.95, 2.30), (0.0, -1.45, 1.40)
LAMP, KEY, AMBIENT = (0.45, 0.55, 1.95), 0.95, 0.42
IMAGE = 180           # the camera's image, everywhere; bytes hold the square root of light
FINE = 6              # rays per pixel, along each side


def unit(a):
    length = math.sqrt(sum(x * x for x in a))
    return tuple(x / length for x in a)


def cross(a, b):
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def combined(*terms):
    return tuple(sum(s * a[i] for s, a in terms) for i in range(3))


def pov(a):
    return "<" + ", ".join(f"{x:.12g}" for x in a) + ">"


def camera():
    forward = unit(combined((1, AT), (-1, EYE)))
    right = unit(cross(forward, (0, 1, 0)))
    down = cross(forward, right)
    # POV-Ray's ray is direction + x right + y up, x and y from -1/2 to 1/2 over the picture: the pixel in its middle is
    # (WIDTH - 1) / 2, which is not the principal point.
    direction = combined((1, forward), (((WIDTH - 1) / 2 - CX) / FX, right), (((HEIGHT - 1) / 2 - CY) / FY, down))
    return (f"camera {{ perspective location {pov(EYE)} direction {pov(direction)}"
            f" right {pov(combined((WIDTH / FX, right)))} up {pov(combined((-HEIGHT / FY, down)))} }}")


def turned(axis, angle, place):
    """As POV-Ray's matrix, whose rows are the images of the axes."""
    x, y, z = unit(axis)
    c, s = math.cos(angle), math.sin(angle)
    d = 1 - c
    columns = ((c + x * x * d, y * x * d + z * s, z * x * d - y * s),
               (x * y * d - z * s, c + y * y * d, z * y * d + x * s),
               (x * z * d + y * s, y * z * d - x * s, c + z * z * d))
    numbers = [f"{n:.12g}" for column in columns for n in column] + [f"{n:.12g}" for n in place]
    return "matrix <" + ", ".join(numbers) + ">"


def scene():
    level = (IMAGE / 255) ** 2
    seen = f"pigment {{ rgb {level:.12g} }} finish {{ ambient 0 diffuse 0 emission 1 }}"  # real: shown as the image has it

    def matt(red, green):  # no blue: how much of a pixel is covered is told by it
        return f"pigment {{ rgb <{red}, {green}, 0> }} finish {{ ambient {0.75 * AMBIENT} diffuse 1 }}"

    def light(place, strength, extra=""):
        return f"light_source {{ {pov(place)} rgb {strength:.12g} {extra} shadowless }}"

    return "\n".join([
        "#version 3.7;", "global_settings { assumed_gamma 1.0 ambient_light rgb 1 }",
        f"background {{ rgb {level:.12g} }}", camera(),
        light(LAMP, KEY),
        light((0, 1e6, 0), 0.25 * AMBIENT, "parallel point_at <0, 0, 0>"),
        light((0, -1e6, 0), -0.25 * AMBIENT, "parallel point_at <0, 0, 0>"),
        f"sphere {{ <-0.20, -1.40, 1.35>, 0.10 {matt(0.6, 0.25)} }}",
        f"box {{ <-0.08, -0.06, -0.05>, <0.08, 0.06, 0.05> {matt(0.65, 0.1)} {turned((1, 2, 0.5), 0.7, (0.17, -1.40, 1.45))} }}",
        # Half sunk in the table.
        f"box {{ <-0.06, -0.05, -0.06>, <0.06, 0.05, 0.06> {matt(0.3, 0.3)} {turned((0.2, 1, -0.3), 0.9, (-0.06, -1.52, 1.60))} }}",
        # The lower corner behind a real box.
        f"cylinder {{ <0, -0.005, 0>, <0, 0.005, 0>, 0.10 {matt(0.1, 0.65)} {turned((1, 0.1, 0.4), 1.0, (0.0, -1.25, 1.20))} }}",
        f"box {{ <0.02, -1.52, 1.30>, <0.12, -1.20, 1.40> {seen} }}",
        f"box {{ <-0.375, -1.53, 0.8>, <0.375, -1.52, 1.8> {seen} }}",
        f"box {{ <-0.375, -1.52, 0.79>, <0.375, -0.92, 0.8> {seen} }}"])


def traced(folder):
    (folder / "scene.pov").write_text(scene())
    subprocess.run(["povray", "+Iscene.pov", "+Oscene.ppm", f"+W{FINE * WIDTH}", f"+H{FINE * HEIGHT}", "+FP16", "-A", "-D",
                    "File_Gamma=1.0"], cwd=folder, check=True, stderr=subprocess.PIPE)
    data = (folder / "scene.ppm").read_bytes()
    light = data[-6 * FINE * FINE * WIDTH * HEIGHT:]  # after a header with comments
    assert data[:-len(light)].endswith(f"\n{FINE * WIDTH} {FINE * HEIGHT}\n65535\n".encode()), data[:80]
    return struct.iter_unpack(f">{3 * FINE * WIDTH}H", light)


def averaged(rows):
    """Light is averaged as light, then its root taken."""
    picture = []
    for _ in range(HEIGHT):
        sums = [sum(column) for column in zip(*(next(rows) for _ in range(FINE)))]
        line = bytearray()
        for u in range(WIDTH):
            for c in range(3):
                light = sum(sums[3 * FINE * u + c:3 * FINE * (u + 1):3]) / (FINE * FINE * 65535)
                line.append(round(255 * math.sqrt(light)))
        picture.append(bytes(line))
    return picture


def png(picture):
    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
    lines = []
    for line in picture:  # each pixel less the one on its left
        lines.append(b"\1" + bytes((b - a) % 256 for a, b in zip(bytes(3) + line[:-3], line)))
    return (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", WIDTH, HEIGHT, 8, 2, 0, 0, 0))
            + chunk(b"IDAT", zlib.compress(b"".join(lines), 9)) + chunk(b"IEND", b""))


if len(sys.argv) != 2:
    sys.exit(__doc__)
with tempfile.TemporaryDirectory() as scratch:
    pathlib.Path(sys.argv[1]).write_bytes(png(averaged(traced(pathlib.Path(scratch)))))
