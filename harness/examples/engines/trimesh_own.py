"""The answers of trimesh's own test to at most 4,096 rays: trimesh_own.py DIR ANSWERS. Then: tracebench judge DIR ANSWERS --name trimesh"""
import json, pathlib, sys
import numpy as np
import trimesh
from trimesh.ray.ray_triangle import RayMeshIntersector

rays, out = pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[2])
origin, direction, t_min, t_max = (np.load(rays / f"{name}.npy").astype("f8") for name in ("origin", "direction", "t_min", "t_max"))
manifest = json.loads((rays / "manifest.json").read_text())
assert manifest["query"] == "closest", "it tells the nearest hits: write closest-hit rays"
assert len(origin) <= 4096, "it takes too long for more rays: write fewer by --size 64x64"
near = rays if (rays / "positions.npy").exists() else rays.parent
mesh = trimesh.Trimesh(np.load(near / "positions.npy"), np.load(near / "triangles.npy"), process=False)
places, ray, triangle = RayMeshIntersector(mesh).intersects_location(origin, direction, multiple_hits=True)
t = np.einsum("ij,ij->i", places - origin[ray], direction[ray])
ahead = np.lexsort((t, ray))[::-1]  # The nearest of a ray is written last.
ahead = ahead[(t[ahead] >= t_min[ray[ahead]]) & (t[ahead] <= t_max[ray[ahead]])]
answer, named = np.full(len(origin), np.inf), np.full(len(origin), 2**32 - 1, "u4")
answer[ray[ahead]], named[ray[ahead]] = t[ahead], triangle[ahead]
out.mkdir(parents=True, exist_ok=True)
np.save(out / "t.npy", answer)
np.save(out / "triangle.npy", named)
(out / "rays_sha256").write_text(manifest["rays_sha256"])
