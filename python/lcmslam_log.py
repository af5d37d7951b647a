"""Reads lcmslam's logs (.lcmlog) into numpy; nothing is built or generated. docs/PYTHON.md shows its use.

    log = lcmslam_log.Log("run.lcmlog")
    path = log.poses("ICP_POSE")            # path.utime (N,), path.T (N, 4, 4), ...
    for frame in log.images(): ...          # frame.colour (H, W, 3), frame.depth (H, W) in mm

Times are microseconds, lengths metres, angles radians; T_a_b takes points of frame b to frame a. What is damaged is left
out and listed in `log.damages`.
"""
import collections
import mmap
import os

try:
    import numpy as np
except ImportError as error:
    import sys
    raise ImportError(f"{sys.executable} has no numpy: of Debian's /usr/bin/python3 it is apt-get install "
                      f"python3-numpy, of any other python3 -m pip install numpy ({error})") from None

import lcmslam_messages
import lcmslam_types
from lcmslam_messages import descriptors  # noqa: F401: for whoever reads features
from lcmslam_types import DecodeError

Damage = collections.namedtuple("Damage", "file offset end reason")  # bytes [offset, end) of the file
Event = collections.namedtuple("Event", "offset number log_utime channel begin end")  # its message: [begin, end)
Message = collections.namedtuple("Message", "channel log_utime type value event")
Poses = collections.namedtuple("Poses", "utime T covariance status frame child_frame")

_SYNC = bytes.fromhex("EDA1DA01")
_HEADER = 28              # bytes: sync word, number, time, lengths of channel and data; big-endian
_LONGEST_CHANNEL = 999
_LARGEST_MESSAGE = 1 << 28
_SEAL_MARK, _SEAL = b"LCMSEAL1", 40  # trailer: mark, int64 sender, int64 time, 16 bytes of hash
_MOST_WAITING = 8         # messages of which pieces are missing


class LogError(Exception):
    """A file that is no log, or has not what was asked for; the text names the file."""


class Log:
    def __init__(self, path, definitions=()):
        """`definitions` are .lcm files of further types. The file must not be made shorter while it is open."""
        self.path = str(path)
        self.types = lcmslam_types.Types(files=definitions)
        self.damages = []           # Damage; what a method finds in messages is added when it reads them
        self.unknown_types = {}     # channel -> messages that no definition fits, of the last reading
        self.incomplete = 0         # messages of which pieces are missing, of the last reading
        if os.path.isdir(self.path):
            raise LogError(f"{self.path}: is a folder; an LCM log is a file")
        try:
            with open(self.path, "rb") as file:
                self._bytes = mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ)
        except OSError as error:
            raise LogError(f"{self.path}: cannot be opened: {error.strerror}") from None
        except ValueError:
            raise LogError(f"{self.path}: is empty; an LCM log has at least one event") from None
        if self._bytes.find(_SYNC) < 0:
            raise LogError(f"{self.path}: is no LCM log: no event begins in it (bytes ED A1 DA 01)")
        self._found = set()
        self.events = list(self._scan())

    @property
    def channels(self):
        """How many events each channel has."""
        return dict(collections.Counter(event.channel for event in self.events))

    def data(self, event):
        """The bytes of an event's message, without the seal (docs/LCM.md) that it may carry."""
        data = self._bytes[event.begin:event.end]
        return data[:-_SEAL] if data[-_SEAL:][:len(_SEAL_MARK)] == _SEAL_MARK else data

    def messages(self, *channels):
        """Message after message of these channels (all, if none is named) in the file's order, those in pieces
        (<CHANNEL>_PART) joined; `value` has the members of the type's definition."""
        there = self.channels
        for channel in channels:
            if channel not in there and channel + "_PART" not in there:
                raise LogError(f"{self.path}: has no channel {channel}; it has {', '.join(sorted(there))}")
        return self._messages(channels)

    def _messages(self, channels):
        self.unknown_types, self.incomplete = {}, 0
        pieces = _Pieces()
        for event in self.events:
            whole = event.channel[:-5] if event.channel.endswith("_PART") else None
            if channels and event.channel not in channels and whole not in channels:
                continue
            data, channel = self.data(event), event.channel
            try:
                kind = self.types.of(data)
                if kind and kind.name == "part_t" and whole and channel not in channels:
                    data = pieces.add(self.types.decode(data))
                    if data is None:
                        continue
                    channel, kind = whole, self.types.of(data)
                if kind is None:
                    self.unknown_types[channel] = self.unknown_types.get(channel, 0) + 1
                    continue
                yield Message(channel, event.log_utime, kind.name, self.types.decode(data), event)
            except DecodeError as error:
                self._lose(event.offset, event.end, f"{channel}: {error}")
        self.incomplete = pieces.incomplete()

    def images(self, channel="CAMERA"):
        """Frames. `colour` is RGB, uint8; of a JPEG `jpeg` has the bytes, and where neither PIL nor cv2 is installed
        `colour` raises ImportError. `depth` is uint16, mm along the optical axis, 0 = invalid; `amplitude` uint8. What is
        not there is None."""
        return self._converted(channel, ("images_t",), lcmslam_messages.frame)

    def features(self, channel="FEATURES"):
        """features_t's members; `features` is a structured array (N,): x, y, point (N, 3), descriptor (N, 64) ..."""
        return self._converted(channel, ("features_t",), lambda message: message)

    def poses(self, channel):
        """The poses of pose_estimate_t, odometry_t, ground_truth_t or pose_t: utime (N,), T (N, 4, 4), covariance
        (N, 6, 6) with NaN where the type has none, status (N,), and between which frames (T_frame_child)."""
        types = ("pose_estimate_t", "odometry_t", "ground_truth_t", "pose_t")
        found = list(self._converted(channel, types, lcmslam_messages.pose))
        if not found:
            raise LogError(f"{self.path}: {channel} carries no poses")
        utime, T, covariance, status, frames, children = zip(*found)
        return Poses(np.array(utime), np.array(T), np.array(covariance), np.array(status), frames[-1], children[-1])

    def keyframes(self, channel="ICP_KEYFRAME", graph="ICP_GRAPH"):
        """The whole ones of the mapper that began last, where its last graph puts them; points (N, 3) in the camera's
        frame, colours (N, 3) RGB, normals (N, 3), NaN where unknown."""
        channels = [channel] + [graph] * (graph in self.channels or graph + "_PART" in self.channels)
        done, tiles, senders, newest, followed = {}, {}, set(), None, None
        for m in self._converted(channels, ("keyframe_t", "graph_t"), lcmslam_messages.tile_or_graph):
            if m.sender not in senders:  # a mapper never heard before has begun a map of its own
                senders.add(m.sender)
                newest, done, tiles, followed = m.sender, {}, {}, lcmslam_messages.FollowedGraph()
            if m.sender != newest:
                continue
            if isinstance(m, lcmslam_messages.Graph):
                followed.apply(m)
                done = followed.follow(done, m)
                continue
            key = (m.utime, m.revision, m.n_tiles)
            if m.id not in tiles or tiles[m.id][0] != key:
                tiles[m.id] = (key, {})
            tiles[m.id][1].pop(m.tile, None)  # the newest comes last
            tiles[m.id][1][m.tile] = m
            if len(tiles[m.id][1]) == m.n_tiles:
                done[m.id] = lcmslam_messages.keyframe(tiles.pop(m.id)[1])
        return [done[i] for i in sorted(done)]

    def cloud(self, **channels):
        """All keyframes' points in the map's frame and their colours: (N, 3), (N, 3)."""
        keyframes = self.keyframes(**channels)
        if not keyframes:
            raise LogError(f"{self.path}: no keyframe in it is whole")
        points = [k.points @ k.T_map_camera[:3, :3].T + k.T_map_camera[:3, 3] for k in keyframes]
        return np.concatenate(points), np.concatenate([k.colours for k in keyframes])

    def calibration(self, channel="CAMERA_CALIBRATION"):
        """The first one; `message` has what else camera_calibration_t says (noise, ranges, clock)."""
        for calibration in self._converted(channel, ("camera_calibration_t",), lcmslam_messages.calibration):
            return calibration
        raise LogError(f"{self.path}: no message of {channel} is a calibration")

    def _converted(self, channels, types, convert):
        messages = self.messages(*([channels] if isinstance(channels, str) else channels))

        def each():
            for message in messages:
                try:
                    if message.type not in types:
                        raise DecodeError(f"is a {message.type}, not a {' or '.join(types)}")
                    converted = convert(message.value)
                except DecodeError as error:
                    self._lose(message.event.offset, message.event.end, f"{message.channel}: {error}")
                    continue
                yield converted

        return each()

    def _lose(self, begin, end, reason):
        if begin not in self._found:
            self._found.add(begin)
            self.damages.append(Damage(self.path, begin, end, reason))

    # An event is whole when the next one follows it with the next number, or when its message is exactly what its type
    # says. Else bytes of it may be missing, or what follows is damaged: the next sync word tells where to go on.
    def _scan(self):
        at, size = 0, len(self._bytes)
        while at < size:
            event, reason = self._event_at(at)
            if event and not self._is_whole(event):
                event, reason = None, f"event {event.number}: its length is wrong, or a part of it is missing"
            if event:
                yield event
                at = event.end
                continue
            end = self._bytes.find(_SYNC, at + 1)
            end = size if end < 0 else end
            if self.damages and self.damages[-1].end == at:
                self.damages[-1] = self.damages[-1]._replace(end=end)
            else:
                self._lose(at, end, reason)
            at = end

    def _event_at(self, at):
        header = self._bytes[at:at + _HEADER]
        if header[:4] != _SYNC:
            return None, "no event begins here"
        if len(header) < _HEADER:
            return None, "the file ends within a header"
        number, utime, channel, data = (int.from_bytes(header[a:b], "big", signed=True)
                                        for a, b in ((4, 12), (12, 20), (20, 24), (24, 28)))
        if not (1 <= channel <= _LONGEST_CHANNEL and 0 <= data <= _LARGEST_MESSAGE):
            return None, "a header with impossible values"
        begin = at + _HEADER + channel
        name = self._bytes[at + _HEADER:begin]
        if begin + data > len(self._bytes) or 0 in name:
            return None, f"event {number}: claims {_HEADER + channel + data} bytes, there are {len(self._bytes) - at}"
        return Event(at, number, utime, name.decode(errors="replace"), begin, begin + data), None

    def _is_whole(self, event):
        follower = self._bytes[event.end:event.end + 12]
        follows = follower[:4] == _SYNC[:len(follower)]
        if follows and len(follower) == 12 and int.from_bytes(follower[4:], "big", signed=True) == event.number + 1:
            return True
        data = self.data(event)
        if self.types.of(data) is None:  # nothing but an event inside tells that its length is wrong
            return follows or self._bytes.find(_SYNC, event.offset + 4, event.end) < 0
        try:
            self.types.decode(data)
        except DecodeError:
            return False
        return True


class _Pieces:
    """part_t's of big messages, put together."""

    def __init__(self):
        self._waiting = {}  # oldest first
        self._given_up = 0

    def add(self, part):
        """The whole message's bytes with its last piece, else None."""
        if not (0 <= part.part < part.n_parts <= part.total_size <= _LARGEST_MESSAGE):
            raise DecodeError(f"part_t: part {part.part} of {part.n_parts} cannot be")
        key = (part.sender, part.channel, part.message)
        if key not in self._waiting and len(self._waiting) == _MOST_WAITING:
            self._waiting.pop(next(iter(self._waiting)))
            self._given_up += 1
        parts = self._waiting.setdefault(key, {})
        parts[part.part] = part.data.tobytes()
        if len(parts) < part.n_parts:
            return None
        del self._waiting[key]
        data = b"".join(parts[i] for i in sorted(parts))
        if len(data) != part.total_size:
            raise DecodeError("part_t: the pieces of a message do not add up to its size")
        return data

    def incomplete(self):
        return self._given_up + len(self._waiting)
