"""python/ reads what the C++ libraries read (reference.py)."""
import os
import pathlib
import sys
import tempfile
import unittest

import numpy as np

from reference import DAMAGED, DECODERS, DRIVE, EXPECTED, SAMPLES
import lcmslam_log
import lcmslam_messages
import lcmslam_types


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
            self.assertEqual((list(c.depth_error), list(c.depth_tilt)), (e["depth_error"], e["depth_tilt"]))
            for camera, ec in ((c.colour, e["colour"]), (c.depth, e["depth"])):
                self.assertEqual((camera.width, camera.height), (ec["width"], ec["height"]))
                self.assert_close(camera.K, [[ec["fx"], 0, ec["cx"]], [0, ec["fy"], ec["cy"]], [0, 0, 1]])
                self.assert_close(camera.distortion, ec["distortion"])
            self.assert_close(c.T_colour_depth.ravel(), e["T_colour_depth"])
            self.assert_close(c.T_robot_camera.ravel(), e["T_robot_camera"])
            self.assertEqual(c.message.depth_max, e["depth_max"])

    def test_cloud(self):
        log = lcmslam_log.Log(SAMPLES)
        self.assertEqual([k.id for k in log.keyframes()], [1, 3, 5])
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


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
