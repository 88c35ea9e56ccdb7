"""Mitsuba 3 as a peer: radiosity at surface points by its path integrator, asked line by line.

Started by main.rs beside it, as `by_mitsuba.py SCENE.obj POINTS.f32 THREADS`, where POINTS holds x y z nx ny nz a point. Says
`ready {...}` or `skipped WHY`; then answers each line `SPP SEED OUT.f32` with the seconds it took, OUT holding r g b a
point in W/m2. Scene, hierarchy and kernels are ready before the clock runs.
"""

import array
import glob
import json
import math
import os
import sys
import time

# Samples of all points in flight: what a pass of Mitsuba holds in memory.
LANES = 1 << 22


def find_llvm():
    """Dr.Jit's choice of LLVM may be too old where several are installed: 16 at least, the newest wins."""
    if "DRJIT_LIBLLVM_PATH" in os.environ:
        return
    found = []
    for pattern in ("/usr/lib/*/libLLVM*.so*", "/usr/lib/llvm-*/lib/libLLVM*.so*", "/usr/lib64/libLLVM*.so*"):
        for path in glob.glob(pattern):
            digits = os.path.basename(path).replace("libLLVM", "").replace(".so", "").strip("-.").split(".")[0]
            if digits.isdigit() and int(digits) >= 16:
                found.append((int(digits), path))
    if found:
        os.environ["DRJIT_LIBLLVM_PATH"] = max(found)[1]


def read_mtl(path):
    """Kd and Ke of each material."""
    materials, name = {}, None
    for line in open(path):
        words = line.split()
        if words[:1] == ["newmtl"]:
            name = " ".join(words[1:])
            materials[name] = {"Kd": [0.5] * 3, "Ke": [0.0] * 3}
        elif words[:1] in (["Kd"], ["Ke"]):
            materials[name][words[0]] = [float(x) for x in words[1:4]]
    return materials


def read_obj(path):
    """Triangles (nine numbers each) by material, and the materials."""
    vertices, triangles, materials, name = [], {}, {}, None
    for line in open(path):
        words = line.split("#")[0].split()
        if words[:1] == ["v"]:
            vertices.append([float(x) for x in words[1:4]])
        elif words[:1] == ["mtllib"]:
            materials.update(read_mtl(os.path.join(os.path.dirname(path), " ".join(words[1:]))))
        elif words[:1] == ["usemtl"]:
            name = " ".join(words[1:])
        elif words[:1] == ["f"]:
            corners = [int(w.split("/")[0]) for w in words[1:]]
            corners = [vertices[c - 1 if c > 0 else c] for c in corners]
            for k in range(1, len(corners) - 1):
                triangles.setdefault(name, []).extend(corners[0] + corners[k] + corners[k + 1])
    return triangles, materials


def load(mi, path):
    triangles, materials = read_obj(path)
    scene, points = {"type": "scene"}, []
    for k, (name, soup) in enumerate(triangles.items()):
        material = materials.get(name, {"Kd": [0.5] * 3, "Ke": [0.0] * 3})
        props = mi.Properties()
        props["bsdf"] = mi.load_dict({"type": "diffuse", "reflectance": {"type": "rgb", "value": material["Kd"]}})
        if any(material["Ke"]):
            props["emitter"] = mi.load_dict({"type": "area", "radiance": {"type": "rgb", "value": material["Ke"]}})
        count = len(soup) // 9
        mesh = mi.Mesh("mesh%d" % k, 3 * count, count, has_vertex_normals=False, props=props)
        params = mi.traverse(mesh)
        params["vertex_positions"] = soup
        params["faces"] = list(range(3 * count))
        params.update()
        scene["mesh%d" % k] = mesh
        points += soup
    extent = max(max(points[k::3]) - min(points[k::3]) for k in range(3))
    return mi.load_dict(scene), extent


class Baker:
    """Radiosity at points: a short ray onto each, whose radiance the path integrator finds; B = pi L."""

    def __init__(self, mi, dr, scene, extent, places):
        self.mi, self.dr, self.scene, self.count = mi, dr, scene, len(places) // 6
        column = [mi.Float(list(places[k::6])) for k in range(6)]
        self.n = mi.Vector3f(*column[3:])
        self.o = mi.Point3f(*column[:3]) + self.n * (1e-4 * extent)
        self.integrator = mi.load_dict({"type": "path", "max_depth": -1})
        dr.eval(self.o, self.n)
        dr.sync_thread()

    def part(self, spp, seed):
        """Sums over `spp` samples of each point."""
        mi, dr = self.mi, self.dr
        sampler = mi.load_dict({"type": "independent"})
        sampler.seed(seed, self.count * spp)
        lane = dr.arange(mi.UInt32, self.count * spp) // dr.opaque(mi.UInt32, spp)
        o, n = (dr.gather(type(v), v, lane) for v in (self.o, self.n))
        light, _, _ = self.integrator.sample(self.scene, sampler, mi.RayDifferential3f(o, -n))
        return [dr.block_sum(c, spp) for c in (light.x, light.y, light.z)]

    def step(self, spp):
        """Samples a pass: a power of two, so that passes of one size serve all of a ladder of powers of two."""
        return min(spp, 1 << max(0, int(math.log2(max(1, LANES // self.count)))))

    def bake(self, spp, seed):
        dr = self.dr
        begin, cpu, done, sums = time.perf_counter(), time.process_time(), 0, None
        while done < spp:
            now = min(self.step(spp), spp - done)
            part = self.part(now, (seed * 1_000_003 + done) & 0xFFFFFFFF)
            sums = part if sums is None else [a + b for a, b in zip(sums, part)]
            dr.eval(sums)
            dr.sync_thread()
            done += now
        sums = [c * (math.pi / spp) for c in sums]
        dr.eval(sums)
        dr.sync_thread()
        return time.perf_counter() - begin, time.process_time() - cpu, sums


def main():
    scene_path, points_path, threads = sys.argv[1], sys.argv[2], int(sys.argv[3])
    find_llvm()
    try:
        import drjit as dr
        import mitsuba as mi

        mi.set_variant("llvm_ad_rgb")
        dr.set_thread_count(threads)
        scene, extent = load(mi, scene_path)
    except Exception as e:  # whatever stands in the way of a peer is a reason to go without it
        print("skipped " + " ".join(str(e).split()), flush=True)
        return
    places = array.array("f")
    places.frombytes(open(points_path, "rb").read())
    baker = Baker(mi, dr, scene, extent, places)
    print("ready " + json.dumps({"mitsuba": mi.__version__, "variant": mi.variant(), "threads": threads}), flush=True)
    warm = set()
    for line in sys.stdin:
        spp, seed, out = line.split(maxsplit=2)
        spp, seed = int(spp), int(seed)
        if baker.step(spp) not in warm:
            # Compile, twice: the second pass shows that nothing is left to compile.
            baker.bake(2 * baker.step(spp), 12345)
            warm.add(baker.step(spp))
        seconds, cpu, sums = baker.bake(spp, seed)
        columns = [list(c) for c in sums]
        array.array("f", [x for rgb in zip(*columns) for x in rgb]).tofile(open(out.strip(), "wb"))
        print(json.dumps({"seconds": seconds, "core_seconds": cpu}), flush=True)


main()
