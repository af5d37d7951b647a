"""JPEG images, the examples of python/ and the lines of docs/PYTHON.md."""
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest
import zlib

import numpy as np

from reference import DECODERS, DRIVE, PYTHON, SAMPLES
import lcmslam_jpeg
import lcmslam_log
import lcmslam_types


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
            stamps = pathlib.Path(folder, "stamps.txt").read_text().split("\n")
            self.assertEqual(stamps[0], f"{frame.utime / 1e6:.6f} {frame.depth_utime / 1e6:.6f}")
            self.assertNotEqual(frame.utime, frame.depth_utime)
            again = subprocess.run(command, capture_output=True, text=True)
            self.assertEqual((again.returncode, again.stderr), (1, f"{folder}: is there already; name a folder that is not\n"))

    def test_names_what_is_wrong(self):
        done, svg = self.run_plot(DRIVE, "--channel", "ICP_POSE")
        self.assertEqual((done.returncode, svg), (1, ""))
        self.assertIn("has no channel ICP_POSE", done.stderr)


class WithoutNumpy(unittest.TestCase):
    def test_the_examples_say_in_one_line_which_python_lacks_it(self):
        for name in ("export_images.py", "plot_trajectory.py"):
            hidden = (f"import runpy, sys; sys.modules['numpy'] = None; sys.path.insert(0, {PYTHON!r}); "
                      f"sys.argv = [{name!r}]; runpy.run_path({os.path.join(PYTHON, name)!r}, run_name='__main__')")
            done = subprocess.run([sys.executable, "-c", hidden], capture_output=True, text=True)
            self.assertEqual(done.returncode, 1)
            self.assertEqual(len(done.stderr.splitlines()), 1, done.stderr)
            self.assertIn(f"{name}: {sys.executable} has no numpy", done.stderr)


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
