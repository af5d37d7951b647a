#!/usr/bin/python3
"""Draws a box into a recording that goes ahead of its camera, as if somebody walked before the robot.

    tests/support/box_ahead.py LOG NEW_LOG FROM TO DISTANCE WIDTH    (s since the first image, m)

What lies behind it, DISTANCE along the optical axis, gets its depth (with 4 mm of noise); its colour is grey. docs/
notebook/faults.md has what the mappers make of it. Needs numpy and PIL.
"""
import io
import pathlib
import struct
import sys
import zlib

import numpy as np
from PIL import Image

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "python"))
import lcmslam_log  # noqa: E402

COLOUR, DEPTH, DEPTH_ZIPPED, JPEG = 0, 4, 6, 1196444237
noise = np.random.default_rng(1)


def columns(camera, distance, width):
    half = camera.fx * width / 2 / distance
    return slice(int(max(0, camera.cx - half)), int(min(camera.width, camera.cx + half)))


def hide_depth(image, zipped, hidden, distance):
    data = image.data.tobytes()
    depth = np.frombuffer(zlib.decompress(data) if zipped else data, "<u2").reshape(image.height, image.width).copy()
    seen = depth[:, hidden]
    behind = (seen == 0) | (seen > 1000 * distance)
    seen[behind] = (1000 * distance + noise.normal(0, 4, seen.shape))[behind].astype("u2")
    data = depth.astype("<u2").tobytes()
    return zlib.compress(data) if zipped else data, behind.sum() / depth.size


def hide_colour(image, hidden):
    if image.pixelformat == JPEG:
        pixels = np.array(Image.open(io.BytesIO(image.data.tobytes())).convert("RGB"))
        pixels[:, hidden] = np.clip(128 + noise.normal(0, 3, pixels[:, hidden].shape), 0, 255)
        file = io.BytesIO()
        Image.fromarray(pixels).save(file, "JPEG", quality=90)
        return file.getvalue()
    pixels = image.data.reshape(image.height, image.width, image.row_stride // image.width).copy()
    pixels[:, hidden] = 128
    return pixels.tobytes()


def encoded(fingerprint, message, payloads):
    data = fingerprint + struct.pack(">qi", message.utime, message.n_images)
    data += message.image_types.astype(">i2").tobytes()
    for image, payload in zip(message.images, payloads):
        data += struct.pack(">qiiiii", image.utime, image.width, image.height, image.row_stride, image.pixelformat,
                            len(payload)) + payload + struct.pack(">i", image.nmetadata)
        for entry in image.metadata:
            key = entry.key.encode() + b"\0"
            data += struct.pack(">i", len(key)) + key + struct.pack(">i", entry.n) + entry.value.tobytes()
    return data


def with_box(log, data, calibration, distance, width):
    message = log.types.decode(data)
    payloads, share = [], 0
    for kind, image in zip(message.image_types, message.images):
        payload = image.data.tobytes()
        if kind in (DEPTH, DEPTH_ZIPPED):
            hidden = columns(calibration.depth, distance, width)
            payload, share = hide_depth(image, kind == DEPTH_ZIPPED, hidden, distance)
        elif kind == COLOUR:
            payload = hide_colour(image, columns(calibration.colour, distance, width))
        payloads.append(payload)
    return encoded(data[:8], message, payloads), share


def main(source, target, begin, end, distance, width):
    log = lcmslam_log.Log(source)
    calibration = next(log.messages("CAMERA_CALIBRATION")).value
    start, shares = None, []
    with open(target, "wb") as file:
        for number, event in enumerate(log.events):
            data = log._bytes[event.begin:event.end]
            if event.channel == "CAMERA":
                message = log.types.decode(log.data(event))
                start = message.utime if start is None else start
                if begin <= 1e-6 * (message.utime - start) <= end:
                    data, share = with_box(log, log.data(event), calibration, distance, width)
                    shares.append(share)
            channel = event.channel.encode()
            file.write(bytes.fromhex("EDA1DA01") +
                       struct.pack(">qqii", number, event.log_utime, len(channel), len(data)) + channel + data)
    print(f"{target}: a box in {len(shares)} images, {100 * np.mean(shares) if shares else 0:.0f} % of what they see")


if __name__ == "__main__":
    if len(sys.argv) != 7:
        sys.exit(__doc__)
    main(sys.argv[1], sys.argv[2], *map(float, sys.argv[3:]))
