"""check_recordings.py STAGE PROGRAMS FOLDER: recordings of foreign writers are imported and mapped, our export is read.

STAGE original: batch of logs/kitchen.lcmlog and its export to MCAP, which the others start from.
STAGE export: @mcap/core and Foxglove's parsers read the export; ROS's own definitions are those in it.
STAGE bag: rosbag writes bags (no compression, lz4, bz2); imported and mapped as the log they came from.
STAGE mcap: @mcap/core writes MCAP files (ROS 2 with zstd, ROS 1 with lz4 and uncompressed); likewise.
Exits with 77, after a line that says why, where a writer or reader is not installed.
"""
import filecmp
import json
import os
import shutil
import subprocess
import sys

import numpy as np

HERE = os.path.dirname(os.path.abspath(__file__))
ROOT = os.path.dirname(os.path.dirname(HERE))
LOG = os.path.join(ROOT, "logs", "kitchen.lcmlog")
SKIPPED = 77


class Check:
    def __init__(self, programs, folder):
        self.program = os.path.join(programs, "lcmslam-tools")
        self.folder = folder
        self.environment = dict(os.environ, NODE_PATH=os.path.join(ROOT, "build", "exports", "node_modules"),
                                PYTHONDONTWRITEBYTECODE="1")

    def path(self, name):
        return os.path.join(self.folder, name)

    def run(self, *command):
        done = subprocess.run(command, env=self.environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        if done.returncode == SKIPPED:
            print(done.stdout.strip())
            sys.exit(SKIPPED)
        if done.returncode != 0:
            sys.exit(f"{' '.join(command)}: exit code {done.returncode}\n{done.stdout}")
        return done.stdout

    def node(self, script, *arguments):
        if shutil.which("node") is None:
            print("skipped: no node here")
            sys.exit(SKIPPED)
        return self.run("node", os.path.join(HERE, script), *arguments)

    def batch(self, log, out):
        self.run(self.program, "batch", os.path.join(ROOT, "config", "replay.yaml"), log, "--out", self.path(out),
                 "--force")

    def original(self):
        os.makedirs(self.folder, exist_ok=True)
        self.batch(LOG, "original")
        self.run(self.program, "log", "export", "--force", "--mcap", self.path("original.mcap"), LOG,
                 self.path("original/batch.lcmlog"))
        for compression in ("lz4", "none"):
            self.run(self.program, "log", "export", "--force", "--compression", compression, "--mcap",
                     self.path(f"original-{compression}.mcap"), LOG, self.path("original/batch.lcmlog"))

    def export(self):
        found = json.loads(self.node("read_export.js", self.path("original.mcap")))
        expect(found["compression"] == "zstd" and found["chunks"] > 2, found)
        for compression in ("lz4", "none"):
            other = json.loads(self.node("read_export.js", self.path(f"original-{compression}.mcap")))
            expect(other["topics"] == found["topics"], f"{compression} and zstd hold the same")
        topics = found["topics"]
        for topic, kind, count in (("/camera/colour/image/compressed", "sensor_msgs/msg/CompressedImage", 40),
                                   ("/camera/depth/image", "sensor_msgs/msg/Image", 40),
                                   ("/odometry", "nav_msgs/msg/Odometry", 201),
                                   ("/ground_truth", "geometry_msgs/msg/PoseStamped", 201),
                                   ("/icp_pose", "geometry_msgs/msg/PoseWithCovarianceStamped", 40),
                                   ("/tf", "tf2_msgs/msg/TFMessage", 40)):
            of = topics.get(topic, {})
            expect((of.get("type"), of.get("count")) == (kind, count), f"{topic}: {of}")
        depth = topics["/camera/depth/image"]["last"]
        expect((depth["width"], depth["height"], depth["encoding"], depth["data"]["length"])
               == (176, 144, "16UC1", 2 * 176 * 144), depth)
        info = topics["/camera/colour/camera_info"]["last"]
        expect(abs(info["k"]["first"] - 554.2562584220408) < 1e-12, info)
        pose = topics["/icp_pose"]["last"]["pose"]["pose"]["position"]
        last = np.loadtxt(self.path("original/icp.txt"))[-1]
        expect(np.allclose([pose["x"], pose["y"], pose["z"]], last[1:4], atol=1e-8), (pose, last))
        tf = topics["/tf"]["last"]["transforms"][0]
        expect((tf["header"]["frame_id"], tf["child_frame_id"]) == ("map", "base_link"), tf)
        expect(topics["/icp_keyframe"]["last"]["width"] > 100, topics["/icp_keyframe"])

    def bag(self):
        for compression in ("bz2", "lz4", "none"):
            self.run("/usr/bin/python3", os.path.join(HERE, "write_bag.py"), LOG, self.path("original/batch.lcmlog"),
                     self.path(f"{compression}.bag"), compression)
            self.import_file(f"{compression}.bag", f"{compression}.bag.lcmlog")
        self.same("bz2.bag.lcmlog", "lz4.bag.lcmlog", "none.bag.lcmlog")
        self.compare("bz2.bag.lcmlog", "bag")

    def mcap(self):
        for version, compression in (("ros2", "zstd"), ("ros1", "lz4"), ("ros1", "none")):
            name = f"{version}-{compression}.mcap"
            self.node("write_mcap.js", self.path("original.mcap"), self.path(name), version, compression)
            self.import_file(name, f"{name}.lcmlog")
        self.same("ros2-zstd.mcap.lcmlog", "ros1-lz4.mcap.lcmlog", "ros1-none.mcap.lcmlog")
        self.compare("ros2-zstd.mcap.lcmlog", "mcap")

    def import_file(self, name, log):
        said = self.run(self.program, "import", self.path(name), self.path(log), "--force")
        for line in ("40 frames", "201 odometry readings on POSE_BODY", "201 true poses", "mounted on the robot"):
            expect(line in said, f"{name}: '{line}' is not in\n{said}")
        for word in ("damaged", "left out", "looks wrong"):
            expect(word not in said, f"{name}: {said}")

    def same(self, first, *others):
        for other in others:
            expect(filecmp.cmp(self.path(first), self.path(other), shallow=False), f"{first} and {other} differ")

    def compare(self, log, out):
        """The same images and odometry map the same way: what is lost is the amplitude image and the noise of the head."""
        self.batch(self.path(log), out)
        for mapper in ("icp", "fastslam"):
            ours, theirs = (np.loadtxt(self.path(f"{folder}/{mapper}.txt")) for folder in ("original", out))
            expect(ours.shape == theirs.shape and np.allclose(ours[:, 0], theirs[:, 0]), f"{mapper}: other stamps")
            way = np.linalg.norm(np.diff(ours[:, 1:4], axis=0), axis=1).sum()
            apart = np.linalg.norm(ours[:, 1:4] - theirs[:, 1:4], axis=1).max()
            errors = [json.load(open(self.path(f"{folder}/summary.json")))["paths"][mapper]["ate"]["translation_rmse_m"]
                      for folder in ("original", out)]
            print(f"{mapper}: {way:.3f} m driven, {1000 * apart:.1f} mm apart at most, "
                  f"ATE {1000 * errors[0]:.2f} mm of the log, {1000 * errors[1]:.2f} mm of {log}")
            expect(apart < 0.01, f"{mapper}: {apart} m apart")
            expect(errors[1] < 2 * errors[0] + 0.002, f"{mapper}: ATE {errors}")


def expect(condition, what):
    if not condition:
        sys.exit(f"not so: {what}")


if __name__ == "__main__":
    getattr(Check(*sys.argv[2:]), sys.argv[1])()
