"""JPEG as numpy, by PIL or cv2, whichever is installed (PIL, if both are)."""
import io

import numpy as np

from lcmslam_types import DecodeError

try:
    import PIL.Image
except ImportError:
    PIL = None
try:
    import cv2
except ImportError:
    cv2 = None

MISSING = ("frame.colour: JPEG needs PIL or cv2, and neither is installed: apt-get install python3-pil (or python3-opencv); "
           "frame.jpeg has the bytes")


def decode(data, width, height):
    """RGB, uint8 (height, width, 3); None without a decoder. What is no whole JPEG of that size raises DecodeError."""
    if PIL is None and cv2 is None:
        return None
    if b"\xff\xd9" not in data:  # cv2 fills up with grey
        raise DecodeError("the JPEG does not decode: it has no end (bytes FF D9)")
    pixels = _with_pil(data, (width, height)) if PIL is not None else _with_cv2(data)
    if pixels.shape != (height, width, 3):
        raise DecodeError(f"the JPEG is {pixels.shape[1]}x{pixels.shape[0]} pixels, declared are {width}x{height}")
    return pixels


def _with_pil(data, size):
    try:
        picture = PIL.Image.open(io.BytesIO(data), formats=["JPEG"])
        if picture.size != size:  # before memory is taken
            raise DecodeError(f"the JPEG is {picture.width}x{picture.height} pixels, declared are {size[0]}x{size[1]}")
        return np.array(picture.convert("RGB"))
    except (OSError, ValueError, SyntaxError, PIL.Image.DecompressionBombError) as error:
        raise DecodeError(f"the JPEG does not decode: {error}") from None


def _with_cv2(data):
    try:
        bgr = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_COLOR)
    except cv2.error as error:
        raise DecodeError(f"the JPEG does not decode: {error}") from None
    if bgr is None:
        raise DecodeError("the JPEG does not decode")
    return bgr[:, :, ::-1].copy()
