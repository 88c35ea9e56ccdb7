#!/usr/bin/env python3
"""Makes the scenes beside it: one sound room (sound.obj), and the same room with one fault each.

Each fault is one change to the room; tests/doctor.rs says what must be found.
"""
from pathlib import Path

HERE = Path(__file__).parent
W, H, D = 5.0, 3.0, 4.0  # the room, metres


def quad(a, b, c, d):
    """Two triangles; counter-clockwise seen from the lit side."""
    return [(a, b, c), (a, c, d)]


def flip(triangles):
    return [(a, c, b) for a, b, c in triangles]


def box(x0, y0, z0, x1, y1, z1):
    """A box seen from outside."""
    p = [(x, y, z) for x in (x0, x1) for y in (y0, y1) for z in (z0, z1)]
    sides = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    return [t for s in sides for t in quad(*(p[i] for i in s))]


def move(triangles, by):
    return [tuple(tuple(c + d for c, d in zip(v, by)) for v in t) for t in triangles]


def room():
    """Object name to (material, triangles)."""
    y = H - 0.1
    return {
        "floor": ("grey", quad((0, 0, 0), (0, 0, D), (W, 0, D), (W, 0, 0))),
        "ceiling": ("grey", quad((0, H, 0), (W, H, 0), (W, H, D), (0, H, D))),
        "left": ("grey", quad((0, 0, 0), (0, H, 0), (0, H, D), (0, 0, D))),
        "right": ("grey", quad((W, 0, 0), (W, 0, D), (W, H, D), (W, H, 0))),
        "back": ("grey", quad((0, 0, 0), (W, 0, 0), (W, H, 0), (0, H, 0))),
        "front": ("grey", quad((0, 0, D), (0, H, D), (W, H, D), (W, 0, D))),
        "crate": ("grey", box(1, 0, 1, 2, 1, 2)),
        "lamp": ("lamp", quad((2, y, 1.5), (3, y, 1.5), (3, y, 2.5), (2, y, 2.5))),
    }


def write(name, about, objects, library="room.mtl"):
    lines = [f"# {about}; made by make.py", f"mtllib {library}"]
    number = {}
    faces = []
    for obj, (material, triangles) in objects.items():
        faces += [f"o {obj}", f"usemtl {material}"]
        for t in triangles:
            for v in t:
                if v not in number:
                    number[v] = len(number) + 1
                    lines.append("v " + " ".join(f"{c:.12g}" for c in v))
            faces.append("f " + " ".join(str(number[v]) for v in t))
    (HERE / f"{name}.obj").write_text("\n".join(lines + faces) + "\n")


def change(obj, triangles):
    """The room with an object's triangles changed."""
    scene = room()
    material, old = scene[obj]
    scene[obj] = (material, triangles(old))
    return scene


def every(f):
    """The whole room, moved or scaled."""
    return {k: (m, [tuple(f(v) for v in t) for t in ts]) for k, (m, ts) in room().items()}


def with_object(name, triangles, material="grey"):
    return {**room(), name: (material, triangles)}


materials = "newmtl grey\nKd 0.5 0.5 0.5\nnewmtl lamp\nKd 0 0 0\nKe 10 10 10\n"
(HERE / "room.mtl").write_text(materials)
(HERE / "white.mtl").write_text(materials + "newmtl white\nKd 1.2 1.2 1.2\n")
(HERE / "nan.mtl").write_text(materials + "newmtl odd\nKd 0.5 nan 0.5\n")

write("sound", "nothing is wrong", room())
needle = ((2.5, 0.5, 1), (3, 0.5, 1), (3.5, 0.5, 1))
write("degenerate", "the crate has a triangle without an area", change("crate", lambda t: t + [needle]))
write("duplicate", "the floor is there twice", change("floor", lambda t: t + t))
write("flipped", "the crate is inside out", change("crate", flip))
write("flipped_face", "one triangle of the crate is wound the other way", change("crate", lambda t: t[:-1] + flip(t[-1:])))
write("flipped_wall", "the left wall faces out of the room", change("left", flip))
write("hole", "the crate lacks a triangle", change("crate", lambda t: t[:6] + t[7:]))
lifted = quad((0, 0.004, 0), (0, H, 0), (0, H, D), (0, 0.004, D))
write("slit", "the left wall ends 4 mm above the floor", change("left", lambda t: lifted))
write("intersecting", "the crate stands in the left wall", change("crate", lambda t: move(t, (-1.5, 0, 0))))
rug = quad((3, 0, 1), (3, 0, 2), (4, 0, 2), (4, 0, 1))
write("overlapping", "a rug lies in the plane of the floor", with_object("rug", rug))
write("far", "the room lies a thousand kilometres away", every(lambda v: (v[0] + 1e6, v[1], v[2])))
write("kilometres", "the room was drawn in millimetres", every(lambda v: tuple(1000 * c for c in v)))
write("tiny", "the room was drawn in kilometres", every(lambda v: tuple(0.001 * c for c in v)))
bright = room()
bright["floor"] = ("white", bright["floor"][1])
write("reflectance", "the floor reflects more than it gets", bright, "white.mtl")
odd = room()
odd["floor"] = ("odd", odd["floor"][1])
write("nan", "the floor's reflectance is not a number", odd, "nan.mtl")
write("lamp_away", "the lamp shines at the ceiling's back", change("lamp", lambda t: move(flip(t), (0, 0.2, 0))))
dark = room()
dark["lamp"] = ("grey", dark["lamp"][1])
write("no_emitter", "nothing shines", dark)
