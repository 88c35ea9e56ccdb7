#!/usr/bin/env python3
"""Writes scene.obj and scene.mtl: a museum of three rooms, after Fig. 1 of Bohn (1997).

The building is cut from a rectilinear grid of full and empty cells: the faces between them are watertight by
construction. What stands free (sculptures, columns) is turned on a lathe. Metres, y up. Cameras: scene.toml.
"""
import math
import os

MATERIALS = {  # name: (Kd, Ke)
    "plaster": ((0.78, 0.76, 0.72), None),
    "ceiling": ((0.82, 0.81, 0.78), None),
    "red wall": ((0.45, 0.12, 0.10), None),
    "green wall": ((0.16, 0.28, 0.20), None),
    "oak floor": ((0.42, 0.28, 0.16), None),
    "stone floor": ((0.50, 0.48, 0.44), None),
    "plinth": ((0.72, 0.70, 0.66), None),
    "marble": ((0.80, 0.78, 0.74), None),
    "bronze": ((0.30, 0.20, 0.11), None),
    "terracotta": ((0.55, 0.26, 0.15), None),
    "gilt frame": ((0.55, 0.38, 0.12), None),
    "black frame": ((0.05, 0.05, 0.05), None),
    "bench": ((0.25, 0.14, 0.08), None),
    "skylight": ((0.05, 0.05, 0.05), (15.0, 15.5, 16.0)),
    "ochre": ((0.65, 0.45, 0.12), None),
    "cobalt": ((0.06, 0.13, 0.45), None),
    "crimson": ((0.55, 0.06, 0.08), None),
    "teal": ((0.06, 0.35, 0.36), None),
    "cream": ((0.78, 0.72, 0.58), None),
    "ink": ((0.06, 0.06, 0.08), None),
    "rose": ((0.70, 0.42, 0.40), None),
    "leaf": ((0.25, 0.42, 0.10), None),
}

boxes = []  # (low, high, what), later ones over earlier ones; what is a material, or None for air


def box(low, high, what):
    boxes.append((low, high, what))


def room(x0, x1, z0, z1, height, walls, floor):
    """A room: air, with a shell of its own materials 0.2 m thick."""
    t = 0.2
    box((x0 - t, -t, z0 - t), (x1 + t, height + t, z1 + t), walls)
    box((x0, -t, z0), (x1, 0, z1), floor)
    box((x0, height, z0), (x1, height + t, z1), "ceiling")
    box((x0, 0, z0), (x1, height, z1), None)


def skylight(x0, x1, z0, z1, ceiling, depth, bars):
    """A light well with its glass at the top and bars below the glass."""
    box((x0 - 0.1, ceiling + 0.1, z0 - 0.1), (x1 + 0.1, ceiling + depth + 0.1, z1 + 0.1), "plaster")
    box((x0, ceiling, z0), (x1, ceiling + depth, z1), None)
    box((x0, ceiling + depth, z0), (x1, ceiling + depth + 0.1, z1), "skylight")
    for i in range(1, bars):
        x = x0 + (x1 - x0) * i / bars
        box((x - 0.03, ceiling + depth - 0.14, z0), (x + 0.03, ceiling + depth - 0.06, z1), "plaster")


def painting(wall, at, across, middle, width, height, colours, frame):
    """A picture of nested rectangles. `wall`: axis and sign of its normal; `at`: the wall's plane."""
    axis, sign = wall
    w = 0.08

    def slab(c, y, hw, hh, depth, what):
        low, high = [0, 0, 0], [0, 0, 0]
        other = 2 - axis
        low[axis], high[axis] = sorted((at, at + sign * depth))
        low[1], high[1] = y - hh, y + hh
        low[other], high[other] = c - hw, c + hw
        box(tuple(low), tuple(high), what)

    slab(across, middle, width / 2 + w, height / 2 + w, 0.07, frame)
    slab(across, middle, width / 2, height / 2, 0.07, None)
    for i, colour in enumerate(colours):
        f = 1 - i / len(colours)
        slab(across, middle - 0.06 * height * i, f * width / 2, f * height / 2 * 0.94, 0.03, colour)
        if i == 0:
            slab(across, middle, width / 2, height / 2, 0.03, colour)


def plinth(x, z, side, height):
    box((x - side / 2, 0, z - side / 2), (x + side / 2, height, z + side / 2), "plinth")


def bench(x, z, length, depth):
    box((x - length / 2, 0.40, z - depth / 2), (x + length / 2, 0.48, z + depth / 2), "bench")
    for end in (-1, 1):
        e = x + end * (length / 2 - 0.2)
        box((e - 0.06, 0, z - depth / 2 + 0.06), (e + 0.06, 0.40, z + depth / 2 - 0.06), "bench")


# Three rooms in a row, doors in line.
room(0, 7, 0, 6, 4.2, "red wall", "oak floor")
room(18.8, 25.8, 0, 6, 4.2, "green wall", "oak floor")
room(7.4, 18.4, -1, 8, 6, "plaster", "stone floor")
for x0, x1 in ((7, 7.4), (18.4, 18.8)):
    box((x0, 0, 2), (x1, 3.1, 4), None)
    box((x0, -0.2, 2), (x1, 0, 4), "stone floor")
skylight(1.5, 5.5, 2, 4, 4.2, 0.7, 4)
skylight(10, 15.8, 1.6, 5.4, 6, 0.9, 5)
skylight(20.3, 24.3, 2, 4, 4.2, 0.7, 4)
# The red room.
painting((2, 1), 0, 1.9, 1.75, 1.3, 1.6, ["ochre", "cream", "crimson"], "gilt frame")
painting((2, 1), 0, 5.0, 1.75, 1.9, 1.3, ["teal", "cobalt", "cream"], "gilt frame")
painting((0, 1), 0, 3.0, 1.8, 2.2, 1.7, ["ink", "crimson", "ochre", "cream"], "gilt frame")
painting((2, -1), 6, 3.5, 1.75, 2.4, 1.3, ["leaf", "ochre", "teal"], "gilt frame")
plinth(3.5, 3, 0.6, 1.0)
# The hall.
painting((2, 1), -1, 9.6, 2.0, 1.8, 1.8, ["cobalt", "teal", "cream"], "black frame")
painting((2, 1), -1, 12.9, 2.1, 2.8, 2.0, ["crimson", "rose", "ochre", "cream"], "black frame")
painting((2, 1), -1, 16.2, 2.0, 1.8, 1.8, ["ink", "leaf", "ochre"], "black frame")
painting((2, -1), 8, 12.9, 2.1, 3.2, 2.0, ["teal", "ink", "rose"], "black frame")
painting((0, -1), 18.4, 6.2, 1.9, 1.5, 1.7, ["ochre", "crimson", "ink"], "black frame")
painting((0, 1), 7.4, 6.2, 1.9, 1.5, 1.7, ["rose", "cobalt", "ink"], "black frame")
plinth(10.6, 3, 0.8, 0.9)
plinth(15.2, 3, 0.8, 0.9)
bench(12.9, 5.6, 2.4, 0.5)
# The green room.
painting((2, 1), 0, 22.3, 1.8, 2.6, 1.6, ["cream", "ochre", "rose", "crimson"], "gilt frame")
painting((0, -1), 25.8, 3.0, 1.8, 1.6, 1.9, ["cobalt", "cream", "ochre"], "gilt frame")
painting((2, -1), 6, 22.3, 1.75, 1.6, 1.3, ["ink", "teal", "leaf"], "gilt frame")
plinth(22.3, 3, 0.6, 1.1)
bench(22.3, 4.8, 1.8, 0.45)

# The grid, and what fills its cells.
lines = [sorted({round(c, 4) for b in boxes for c in (b[0][k], b[1][k])}) for k in range(3)]
index = [{c: i for i, c in enumerate(axis)} for axis in lines]
size = [len(axis) - 1 for axis in lines]
full = {}
for low, high, what in boxes:
    spans = [range(index[k][round(low[k], 4)], index[k][round(high[k], 4)]) for k in range(3)]
    for i in spans[0]:
        for j in spans[1]:
            for k in spans[2]:
                full[i, j, k] = what
AIR = None


def cell(c):
    return full.get(c, "outside")


vertices, groups = {}, {}


def vertex(p):
    return vertices.setdefault(tuple(round(x, 5) + 0.0 for x in p), len(vertices) + 1)


def face(group, material, points):
    groups.setdefault((group, material), []).append([vertex(p) for p in points])


rectangles = []
for axis in range(3):
    u, v = (axis + 1) % 3, (axis + 2) % 3
    for plane in range(1, size[axis]):
        for sign in (1, -1):
            want = {}
            for a in range(size[u]):
                for b in range(size[v]):
                    c = [0, 0, 0]
                    c[u], c[v] = a, b
                    c[axis] = plane - 1 if sign > 0 else plane
                    behind = cell(tuple(c))
                    c[axis] = plane if sign > 0 else plane - 1
                    if behind not in (AIR, "outside") and cell(tuple(c)) is AIR and tuple(c) in full:
                        want[a, b] = behind
            # Cells of one material become large rectangles.
            while want:
                a, b = min(want)
                material = want[a, b]
                a1 = a
                while want.get((a1 + 1, b)) == material:
                    a1 += 1
                b1 = b
                while all(want.get((i, b1 + 1)) == material for i in range(a, a1 + 1)):
                    b1 += 1
                for i in range(a, a1 + 1):
                    for j in range(b, b1 + 1):
                        del want[i, j]
                ring = [(a, b), (a1 + 1, b), (a1 + 1, b1 + 1), (a, b1 + 1)]
                points = []
                for i, j in ring if sign > 0 else ring[::-1]:
                    p = [0, 0, 0]
                    p[axis], p[u], p[v] = lines[axis][plane], lines[u][i], lines[v][j]
                    points.append(p)
                rectangles.append((material, points))

# Where the corner of one rectangle lies on the side of another, both get it: no edge ends in the middle of another.
corners_on = {}  # by the line they lie on: its axis and its two fixed coordinates
for _, points in rectangles:
    for p in points:
        for axis in range(3):
            corners_on.setdefault((axis, p[(axis + 1) % 3], p[(axis + 2) % 3]), set()).add(p[axis])
for material, points in rectangles:
    ring = []
    for p, q in zip(points, points[1:] + points[:1]):
        axis = next(k for k in range(3) if p[k] != q[k])
        low, high = sorted((p[axis], q[axis]))
        between = [c for c in corners_on[axis, p[(axis + 1) % 3], p[(axis + 2) % 3]] if low < c < high]
        ring.append(p)
        ring += [p[:axis] + [c] + p[axis + 1 :] for c in sorted(between, reverse=p[axis] > q[axis])]
    if len(ring) == 4:
        face("building", material, ring)
        continue
    centre = [sum(p[k] for p in points) / 4 for k in range(3)]
    for p, q in zip(ring, ring[1:] + ring[:1]):
        face("building", material, [centre, p, q])


def lathe(group, material, x, z, profile, sides):
    """Turns a profile of (radius, height), from the bottom up, about the vertical through (x, z)."""
    ring = lambda r, y: [
        (x + r * math.cos(2 * math.pi * i / sides), y, z + r * math.sin(2 * math.pi * i / sides)) for i in range(sides)
    ]
    rings = [ring(r, y) if r > 0 else [(x, y, z)] * sides for r, y in profile]
    for low, high in zip(rings, rings[1:]):
        for i in range(sides):
            j = (i + 1) % sides
            corners = [low[i], high[i], high[j], low[j]]
            corners = [p for n, p in enumerate(corners) if p != corners[n - 1]]
            if len(corners) > 2:
                face(group, material, corners)


def ball(y, r, rings):
    """The profile of a ball."""
    steps = [math.pi * (i / rings - 0.5) for i in range(rings + 1)]
    points = [(max(0.0, r * math.cos(s)), y + r * math.sin(s)) for s in steps]
    return [(0 if p[0] < 1e-9 else p[0], p[1]) for p in points]


GAP = 0.004
for x in (8.6, 17.2):
    for z in (0.4, 6.6):
        lathe("columns", "marble", x, z, [(0.24, 0), (0.24, 0.12), (0.18, 0.2), (0.16, 5.7), (0.24, 5.85), (0.24, 6)], 16)
vase = [(0, 0), (0.10, 0), (0.12, 0.03), (0.07, 0.08), (0.16, 0.22), (0.21, 0.38), (0.19, 0.52), (0.09, 0.66), (0.07, 0.74),
        (0.12, 0.80), (0.10, 0.80), (0.05, 0.74), (0, 0.74)]
lathe("vase", "terracotta", 3.5, 3, [(r, 1.0 + GAP + y) for r, y in vase], 20)
lathe("ball", "marble", 10.6, 3, ball(0.9 + GAP + 0.32, 0.32, 12), 20)
spindle = [(0, 0), (0.2, 0), (0.2, 0.05), (0.05, 0.15), (0.09, 0.45), (0.16, 0.7), (0.05, 0.95), (0.13, 1.15), (0.03, 1.4),
           (0.06, 1.5), (0, 1.62)]
lathe("spindle", "bronze", 15.2, 3, [(r, 0.9 + GAP + y) for r, y in spindle], 16)
bowl = [(0, 0), (0.1, 0), (0.08, 0.06), (0.22, 0.16), (0.3, 0.3), (0.27, 0.3), (0.19, 0.18), (0, 0.12)]
lathe("bowl", "teal", 22.3, 3, [(r, 1.1 + GAP + y) for r, y in bowl], 20)

here = os.path.dirname(os.path.abspath(__file__))
with open(os.path.join(here, "scene.obj"), "w") as f:
    f.write("# A museum of three rooms; made by make.py.\nmtllib scene.mtl\n")
    for p in vertices:
        f.write("v %s %s %s\n" % tuple(f"{x:.9g}" for x in p))
    group = None
    for (name, material), faces in sorted(groups.items()):
        if name != group:
            f.write(f"o {name}\n")
            group = name
        f.write(f"usemtl {material}\n")
        for corners in faces:
            for i in range(1, len(corners) - 1):
                f.write(f"f {corners[0]} {corners[i]} {corners[i + 1]}\n")
with open(os.path.join(here, "scene.mtl"), "w") as f:
    f.write("# Materials of the museum; made by make.py.\n")
    for name, (kd, ke) in MATERIALS.items():
        f.write(f"newmtl {name}\nKd %g %g %g\n" % kd)
        if ke:
            f.write("Ke %g %g %g\n" % ke)
print(sum(len(c) - 2 for g in groups.values() for c in g), "triangles")
