"""open3d_surface.py FRAMES OUT.ply [--voxel 0.01] [--far 3.5]: Open3D's fusion of what surface_of_recording --frames wrote.

ScalableTSDFVolume at the voxels and truncation of lcmslam's fine level, on one thread. The PLY has the mesh's vertices with
normals and colours. Needs Debian's python3-open3d.
"""

import argparse
import os
import time
from pathlib import Path

os.environ["OMP_NUM_THREADS"] = "1"  # before Open3D is there

import numpy as np
import open3d as o3d


def fuse(folder, voxel, far):
    volume = o3d.pipelines.integration.ScalableTSDFVolume(
        voxel_length=voxel, sdf_trunc=4 * voxel, color_type=o3d.pipelines.integration.TSDFVolumeColorType.RGB8)
    times = []
    for line in (folder / "cameras.txt").read_text().splitlines():
        number, *values = line.split()
        fx, fy, cx, cy, *pose = map(float, values)
        colour = o3d.io.read_image(str(folder / f"{number}.colour.png"))
        depth = o3d.io.read_image(str(folder / f"{number}.depth.png"))
        height, width = np.asarray(depth).shape
        lens = o3d.camera.PinholeCameraIntrinsic(width, height, fx, fy, cx, cy)
        start = time.process_time()
        frame = o3d.geometry.RGBDImage.create_from_color_and_depth(
            colour, depth, depth_scale=1000, depth_trunc=far, convert_rgb_to_intensity=False)
        volume.integrate(frame, lens, np.linalg.inv(np.array(pose).reshape(4, 4)))
        times.append(1000 * (time.process_time() - start))
    return volume, times


def save_vertices(file, mesh):
    floats = [(name, "<f4") for name in ("x", "y", "z", "nx", "ny", "nz")]
    rows = np.zeros(len(mesh.vertices), floats + [(name, "u1") for name in ("red", "green", "blue")])
    columns = np.hstack((mesh.vertices, mesh.vertex_normals, 255 * np.asarray(mesh.vertex_colors) + 0.5))
    for name, column in zip(rows.dtype.names, columns.T):
        rows[name] = column
    header = ["ply", "format binary_little_endian 1.0", f"element vertex {len(rows)}"]
    for name in rows.dtype.names:
        header.append(f"property {'float' if rows.dtype[name] == np.float32 else 'uchar'} {name}")
    file.write_bytes("\n".join(header + ["end_header", ""]).encode() + rows.tobytes())


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("frames", type=Path)
    parser.add_argument("out", type=Path)
    parser.add_argument("--voxel", type=float, default=0.01, help="m")
    parser.add_argument("--far", type=float, default=3.5, help="m")
    options = parser.parse_args()
    volume, times = fuse(options.frames, options.voxel, options.far)
    start = time.process_time()
    mesh = volume.extract_triangle_mesh()
    meshing = 1000 * (time.process_time() - start)
    mesh.compute_vertex_normals()
    print(f"Open3D: {len(times)} keyframes, {np.median(times):.1f} ms each (p95 {np.percentile(times, 95):.1f}), "
          f"{len(mesh.triangles)} triangles in {meshing:.0f} ms")
    save_vertices(options.out, mesh)


main()
