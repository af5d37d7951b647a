"""Writes the images of a log as a folder of numbered files, as a phone or another program would leave them:

    python3 export_images.py run.lcmlog images

rgb/00000.jpg, depth/00000.png (16 bit, mm), stamps.txt (s, colour's and depth's), calibration.yaml, and lcmslam.yaml, which
says how they lie, so that `lcmslam import images again.lcmlog` reads them.
"""
import argparse
import os
import struct
import sys
import zlib

try:
    import lcmslam_log
    import numpy as np
except ImportError as error:
    sys.exit(f"{os.path.basename(sys.argv[0])}: {error}")

DESCRIPTION = """# How the images lie here; config/datasets/ explains every key.
format: numbered
colour: rgb/%05d.jpg
depth: depth/%05d.png
depth_scale: 1000         # value of a depth pixel at 1 m
stamps: stamps.txt        # s, of colour and of depth
calibration: calibration.yaml
"""


def png(depth):
    """(H, W) uint16 as the bytes of a PNG file."""
    height, width = depth.shape
    rows = np.zeros((height, 1 + 2 * width), np.uint8)  # a row begins with its filter: 0, none
    rows[:, 1:] = depth.astype(">u2").view(np.uint8).reshape(height, 2 * width)

    def chunk(name, data):
        return struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))

    return (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 16, 0, 0, 0, 0))
            + chunk(b"IDAT", zlib.compress(rows.tobytes(), 1)) + chunk(b"IEND", b""))


def numbers(values):
    return "[" + ", ".join(repr(float(value)) for value in values) + "]"


def camera(name, c):
    return (f"{name}: {{width: {c.width}, height: {c.height}, fx: {c.K[0, 0]}, fy: {c.K[1, 1]}, cx: {c.K[0, 2]}, "
            f"cy: {c.K[1, 2]}, distortion: {numbers(c.distortion)}}}\n")


def calibration_text(calibration):
    """As config/calibration/*.yaml, without the mount on a robot."""
    m = calibration.message
    text = f"sensor: {calibration.sensor}\n" + camera("colour", calibration.colour)
    text += f"depth_registered: {str(m.depth_registered).lower()}\n"
    if not m.depth_registered:
        text += camera("depth", calibration.depth)
        text += (f"colour_depth: {{translation: {numbers(m.T_colour_depth.trans)}, "
                 f"quaternion: {numbers(m.T_colour_depth.quat)}}}\n")
    names = ("offset", "scale", "wiggle", "period", "phase", "tilt_x", "tilt_y")
    error = zip(names, calibration.depth_error + calibration.depth_tilt)
    text += "depth_error: {" + ", ".join(f"{name}: {value!r}" for name, value in error) + "}\n"
    if m.depth_clock_offset != 0:
        text += f"depth_clock_offset: {m.depth_clock_offset!r}\n"
    return text + (f"rolling_shutter: {calibration.rolling_shutter}\n"
                   f"depth_noise: {{constant: {m.depth_noise_constant}, quadratic: {m.depth_noise_quadratic}, "
                   f"offset: {m.depth_noise_offset}, amplitude: {m.depth_noise_amplitude}}}\n"
                   f"depth_min: {m.depth_min}\ndepth_max: {m.depth_max}\npixel_sigma: {m.pixel_sigma}\n")


def export(log, folder):
    """How many frames."""
    text = calibration_text(log.calibration())
    for name in ("rgb", "depth"):
        os.makedirs(os.path.join(folder, name))
    stamps = []
    for frame in log.images():
        if frame.jpeg is None or frame.depth is None:
            raise lcmslam_log.LogError(f"{log.path}: frame {len(stamps)} has no JPEG or no depth image")
        for name, data in ((f"rgb/{len(stamps):05d}.jpg", frame.jpeg), (f"depth/{len(stamps):05d}.png", png(frame.depth))):
            with open(os.path.join(folder, name), "wb") as file:
                file.write(data)
        stamps.append(f"{frame.utime / 1e6:.6f} {frame.depth_utime / 1e6:.6f}\n")
    for name, content in (("stamps.txt", "".join(stamps)), ("calibration.yaml", text), ("lcmslam.yaml", DESCRIPTION)):
        with open(os.path.join(folder, name), "w") as file:
            file.write(content)
    return len(stamps)


def main():
    parser = argparse.ArgumentParser(description="Writes the images of a log as a folder of numbered files.")
    parser.add_argument("log", help="an .lcmlog file with CAMERA and CAMERA_CALIBRATION")
    parser.add_argument("folder", help="to be made")
    arguments = parser.parse_args()
    if os.path.exists(arguments.folder):
        return f"{arguments.folder}: is there already; name a folder that is not"
    try:
        print(f"{arguments.folder}: {export(lcmslam_log.Log(arguments.log), arguments.folder)} frames")
    except lcmslam_log.LogError as error:
        return str(error)
    except OSError as error:
        return f"{error.filename or arguments.folder}: cannot be written: {error.strerror}"
    return 0


if __name__ == "__main__":
    sys.exit(main())
