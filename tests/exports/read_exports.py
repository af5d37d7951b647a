"""read_exports.py FOLDER: what write_exports wrote there, as Open3D and numpy read it."""

import csv
import json
import sys
from pathlib import Path

SKIPPED = 77
try:
    import numpy as np
    import open3d as o3d
except ImportError as error:
    print(f"skipped: {error}; ./lcmslam test installs python3-open3d")
    sys.exit(SKIPPED)


def expect(holds, what):
    if not holds:
        sys.exit(f"{what}: not what was written")


def close(read, written, tolerance):
    read, written = np.asarray(read, float), np.asarray(written, float)
    return read.shape == written.shape and np.abs(read - written).max() <= tolerance


def check_mesh(folder, expected):
    written = np.array(expected["vertices"])[np.array(expected["triangles"])]
    colours = np.array(expected["colours"])[np.array(expected["triangles"])] / 255
    for name, up in (("mesh.ply", 2), ("mesh.obj", 2), ("mesh.glb", 1)):
        mesh = o3d.io.read_triangle_mesh(str(folder / name))
        corners = np.asarray(mesh.vertices)[np.asarray(mesh.triangles)]
        if up == 1:  # glTF's y is our z; a reader may or may not apply the node that turns it
            turned = np.stack((written[..., 0], written[..., 2], -written[..., 1]), -1)
            expect(close(corners, turned, 1e-5) or close(corners, written, 1e-5), f"Open3D, {name}: corners")
            continue
        expect(close(corners, written, 1e-5), f"Open3D, {name}: corners")
        read = np.asarray(mesh.vertex_colors)[np.asarray(mesh.triangles)]
        expect(close(read, colours, 2e-3), f"Open3D, {name}: colours")


def check_cloud(folder, expected):
    for name in ("cloud.ply", "cloud.pcd"):
        cloud = o3d.io.read_point_cloud(str(folder / name))
        expect(close(cloud.points, expected["points"], 1e-6), f"Open3D, {name}: points")
        expect(close(cloud.normals, expected["normals"], 1e-6), f"Open3D, {name}: normals")
        expect(close(cloud.colors, np.array(expected["colours"]) / 255, 1e-6), f"Open3D, {name}: colours")


def check_landmarks(folder, expected):
    written = [landmark["mean"] for landmark in expected]
    for name in ("landmarks.ply", "landmarks.pcd"):
        cloud = o3d.io.read_point_cloud(str(folder / name))
        expect(close(cloud.points, written, 1e-6), f"Open3D, {name}: points")
    with open(folder / "landmarks.csv", newline="", encoding="ascii") as file:
        rows = list(csv.DictReader(file))
    expect(close([[row["x"], row["y"], row["z"]] for row in rows], written, 1e-6), "landmarks.csv: places")
    expect([int(row["id"]) for row in rows] == [landmark["id"] for landmark in expected], "landmarks.csv: ids")
    expect(close([row["log_odds"] for row in rows], [l["log_odds"] for l in expected], 1e-6),
           "landmarks.csv: log_odds")


def check_trajectory(folder, expected):
    written = np.array([pose["matrix"] for pose in expected]).reshape(-1, 4, 4)
    stamps = np.array([pose["utime"] for pose in expected]) / 1e6
    tum = np.loadtxt(folder / "robot.tum")
    expect(close(tum[:, 0], stamps, 1e-6), "robot.tum: stamps")
    expect(close(tum[:, 1:4], written[:, :3, 3], 1e-8), "robot.tum: positions")
    for row, pose in zip(tum, written):
        w_x_y_z = row[[7, 4, 5, 6]]
        rotation = o3d.geometry.get_rotation_matrix_from_quaternion(w_x_y_z)
        expect(close(rotation, pose[:3, :3], 1e-8), "robot.tum: rotations")
    kitti = np.loadtxt(folder / "robot.kitti").reshape(-1, 3, 4)
    expect(close(kitti, written[:, :3, :], 1e-9), "robot.kitti")
    expect(close(np.loadtxt(folder / "robot_times.txt"), stamps, 1e-6), "robot_times.txt")


def main():
    folder = Path(sys.argv[1])
    expected = json.loads((folder / "expected.json").read_text())
    check_mesh(folder, expected["mesh"])
    check_cloud(folder, expected["cloud"])
    check_landmarks(folder, expected["landmarks"])
    check_trajectory(folder, expected["trajectory"])


main()
