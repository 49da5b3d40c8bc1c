"""Embree's answers to a set of rays: embree.py DIR ANSWERS [fast]. Then: tracebench judge DIR ANSWERS --name embree"""
import json, pathlib, sys, time
import numpy as np
from embreex.mesh_construction import TriangleMesh
from embreex.rtcore_scene import EmbreeScene

rays, out = pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[2])
origin, direction, t_min, t_max = (np.load(rays / f"{name}.npy") for name in ("origin", "direction", "t_min", "t_max"))
manifest = json.loads((rays / "manifest.json").read_text())
assert manifest["query"] == "closest" and not t_min.any(), "embreex takes no t_min: write closest-hit rays that begin at 0"
near = rays if (rays / "positions.npy").exists() else rays.parent
times = [time.perf_counter()]
scene = EmbreeScene(robust="fast" not in sys.argv[3:])
TriangleMesh(scene, np.load(near / "positions.npy"), np.load(near / "triangles.npy").astype("i4"))
scene.run(origin[:1], direction[:1])  # The hierarchy is built with the first rays.
times.append(time.perf_counter())
found = scene.run(origin, direction, dists=t_max, output=1)
times.append(time.perf_counter())
out.mkdir(parents=True, exist_ok=True)
np.save(out / "t.npy", np.where(found["primID"] < 0, np.inf, found["tfar"]).astype("f4"))
np.save(out / "triangle.npy", found["primID"].astype("u4"))  # -1 becomes 4294967295: none.
build_ms, trace_ms = (float(ms) for ms in np.diff(times) * 1e3)
(out / "times.json").write_text(json.dumps({"build_ms": build_ms, "trace_ms": trace_ms}))
(out / "rays_sha256").write_text(manifest["rays_sha256"])
