#!/usr/bin/env python3
"""Writes a mesh as a .glb: a rough torus knot over wavy ground, about 200,000 triangles; the same bytes on every machine.

python3 scenes/knot.py OUT.glb
"""
import array
import json
import math
import struct
import sys


# Points around the knot's tube, along it, and along an edge of the ground.
AROUND, ALONG, EDGE = 96, 900, 121


def grid(rows, columns, point, wraps):
    """Points of a grid, and two triangles a cell; it closes upon itself where it wraps."""
    points = [point(row, column) for row in range(rows) for column in range(columns)]
    triangles = []
    for row in range(rows if wraps else rows - 1):
        for column in range(columns if wraps else columns - 1):
            below, beside = (row + 1) % rows, (column + 1) % columns
            a, b = row * columns + column, row * columns + beside
            c, d = below * columns + column, below * columns + beside
            triangles += [(a, b, d), (a, d, c)]
    return points, triangles


def centre(turn):
    """The centre line of a (2, 3) torus knot at an angle."""
    radius = 2.0 + math.cos(3.0 * turn)
    return radius * math.cos(2.0 * turn), 2.2 + math.sin(3.0 * turn), radius * math.sin(2.0 * turn)


def unit(vector):
    length = math.sqrt(sum(x * x for x in vector))
    return tuple(x / length for x in vector)


def cross(a, b):
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


def on_knot(row, column):
    turn, around = 2.0 * math.pi * row / ALONG, 2.0 * math.pi * column / AROUND
    here, ahead = centre(turn), centre(turn + 1e-4)
    along = unit([b - a for a, b in zip(here, ahead)])
    side = unit(cross(along, (0.0, 1.0, 0.0)))
    up = cross(side, along)
    radius = 0.42 + 0.05 * math.sin(24.0 * turn) * math.cos(5.0 * around) + 0.02 * math.cos(60.0 * turn)
    # Rounded, so that libraries whose sines differ in the last bit write the same bytes.
    return tuple(
        round(h + radius * (math.cos(around) * s + math.sin(around) * u), 5) for h, s, u in zip(here, side, up)
    )


def on_ground(row, column):
    x, z = 10.0 * row / (EDGE - 1) - 5.0, 10.0 * column / (EDGE - 1) - 5.0
    return round(x, 5), round(0.25 * math.sin(1.7 * x) * math.cos(1.3 * z), 5), round(z, 5)


def main(path):
    points, triangles = grid(ALONG, AROUND, on_knot, True)
    ground, of_ground = grid(EDGE, EDGE, on_ground, False)
    triangles += [tuple(len(points) + corner for corner in triangle) for triangle in of_ground]
    points += ground
    positions = array.array("f", [x for point in points for x in point])
    indices = array.array("I", [corner for triangle in triangles for corner in triangle])
    if sys.byteorder == "big":
        positions.byteswap()
        indices.byteswap()
    data = positions.tobytes() + indices.tobytes()
    ends = [[end(point[axis] for point in points) for axis in range(3)] for end in (min, max)]
    document = {
        "asset": {"version": "2.0"},
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "buffers": [{"byteLength": len(data)}],
        "bufferViews": [
            {"buffer": 0, "byteLength": 4 * len(positions)},
            {"buffer": 0, "byteOffset": 4 * len(positions), "byteLength": 4 * len(indices)},
        ],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": len(points), "type": "VEC3", "min": ends[0], "max": ends[1]},
            {"bufferView": 1, "componentType": 5125, "count": len(indices), "type": "SCALAR"},
        ],
    }
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    chunks = [struct.pack("<II", len(part), kind) + part for part, kind in ((text, 0x4E4F534A), (data, 0x004E4942))]
    length = 12 + sum(map(len, chunks))
    with open(path, "wb") as file:
        file.write(struct.pack("<4sII", b"glTF", 2, length) + b"".join(chunks))
    print(f"{path}: {len(triangles)} triangles")


if len(sys.argv) != 2:
    sys.exit(__doc__)
try:
    main(sys.argv[1])
except OSError as error:
    sys.exit(f"{error}: name a file in a folder that is there")
