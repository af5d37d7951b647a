"""What messages of lcmslam mean: images, poses, calibrations and keyframes of decoded messages (lcmslam_types), as
numpy. What makes no sense raises DecodeError."""
import collections
import zlib

import numpy as np

import lcmslam_jpeg
from lcmslam_types import DecodeError

Pose = collections.namedtuple("Pose", "utime T covariance status frame child_frame")
Camera = collections.namedtuple("Camera", "width height K distortion")
Calibration = collections.namedtuple("Calibration", "sensor rolling_shutter colour depth T_colour_depth has_mount "
                                                    "T_robot_camera message depth_error depth_tilt")
Tile = collections.namedtuple("Tile", "sender id utime revision tile n_tiles T_map_camera points colours normals")
Graph = collections.namedtuple("Graph", "sender seq is_whole T_map_camera gone")
Keyframe = collections.namedtuple("Keyframe", "id utime T_map_camera points colours normals")

_LARGEST_SIDE = 8192       # pixels
_LARGEST_COORDINATE = 1e6  # m
_LEFT, _DEPTH_MM, _DEPTH_MM_ZIPPED, _AMPLITUDE_ZIPPED = 0, 4, 6, 100
_GRAY, _RGB, _BGR, _MJPEG, _BIG_ENDIAN_DEPTH = 1497715271, 859981650, 861030210, 1196444237, 357


class Frame(collections.namedtuple("Frame", "utime depth_utime seq sensor pixels jpeg depth amplitude")):
    """`depth` in mm, 0 = invalid; what is not there is None."""
    __slots__ = ()

    @property
    def colour(self):
        """RGB, uint8 (H, W, 3). ImportError for JPEG where nothing that decodes it is installed."""
        if self.pixels is None and self.jpeg is not None:
            raise ImportError(lcmslam_jpeg.MISSING)
        return self.pixels


def frame(message):
    """Of images_t."""
    images = dict(zip(message.image_types.tolist(), message.images))
    left, depth, amplitude = images.get(_LEFT), images.get(_DEPTH_MM_ZIPPED, images.get(_DEPTH_MM)), None
    colour, jpeg = (None, None) if left is None else _colour(left)
    depth_utime = message.utime if depth is None else depth.utime or message.utime
    if depth is not None:
        if depth.pixelformat == _BIG_ENDIAN_DEPTH:
            raise DecodeError("depth image: big-endian pixels are not supported")
        depth = _pixels(depth, "<u2", _DEPTH_MM_ZIPPED in images).astype(np.uint16)
    if _AMPLITUDE_ZIPPED in images:
        amplitude = _pixels(images[_AMPLITUDE_ZIPPED], "u1", True)
    metadata = {m.key: m.value.tobytes() for m in (message.images[0].metadata if message.images else [])}
    seq = int.from_bytes(metadata["seq"], "little", signed=True) if len(metadata.get("seq", b"")) == 8 else -1
    sensor = metadata.get("sensor", b"").decode(errors="replace")
    return Frame(message.utime, depth_utime, seq, sensor, colour, jpeg, depth, amplitude)


def _colour(image):
    """RGB pixels, or None, and the bytes of a JPEG, or None."""
    if image.pixelformat == _MJPEG:
        data = image.data.tobytes()
        return lcmslam_jpeg.decode(data, image.width, image.height), data
    if image.pixelformat == _GRAY:
        return np.repeat(_pixels(image, "u1", False)[:, :, None], 3, axis=2), None
    if image.pixelformat in (_RGB, _BGR):
        pixels = _pixels(image, "u1", False, channels=3)
        return (pixels if image.pixelformat == _RGB else pixels[:, :, ::-1].copy()), None
    raise DecodeError(f"pixelformat {image.pixelformat} is not supported")


def _pixels(image, dtype, zipped, channels=None):
    if not (1 <= image.width <= _LARGEST_SIDE and 1 <= image.height <= _LARGEST_SIDE):
        raise DecodeError(f"image size {image.width}x{image.height}: must be 1 to {_LARGEST_SIDE} a side")
    size = image.width * image.height * np.dtype(dtype).itemsize * (channels or 1)
    data = image.data.tobytes()
    if zipped:
        try:
            data = zlib.decompressobj().decompress(data, size + 1)
        except zlib.error as error:
            raise DecodeError(f"zlib image: {error}") from None
    if len(data) != size:
        raise DecodeError(f"image {image.width}x{image.height}: {len(data)} bytes, {size} are needed")
    shape = (image.height, image.width) + ((channels,) if channels else ())
    return np.frombuffer(data, dtype).reshape(shape)


def pose(message):
    """Of pose_estimate_t, odometry_t, ground_truth_t or pose_t; what a type has not is NaN, -1 or ''."""
    for name in ("T_map_robot", "T_odom_robot", "T_frame_child"):
        if hasattr(message, name):
            T = transform(getattr(message, name), name)
            break
    else:
        T = _rigid(message.pos, message.orientation, "pose_t")
    covariance = np.array(getattr(message, "covariance", np.full(36, np.nan))).reshape(6, 6)
    covariance = 0.5 * (covariance + covariance.T)
    return Pose(message.utime, T, covariance, getattr(message, "status", -1), getattr(message, "frame", ""),
                getattr(message, "child_frame", ""))


def calibration(message):
    """Of camera_calibration_t; K (3, 3) is the pinhole's matrix. What depth images err by, which they carry as it was
    measured: `depth_error` offset (m), scale, wiggle (m), period (m), phase (rad); `depth_tilt` (1/m)."""
    sensor, (rolling_shutter,) = _numbers_behind(message.sensor, "rolling_shutter", (0.0,))
    sensor, depth_error = _numbers_behind(sensor, "depth_error", (0.0, 0.0, 0.0, 1.0, 0.0))
    sensor, depth_tilt = _numbers_behind(sensor, "depth_tilt", (0.0, 0.0))
    return Calibration(sensor, rolling_shutter, _camera(message.colour), _camera(message.depth),
                       transform(message.T_colour_depth, "T_colour_depth"), message.has_mount,
                       transform(message.T_robot_camera, "T_robot_camera"), message, depth_error, depth_tilt)


def _numbers_behind(text, key, default):
    """What the sensor's name carries besides (docs/LCM.md, "Types"): the text before ";KEY=", and the numbers behind."""
    before, there, behind = text.partition(f";{key}=")
    try:
        numbers = tuple(map(float, behind.split(","))) if there else default
    except ValueError:
        numbers = ()
    if len(numbers) != len(default):
        raise DecodeError(f"sensor '{text}': {key} must be {len(default)} number{'s' * (len(default) > 1)}")
    return before, numbers


def _camera(m):
    K = np.array([[m.fx, 0, m.cx], [0, m.fy, m.cy], [0, 0, 1]])
    if not (m.width > 0 and m.height > 0 and m.fx > 0 and m.fy > 0 and np.isfinite(K).all()):
        raise DecodeError(f"{m.width}x{m.height} pixels with focal lengths {m.fx}, {m.fy} are no camera")
    return Camera(m.width, m.height, K, m.distortion)


def tile_or_graph(message):
    """Of keyframe_t a Tile, of graph_t a Graph: node -> corrected T_map_camera, of a change those that it names."""
    if hasattr(message, "nodes"):
        nodes = message.nodes
        poses = {int(node): transform(T, "T_map_camera") for node, T in zip(nodes["keyframe"], nodes["T_map_camera"])}
        return Graph(message.sender, message.seq, message.change == 0, poses, message.gone.tolist())
    m = message
    if not 0 <= m.tile < m.n_tiles:
        raise DecodeError(f"tile {m.tile} of {m.n_tiles} cannot be")
    if not 1e-6 <= m.resolution <= 1 or m.n_values % 3:
        raise DecodeError(f"{m.n_values} values of {m.resolution} m cannot be points")
    normals = m.normal.reshape(-1, 3).astype(np.float32)
    length = np.linalg.norm(normals, axis=1, keepdims=True)
    normals = np.divide(normals, length, out=np.full_like(normals, np.nan), where=length > 0)
    points = np.float32(m.resolution) * m.position.reshape(-1, 3).astype(np.float32)
    return Tile(m.sender, m.id, m.utime, m.map_revision, m.tile, m.n_tiles, transform(m.T_map_camera, "T_map_camera"),
                points, m.colour.reshape(-1, 3), normals)


class FollowedGraph:
    """A mapper's graph, put together from what its messages tell of it (libs/messages/followed_graph.hpp)."""

    def __init__(self):
        self.T_map_camera, self.is_complete, self._seq = {}, True, None

    def apply(self, graph):
        """Takes over a Graph; a change that is older than what was heard is left out."""
        heard = self._seq is not None
        if heard and not graph.is_whole and graph.seq <= self._seq:
            return
        self.is_complete = graph.is_whole or (heard and self.is_complete and graph.seq == self._seq + 1)
        self._seq = graph.seq
        before = {} if graph.is_whole else {i: T for i, T in self.T_map_camera.items() if i not in graph.gone}
        self.T_map_camera = {**before, **graph.T_map_camera}

    def follow(self, keyframes, graph):
        """Keyframes by their ids where the graph has them after this message; whom it has not has been given up. While
        messages are missing only those go that are named as gone."""
        stays = {i: k for i, k in keyframes.items()
                 if i in self.T_map_camera or not (self.is_complete or i in graph.gone)}
        return {i: k._replace(T_map_camera=self.T_map_camera.get(i, k.T_map_camera)) for i, k in stays.items()}


def keyframe(tiles):
    """Of all its tiles, by their numbers."""
    ordered = [tiles[i] for i in sorted(tiles)]
    joined = [np.concatenate([getattr(tile, name) for tile in ordered]) for name in ("points", "colours", "normals")]
    last = list(tiles.values())[-1]  # as it came: the newest pose
    return Keyframe(last.id, last.utime, last.T_map_camera, *joined)


def descriptors(features):
    """SURF descriptors (N, 64) of a structured array of feature_t or landmark_t: about unit length."""
    return (features["descriptor"].astype(np.float32) - 128) / 127


def transform(message, field="transform"):
    """rigid_transform_t as (4, 4); also an element of a structured array of them."""
    if isinstance(message, np.void):
        return _rigid(message["trans"], message["quat"], field)
    return _rigid(message.trans, message.quat, field)


def _rigid(t, q, field):
    if not abs(q @ q - 1) < 1e-3:
        raise DecodeError(f"{field}: quaternion is not of unit length")
    if not np.all(np.abs(t) <= _LARGEST_COORDINATE):
        raise DecodeError(f"{field}: {t} is out of {_LARGEST_COORDINATE} m")
    w, x, y, z = q / np.sqrt(q @ q)
    T = np.eye(4)
    T[:3, :3] = [[1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
                 [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
                 [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)]]
    T[:3, 3] = t
    return T
