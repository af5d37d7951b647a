"""write_bag.py LOG ODOMETRY_LOG FILE.bag COMPRESSION: a log's images as ROS 1 records them, by ROS's own rosbag.

Colour as JPEG, depth as 16UC1 in rows of the sensor, CameraInfo, mount and extrinsics on /tf_static, and the odometry of
ODOMETRY_LOG (batch's). Exits with 77 where python3-rosbag is not there.
"""
import os
import sys

try:
    import rosbag
    import rospy
    from geometry_msgs.msg import PoseStamped, TransformStamped
    from nav_msgs.msg import Odometry
    from sensor_msgs.msg import CameraInfo, CompressedImage, Image
    from tf2_msgs.msg import TFMessage
except ImportError as error:
    print(f"skipped: {error}; ./lcmslam test installs python3-rosbag and its messages")
    sys.exit(77)

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "python"))
import lcmslam_log  # noqa: E402
import numpy as np  # noqa: E402


def stamp(utime):
    return rospy.Time(int(utime) // 1_000_000, int(utime) % 1_000_000 * 1000)


def head(message, utime, frame):
    message.header.stamp = stamp(utime)
    message.header.frame_id = frame
    return message


def quaternion(rotation):
    """x, y, z, w by the largest of the four, so that nothing is divided by a small number."""
    r = rotation
    candidates = np.array([1 + r[0, 0] - r[1, 1] - r[2, 2], 1 - r[0, 0] + r[1, 1] - r[2, 2],
                           1 - r[0, 0] - r[1, 1] + r[2, 2], 1 + r[0, 0] + r[1, 1] + r[2, 2]])
    rows = np.array([[candidates[0], r[0, 1] + r[1, 0], r[0, 2] + r[2, 0], r[2, 1] - r[1, 2]],
                     [r[0, 1] + r[1, 0], candidates[1], r[1, 2] + r[2, 1], r[0, 2] - r[2, 0]],
                     [r[0, 2] + r[2, 0], r[1, 2] + r[2, 1], candidates[2], r[1, 0] - r[0, 1]],
                     [r[2, 1] - r[1, 2], r[0, 2] - r[2, 0], r[1, 0] - r[0, 1], candidates[3]]])
    row = rows[np.argmax(candidates)]
    return row / np.linalg.norm(row)


def fill(position, orientation, T):
    position.x, position.y, position.z = (float(value) for value in T[:3, 3])
    orientation.x, orientation.y, orientation.z, orientation.w = (float(v) for v in quaternion(T[:3, :3]))


def transform(parent, child, T):
    message = head(TransformStamped(), 0, parent)
    message.child_frame_id = child
    fill(message.transform.translation, message.transform.rotation, T)
    return message


def camera_info(camera, utime, frame):
    info = head(CameraInfo(), utime, frame)
    info.width, info.height = camera.width, camera.height
    info.distortion_model = "plumb_bob"
    info.D = [float(value) for value in camera.distortion] or [0.0] * 5
    info.K = [float(value) for value in np.asarray(camera.K).ravel()]
    info.R = [1, 0, 0, 0, 1, 0, 0, 0, 1]
    info.P = [info.K[0], 0, info.K[2], 0, 0, info.K[4], info.K[5], 0, 0, 0, 1, 0]
    return info


def depth_image(frame):
    image = head(Image(), frame.depth_utime, "tof_optical")
    image.height, image.width = frame.depth.shape
    image.encoding = "16UC1"
    image.step = 2 * image.width
    image.data = frame.depth.astype("<u2").tobytes()
    return image


def main(log_file, odometry_file, bag_file, compression):
    log = lcmslam_log.Log(log_file)
    calibration = log.calibration()
    with rosbag.Bag(bag_file, "w", compression=compression, chunk_threshold=200_000) as bag:
        first = None
        for frame in log.images():
            if first is None:
                first = frame.utime
                bag.write("/tf_static", TFMessage([
                    transform("base_link", "rgb_optical", np.asarray(calibration.T_robot_camera)),
                    transform("rgb_optical", "tof_optical", np.asarray(calibration.T_colour_depth))]), stamp(first))
            colour = head(CompressedImage(), frame.utime, "rgb_optical")
            colour.format = "rgb8; jpeg compressed bgr8"
            colour.data = bytes(frame.jpeg)
            bag.write("/camera/rgb/image_color/compressed", colour, stamp(frame.utime))
            bag.write("/camera/rgb/camera_info", camera_info(calibration.colour, frame.utime, "rgb_optical"),
                      stamp(frame.utime))
            bag.write("/tof/image_raw", depth_image(frame), stamp(frame.utime))
            bag.write("/tof/camera_info", camera_info(calibration.depth, frame.utime, "tof_optical"),
                      stamp(frame.utime))
        odometry = lcmslam_log.Log(odometry_file).poses("ODOMETRY")
        for utime, T in zip(odometry.utime, odometry.T):
            message = head(Odometry(), utime, "odom")
            message.child_frame_id = "base_link"
            fill(message.pose.pose.position, message.pose.pose.orientation, T)
            bag.write("/odom", message, stamp(utime))
        truth = log.poses("GROUND_TRUTH")
        for utime, T in zip(truth.utime, truth.T):
            message = head(PoseStamped(), utime, "world")
            fill(message.pose.position, message.pose.orientation, T)
            bag.write("/ground_truth", message, stamp(utime))


if __name__ == "__main__":
    main(*sys.argv[1:])
