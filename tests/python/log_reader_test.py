"""python/ reads what the C++ libraries read (write_reference.cpp): log_reader_test.py REFERENCE.json PYTHON_FOLDER."""
import json
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest
import zlib

import numpy as np

REFERENCE, PYTHON = pathlib.Path(sys.argv[1]), sys.argv[2]
sys.path.insert(0, PYTHON)
import lcmslam_jpeg  # noqa: E402
import lcmslam_log  # noqa: E402
import lcmslam_messages  # noqa: E402
import lcmslam_types  # noqa: E402

EXPECTED = json.loads(REFERENCE.read_text())
SAMPLES = str(REFERENCE.parent / "samples.lcmlog")
DRIVE = next(name for name in EXPECTED if name.endswith("kitchen_drive.lcmlog"))
DECODERS = [name for name in ("PIL", "cv2") if getattr(lcmslam_jpeg, name) is not None]
DAMAGED = sorted(name for name in EXPECTED if name not in (SAMPLES, DRIVE))


def checksum(values):
    values = np.asarray(values, dtype=np.int64).ravel()
    return int((values * (1 + np.arange(len(values)) % 65521)).sum())


class SameAsCpp(unittest.TestCase):
    def assert_close(self, a, b, tolerance=1e-12):
        self.assertEqual(np.shape(a), np.shape(b))
        np.testing.assert_allclose(np.asarray(a, float), np.asarray(b, float), rtol=tolerance, atol=tolerance)

    def each_log(self, channel):
        found = 0
        for name in (SAMPLES, DRIVE):
            expected = EXPECTED[name]["channels"].get(channel)
            if expected:
                found += 1
                yield lcmslam_log.Log(name), expected
        self.assertGreater(found, 0, channel)

    def test_counts(self):
        for name in (SAMPLES, DRIVE):
            log = lcmslam_log.Log(name)
            counts = {}
            for message in log.messages():
                counts[message.channel] = counts.get(message.channel, 0) + 1
            for channel, n in log.unknown_types.items():
                counts[channel] = counts.get(channel, 0) + n
            self.assertEqual(counts, EXPECTED[name]["counts"])
            self.assertEqual(log.damages, [])
            self.assertEqual(log.incomplete, EXPECTED[name]["incomplete"])
        self.assertEqual(lcmslam_log.Log(SAMPLES).channels["CAMERA"], 4)  # the two in pieces are not among them

    def test_images(self):
        for log, expected in self.each_log("CAMERA"):
            frames = list(log.images())
            self.assertEqual(len(frames), len(expected))
            for frame, e in zip(frames, expected):
                self.assertEqual((frame.utime, frame.depth_utime, frame.seq, frame.sensor),
                                 (e["utime"], e["depth_utime"], e["seq"], e["sensor"]))
                self.assertEqual(frame.depth.dtype, np.uint16)
                self.assertEqual(checksum(frame.depth), e["depth"])
                self.assertEqual(frame.amplitude is None, "amplitude" not in e)
                if frame.amplitude is not None:
                    self.assertEqual(checksum(frame.amplitude), e["amplitude"])
                self.assertEqual(frame.jpeg is None, "jpeg" not in e)
                if frame.jpeg is not None:
                    self.assertEqual(checksum(np.frombuffer(frame.jpeg, np.uint8)), e["jpeg"])
                else:
                    self.assertEqual(checksum(frame.colour), e["colour"])
                if frame.jpeg is None or DECODERS:
                    self.assertEqual(frame.colour.shape, (e["height"], e["width"], 3))

    def test_poses(self):
        for channel in ("GROUND_TRUTH", "ICP_POSE", "ODOMETRY", "POSE_BODY"):
            for log, expected in self.each_log(channel):
                poses = log.poses(channel)
                self.assertEqual(poses.utime.tolist(), [e["utime"] for e in expected])
                self.assert_close(poses.T.reshape(-1, 16), [e["T"] for e in expected])
                if channel == "ICP_POSE":
                    self.assert_close(poses.covariance.reshape(-1, 36), [e["covariance"] for e in expected])
                    self.assertEqual((poses.frame, poses.child_frame), ("map", "robot"))
                    self.assertEqual(set(poses.status), {1})

    def test_features(self):
        for log, expected in self.each_log("FEATURES"):
            for frame, e in zip(log.features(), expected):
                self.assertEqual((frame.utime, frame.n_features, frame.fx), (e["utime"], e["n"], e["fx"]))
                rows = [[f["x"], f["y"], f["angle"], *f["point"], f["depth_sigma"], f["landmark_id"],
                         checksum(f["descriptor"])] for f in frame.features]
                self.assert_close(rows, e["features"], 1e-6)
                self.assertEqual(lcmslam_log.descriptors(frame.features).shape, (e["n"], 64))

    def test_wheels(self):
        for log, expected in self.each_log("ENCODERS"):
            wheels = [[[w[name] for name in ("x", "y", "radius", "angle", "steering")] for w in message.value.wheels]
                      for message in log.messages("ENCODERS")]
            self.assert_close(wheels, expected)

    def test_calibration(self):
        for log, expected in self.each_log("CAMERA_CALIBRATION"):
            c, e = log.calibration(), expected[0]
            self.assertEqual((c.sensor, c.rolling_shutter, c.has_mount), (e["sensor"], e["rolling_shutter"], e["has_mount"]))
            for camera, ec in ((c.colour, e["colour"]), (c.depth, e["depth"])):
                self.assertEqual((camera.width, camera.height), (ec["width"], ec["height"]))
                self.assert_close(camera.K, [[ec["fx"], 0, ec["cx"]], [0, ec["fy"], ec["cy"]], [0, 0, 1]])
                self.assert_close(camera.distortion, ec["distortion"])
            self.assert_close(c.T_colour_depth.ravel(), e["T_colour_depth"])
            self.assert_close(c.T_robot_camera.ravel(), e["T_robot_camera"])
            self.assertEqual(c.message.depth_max, e["depth_max"])

    def test_cloud(self):
        log = lcmslam_log.Log(SAMPLES)
        self.assertEqual([k.id for k in log.keyframes()], [0, 1, 3])
        points, colours = log.cloud()
        self.assert_close(points, EXPECTED[SAMPLES]["cloud"], 1e-5)
        self.assertEqual(colours.shape, points.shape)
        keyframe = log.keyframes()[0]
        self.assertEqual(keyframe.colours[1].tolist(), [7, 0, 1])  # samples.hpp writes blue 1, green 0, red 7
        self.assertTrue(np.isnan(keyframe.normals[0]).all())
        self.assert_close(np.linalg.norm(keyframe.normals[1]), 1, 1e-6)

    def test_damaged_logs_give_the_same_messages(self):
        self.assertGreaterEqual(len(DAMAGED), 7)
        for name in DAMAGED:
            with self.subTest(name):
                log = lcmslam_log.Log(name)
                counts = {}
                for message in log.messages():
                    counts[message.channel] = counts.get(message.channel, 0) + 1
                self.assertEqual(counts, EXPECTED[name]["counts"])
                self.assertEqual(len(log.damages), EXPECTED[name]["damages"])
                self.assertEqual(log.damages[0].file, name)
                self.assertGreater(log.damages[0].offset, 0)
                self.assertTrue(log.damages[0].reason)
                list(log.messages())
                self.assertEqual(len(log.damages), EXPECTED[name]["damages"], "each is listed once")


class Damaged(unittest.TestCase):
    """What C++ logs cannot be told apart by: which events are left."""

    def setUp(self):
        self.bytes = pathlib.Path(SAMPLES).read_bytes()
        self.events = lcmslam_log.Log(SAMPLES).events

    def read(self, damaged):
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "damaged.lcmlog")
            pathlib.Path(path).write_bytes(damaged)
            return lcmslam_log.Log(path)

    def with_size(self, index, size):
        at = self.events[index].offset + 24
        return self.bytes[:at] + size.to_bytes(4, "big") + self.bytes[at + 4:]

    def assert_lost(self, log, *indices):
        kept = [event.number for i, event in enumerate(self.events) if i not in indices]
        self.assertEqual([event.number for event in log.events], kept)

    def test_an_event_that_claims_the_next_one_too(self):
        for channel in ("ODOMETRY", "STRANGE"):
            i = next(i for i, event in enumerate(self.events) if event.channel == channel)
            log = self.read(self.with_size(i, self.events[i + 1].end - self.events[i].begin))
            if channel == "ODOMETRY":  # of a type that is not known nothing tells, but the numbers are no chain
                self.assert_lost(log, i)
            log = self.read(self.with_size(i, self.events[i + 1].end - self.events[i].begin - 3))
            self.assert_lost(log, i)
            self.assertEqual(len(log.damages), 1)
            self.assertEqual((log.damages[0].offset, log.damages[0].end), (self.events[i].offset, self.events[i].end))

    def test_an_event_before_damage_is_kept(self):
        i = next(i for i, event in enumerate(self.events) if event.channel == "STRANGE")
        at = self.events[i + 1].offset
        self.assert_lost(self.read(self.bytes[:at] + b"XX" + self.bytes[at + 2:]), i + 1)

    def test_one_stretch_is_one_damage(self):
        a, b = self.events[30].offset, self.events[34].offset
        zeros = bytearray(b - a)
        zeros[50:54] = zeros[90:94] = bytes.fromhex("EDA1DA01")
        log = self.read(self.bytes[:a] + bytes(zeros) + self.bytes[b:])
        self.assert_lost(log, 30, 31, 32, 33)
        self.assertEqual([(d.offset, d.end) for d in log.damages], [(a, b)])

    def test_a_message_that_does_not_decode_is_listed_once(self):
        event = next(event for event in self.events if event.channel == "FEATURES")
        at = event.begin + 8 + 4 * 8  # the length of the sensor's name
        log = self.read(self.bytes[:at] + bytes(4) + self.bytes[at + 4:])
        for _ in range(2):
            self.assertEqual(len(list(log.features())), 2)
            self.assertEqual([(d.offset, d.reason) for d in log.damages],
                             [(event.offset, "FEATURES: sensor: text of length 0 does not fit")])


class Errors(unittest.TestCase):
    def expect(self, words, call):
        with self.assertRaises((lcmslam_log.LogError, ValueError)) as caught:
            call()
        for word in words:
            self.assertIn(word, str(caught.exception))

    def test_files_that_are_no_logs(self):
        with tempfile.TemporaryDirectory() as folder:
            empty, text = os.path.join(folder, "empty.lcmlog"), os.path.join(folder, "notes.txt")
            open(empty, "w").close()
            with open(text, "w") as file:
                file.write("x" * 100)
            self.expect([folder, "is a folder"], lambda: lcmslam_log.Log(folder))
            self.expect([empty, "is empty"], lambda: lcmslam_log.Log(empty))
            self.expect([text, "is no LCM log"], lambda: lcmslam_log.Log(text))
            self.expect(["/nowhere/x.lcmlog", "cannot be opened"], lambda: lcmslam_log.Log("/nowhere/x.lcmlog"))
            self.expect([text, "expected 'struct'"], lambda: lcmslam_log.Log(DRIVE, definitions=[text]))

    def test_channels_that_are_not_there(self):
        log = lcmslam_log.Log(DRIVE)
        self.expect([DRIVE, "has no channel CAMRA", "CAMERA, CAMERA_CALIBRATION"], lambda: log.images("CAMRA"))
        self.expect([DRIVE, "has no channel ICP_POSE"], lambda: log.poses("ICP_POSE"))
        self.expect([DRIVE, "ENCODERS carries no poses"], lambda: log.poses("ENCODERS"))
        self.assertIn("is a encoders_t, not a pose_estimate_t", log.damages[0].reason)

    def test_messages_that_lie(self):
        types = lcmslam_types.Types()
        log = lcmslam_log.Log(SAMPLES)
        for name in ("images_t", "features_t", "keyframe_t", "part_t"):
            event = next(e for e in log.events if (t := types.of(log.data(e))) and t.name == name)
            whole = log.data(event)
            types.decode(whole)
            for size in range(0, len(whole), max(1, len(whole) // 97)):
                with self.assertRaises(lcmslam_types.DecodeError):
                    types.decode(whole[:size])
            with self.assertRaises(lcmslam_types.DecodeError):
                types.decode(whole + b"\0")
            for at in range(8, min(len(whole), 200)):  # any byte, also of a length: an answer or DecodeError
                broken = bytearray(whole)
                broken[at] ^= 0xFF
                try:
                    types.decode(bytes(broken))
                except lcmslam_types.DecodeError:
                    pass

    def test_an_image_that_unzips_to_more_than_its_size(self):
        event = lcmslam_log.Log(SAMPLES)
        message = next(event.messages("CAMERA")).value
        message.images[1].height //= 2
        with self.assertRaisesRegex(lcmslam_types.DecodeError, "bytes, .* are needed"):
            lcmslam_messages.frame(message)


# 32x16 pixels: red on the left, blue on the right
TWO_COLOURS = bytes.fromhex(
    "ffd8ffe000104a46494600010100000100010000ffdb0043000302020302020303030304030304050805050404050a070706"
    "080c0a0c0c0b0a0b0b0d0e12100d0e110e0b0b1016101113141515150c0f171816141812141514ffdb004301030404050405"
    "09050509140d0b0d141414141414141414141414141414141414141414141414141414141414141414141414141414141414"
    "1414141414141414ffc00011080010002003012200021101031101ffc4001600010101000000000000000000000000000007"
    "08ffc40014100100000000000000000000000000000000ffc4001501010100000000000000000000000000000907ffc40014"
    "110100000000000000000000000000000000ffda000c03010002110311003f00ce8021854d0200e30747ffd9")


class Jpeg(unittest.TestCase):
    def by_each_decoder(self):
        if not DECODERS:
            self.skipTest("no JPEG decoder here: apt-get install python3-pil (or python3-opencv)")
        installed = {name: getattr(lcmslam_jpeg, name) for name in DECODERS}
        for only in DECODERS:
            for name in DECODERS:
                setattr(lcmslam_jpeg, name, installed[name] if name == only else None)
            with self.subTest(decoder=only):
                yield
        for name in DECODERS:
            setattr(lcmslam_jpeg, name, installed[name])

    def test_colours_are_rgb(self):
        for _ in self.by_each_decoder():
            pixels = lcmslam_jpeg.decode(TWO_COLOURS, 32, 16)
            self.assertEqual((pixels.shape, pixels.dtype), ((16, 32, 3), np.uint8))
            np.testing.assert_allclose(pixels[8, 4], (255, 0, 0), atol=8)
            np.testing.assert_allclose(pixels[8, 28], (0, 0, 255), atol=8)

    def test_what_is_no_whole_jpeg_of_its_size(self):
        huge = bytearray(TWO_COLOURS)
        at = huge.index(b"\xff\xc0")
        huge[at + 5:at + 9] = b"\xff\xff\xff\xff"
        for _ in self.by_each_decoder():
            for data in (TWO_COLOURS[:-40], b"", b"\xff\xd9" * 9, bytes(huge)):
                with self.assertRaises(lcmslam_types.DecodeError):
                    lcmslam_jpeg.decode(data, 32, 16)
            with self.assertRaisesRegex(lcmslam_types.DecodeError, "is 32x16 pixels, declared are 16x32"):
                lcmslam_jpeg.decode(TWO_COLOURS, 16, 32)
            lcmslam_jpeg.decode(TWO_COLOURS + bytes(100), 32, 16)  # some cameras pad their frames

    def test_without_a_decoder_says_what_to_install(self):
        code = ("import sys; sys.modules.update({'PIL': None, 'cv2': None}); sys.path.insert(0, sys.argv[1])\n"
                "import lcmslam_log\nframe = next(lcmslam_log.Log(sys.argv[2]).images())\n"
                "print(frame.depth.shape, frame.jpeg[:2])\nframe.colour")
        done = subprocess.run([sys.executable, "-c", code, PYTHON, DRIVE], capture_output=True, text=True)
        self.assertRegex(done.stdout, r"\(\d+, \d+\) b'\\xff\\xd8'")
        self.assertEqual(done.returncode, 1)
        self.assertIn("ImportError: frame.colour: JPEG needs PIL or cv2", done.stderr)
        self.assertIn("apt-get install python3-pil", done.stderr)


class Example(unittest.TestCase):
    def run_plot(self, *arguments):
        with tempfile.TemporaryDirectory() as folder:
            out = os.path.join(folder, "path.svg")
            done = subprocess.run([sys.executable, os.path.join(PYTHON, "plot_trajectory.py"), *arguments, "--out", out],
                                  capture_output=True, text=True)
            return done, pathlib.Path(out).read_text() if os.path.exists(out) else ""

    def test_plots_every_channel_of_poses(self):
        done, svg = self.run_plot(DRIVE)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertRegex(done.stdout, r"GROUND_TRUTH: \d+ poses, 10\.\d+ m")  # logs/README.md: 10.8 m
        self.assertIn("<polyline points=", svg)
        self.assertIn("GROUND_TRUTH", svg)
        done, svg = self.run_plot(SAMPLES, "--channel", "ICP_POSE", "ODOMETRY")
        self.assertEqual((done.returncode, svg.count("<polyline")), (0, 2), done.stderr)

    def test_exports_images_as_files(self):
        with tempfile.TemporaryDirectory() as parent:
            folder = os.path.join(parent, "images")
            command = [sys.executable, os.path.join(PYTHON, "export_images.py"), DRIVE, folder]
            done = subprocess.run(command, capture_output=True, text=True)
            self.assertEqual(done.returncode, 0, done.stderr)
            frame = next(lcmslam_log.Log(DRIVE).images())
            png = pathlib.Path(folder, "depth/00000.png").read_bytes()
            self.assertEqual(png[:8], b"\x89PNG\r\n\x1a\n")
            begin = png.index(b"IDAT")
            size = int.from_bytes(png[begin - 4:begin], "big")
            rows = np.frombuffer(zlib.decompress(png[begin + 4:begin + 4 + size]), np.uint8)
            rows = rows.reshape(frame.depth.shape[0], -1)[:, 1:]
            np.testing.assert_array_equal(rows.copy().view(">u2"), frame.depth)
            self.assertEqual(pathlib.Path(folder, "rgb/00000.jpg").read_bytes(), frame.jpeg)
            self.assertEqual(pathlib.Path(folder, "stamps.txt").read_text().split()[0], f"{frame.utime / 1e6:.6f}")
            again = subprocess.run(command, capture_output=True, text=True)
            self.assertEqual((again.returncode, again.stderr), (1, f"{folder}: is there already; name a folder that is not\n"))

    def test_names_what_is_wrong(self):
        done, svg = self.run_plot(DRIVE, "--channel", "ICP_POSE")
        self.assertEqual((done.returncode, svg), (1, ""))
        self.assertIn("has no channel ICP_POSE", done.stderr)


class Page(unittest.TestCase):
    def test_its_lines_run_as_they_stand_there(self):
        source = pathlib.Path(__file__).resolve().parent.parent.parent
        code = (source / "docs/PYTHON.md").read_text().split("```python\n")[1].split("```")[0]
        done = subprocess.run([sys.executable, "-c", code], cwd=source, capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stderr)
        channels, damages = done.stdout.splitlines()
        self.assertIn("'CAMERA': 78", channels)
        self.assertEqual(damages, "[]")


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
