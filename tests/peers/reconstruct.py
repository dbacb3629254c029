"""Poisson reconstruction beside Open3D's, on the vertices and normals of scans as raw points.

usage: reconstruct.py PROGRAM SCAN...

PROGRAM is what `cargo build --release -p sim_reconstruct --example reconstruct` makes. Needs numpy and open3d. Open3D
gets the same points and normals, depth 9. Its surface has balloons over the holes; what is farther than 3 mm from any
point is cut off before distances are measured. Distances in millimetres: from points to surface, and from surface to
points.
"""

import json
import pathlib
import subprocess
import sys
import tempfile
import time

import numpy as np
import open3d as o3d

BALLOON_MM = 3.0
SURFACE_SAMPLES = 100_000


def distances_to_mesh(mesh, points):
    scene = o3d.t.geometry.RaycastingScene()
    scene.add_triangles(o3d.t.geometry.TriangleMesh.from_legacy(mesh))
    return scene.compute_distance(o3d.core.Tensor(points.astype(np.float32))).numpy()


def to_surface_and_back(mesh, cloud):
    """(RMS, largest) of points to surface, then of surface to points."""
    there = distances_to_mesh(mesh, np.asarray(cloud.points))
    o3d.utility.random.seed(0)
    samples = mesh.sample_points_uniformly(SURFACE_SAMPLES)
    back = np.asarray(samples.compute_point_cloud_distance(cloud))
    return [(float(np.sqrt(np.mean(d ** 2))), float(d.max())) for d in (there, back)]


def ours(program, cloud, folder):
    scan, result = folder / "scan.ply", folder / "mesh.ply"
    o3d.io.write_point_cloud(str(scan), cloud)
    run = subprocess.run([program, scan, result], check=True, capture_output=True, text=True)
    return o3d.io.read_triangle_mesh(str(result)), json.loads(run.stdout)["total_seconds"]


def open3ds(cloud):
    start = time.perf_counter()
    mesh, _ = o3d.geometry.TriangleMesh.create_from_point_cloud_poisson(cloud, depth=9)
    seconds = time.perf_counter() - start
    far = np.asarray(o3d.geometry.PointCloud(mesh.vertices).compute_point_cloud_distance(cloud))
    mesh.remove_vertices_by_mask(far > BALLOON_MM)
    return mesh, seconds


def main(program, *scans):
    print(f"{'scan':12} {'by':7} {'s':>6} {'vertices':>8}   to surface: RMS, max   to points: RMS, max")
    with tempfile.TemporaryDirectory() as folder:
        for scan in map(pathlib.Path, scans):
            source = o3d.io.read_triangle_mesh(str(scan))
            cloud = o3d.geometry.PointCloud(source.vertices)
            cloud.normals = source.vertex_normals
            results = {"ours": ours(program, cloud, pathlib.Path(folder)), "open3d": open3ds(cloud)}
            for name, (mesh, seconds) in results.items():
                (there, there_max), (back, back_max) = to_surface_and_back(mesh, cloud)
                print(f"{scan.stem:12} {name:7} {seconds:6.2f} {len(mesh.vertices):8}   {there:10.4f} {there_max:9.3f}"
                      f"   {back:10.4f} {back_max:9.3f}", flush=True)


if __name__ == "__main__":
    if len(sys.argv) < 3:
        sys.exit(__doc__)
    main(*sys.argv[1:])
