#include <lcmslam/ros/head_calibration.hpp>

#include <cmath>
#include <cstdio>

#include <lcmslam/configuration/config.hpp>
#include <lcmslam/datasets/dataset.hpp>
#include <lcmslam/files/decimal_text.hpp>
#include <lcmslam/imaging/io/foreign_calibration.hpp>

namespace lcmslam::ros {
namespace {

template <class Numbers>
std::string list(const Numbers& numbers) {
  std::string text = "[";
  for (const double number : numbers) {
    if (text.size() > 1) text += ", ";
    append_general(text, number, 17);
  }
  return text + "]";
}

/// Images named so are free of distortion, with the intrinsics of P.
bool is_rectified(const std::string& topic) {
  return topic.find("_rect") != std::string::npos || topic.find("/rect") != std::string::npos;
}

/// Checked as files of ROS's camera_calibration are.
CameraModel camera_of(const CameraInfo& info, const std::string& topic, bool rectified) {
  std::string text =
      "width: " + std::to_string(info.width) + "\nheight: " + std::to_string(info.height) + "\n";
  const bool has_projection = info.P[0] > 0;
  if (rectified && has_projection) {
    text +=
        "K: " + list(std::array<double, 9>{info.P[0], 0, info.P[2], 0, info.P[5], info.P[6], 0, 0, 1}) + "\n";
  } else {
    text += "K: " + list(info.K) + "\n";
    if (!rectified) {
      text += "D: " + list(info.D) + "\n";
      const bool is_word =
          info.distortion_model.find_first_not_of("abcdefghijklmnopqrstuvwxyz_") == std::string::npos;
      text += "distortion_model: \"" + (is_word ? info.distortion_model : "unreadable") + "\"\n";
    }
  }
  const ConfigNode config = ConfigNode::parse(text, topic);
  return read_foreign_camera(config);
}

/// At the images' size: binning and transports make them smaller.
CameraModel at_size(const CameraModel& camera, const RecordedCamera& of, std::vector<std::string>& notes) {
  if (camera.width == of.size.width && camera.height == of.size.height) return camera;
  const auto size = [](int width, int height) {
    return std::to_string(width) + "x" + std::to_string(height);
  };
  const double factor = double{1} * of.size.width / camera.width;
  if (std::lround(camera.height * factor) != of.size.height)
    throw DatasetError(of.info_topic + ": is of images of " + size(camera.width, camera.height) +
                       ", but those of " + of.topic + " are " + size(of.size.width, of.size.height) +
                       ": --calibration FILE gives theirs");
  notes.push_back(of.topic + ": intrinsics scaled from " + size(camera.width, camera.height) + " to " +
                  size(of.size.width, of.size.height));
  CameraModel scaled = camera.scaled(factor);
  scaled.width = of.size.width;
  scaled.height = of.size.height;
  return scaled;
}

CameraModel intrinsics(const RecordedCamera& of, std::vector<std::string>& notes) {
  const CameraInfo& info = *of.info;
  const bool is_part = info.roi_width != 0 && info.roi_height != 0 &&
                       (info.roi_width != info.width || info.roi_height != info.height);
  if (is_part)
    throw DatasetError(of.info_topic +
                       ": its images are a part of the sensor's (region of interest): "
                       "--calibration FILE gives their intrinsics");
  if (is_rectified(of.topic)) notes.push_back(of.topic + ": rectified, so without distortion");
  return at_size(camera_of(info, of.info_topic, is_rectified(of.topic)), of, notes);
}

bool are_alike(const CameraModel& a, const CameraModel& b) {
  return a.width == b.width && a.height == b.height && std::abs(a.fx - b.fx) < 1e-3 &&
         std::abs(a.fy - b.fy) < 1e-3 && std::abs(a.cx - b.cx) < 1e-3 && std::abs(a.cy - b.cy) < 1e-3 &&
         a.distortion == b.distortion;
}

bool says_registered(const std::string& topic) {
  return topic.find("registered") != std::string::npos || topic.find("aligned") != std::string::npos;
}

bool is_nearly_identity(const Eigen::Isometry3d& T) {
  return T.translation().norm() < 1e-3 && rotation_angle(T) < 2e-3;
}

/// An empty name is none: of images without names nobody says where they were taken.
bool are_of_one_frame(const RecordedCamera& a, const RecordedCamera& b) {
  return !a.frame.empty() && a.frame == b.frame;
}

/// By the name of depth's topic, where frames and tf do not say otherwise: "aligned" may be to another
/// camera.
bool is_registered_by_name(const RecordedCamera& colour, const RecordedCamera& depth,
                           const TransformTree& transforms) {
  if (!says_registered(depth.topic)) return false;
  if (colour.frame.empty() || depth.frame.empty()) return true;
  const auto found = transforms.find(colour.frame, depth.frame);
  return !found || is_nearly_identity(found->T_a_b);
}

void check_frames(const RecordedCamera& colour, const RecordedCamera& depth) {
  std::string nameless;
  for (const RecordedCamera* of : {&colour, &depth})
    if (of->frame.empty()) nameless += (nameless.empty() ? "" : " and ") + of->topic;
  if (nameless.empty()) return;
  throw DatasetError("the images of " + nameless +
                     " are of no frame (their frame_id is empty), so where the depth camera sits on the "
                     "colour camera nobody says: --calibration FILE does");
}

std::string place(const Eigen::Isometry3d& T) {
  char text[80];
  const Eigen::Vector3d t = T.translation();
  std::snprintf(text, sizeof text, "%.3f, %.3f, %.3f m, turned %.1f degrees", t.x(), t.y(), t.z(),
                rotation_angle(T) * 180 / M_PI);
  return text;
}

std::string moves(const TransformTree::Found& found) {
  if (found.is_still()) return "";
  char text[160];
  std::snprintf(text, sizeof text,
                "; it moves by %.3f m and %.1f degrees later, which is not followed: the first stands",
                found.moved, found.turned * 180 / M_PI);
  return text;
}

void place_depth(const RecordedCamera& colour, const RecordedCamera& depth, const TransformTree& transforms,
                 HeadCalibration& head) {
  RgbdCalibration& calibration = head.calibration;
  const bool one_frame = are_of_one_frame(colour, depth);
  if (one_frame || is_registered_by_name(colour, depth, transforms)) {
    // Drivers that register leave depth's distortion out, or repeat colour's CameraInfo.
    calibration.depth_registered = are_alike(calibration.colour, calibration.depth);
    head.notes.push_back(std::string(calibration.depth_registered
                                         ? "depth is registered to colour: "
                                         : "depth is of colour's frame with intrinsics of its own: ") +
                         (one_frame ? "both are of " + colour.frame : depth.topic + " says so"));
    return;
  }
  check_frames(colour, depth);
  const auto found = transforms.find(colour.frame, depth.frame);
  if (!found)
    throw DatasetError("no transform leads from " + colour.frame + " to " + depth.frame +
                       " (/tf_static, /tf): record them too, or give --calibration FILE");
  calibration.T_colour_depth = found->T_a_b;
  head.notes.push_back(
      "depth camera in the colour camera's frame, by tf: " + place(found->T_a_b) + moves(*found) +
      (says_registered(depth.topic) ? "; " + depth.topic +
                                          " is not taken as registered, though its name says "
                                          "so (where it is right: --calibration FILE)"
                                    : ""));
}

void mount(const RecordedCamera& colour, const TransformTree& transforms,
           const std::vector<std::string>& robot_frames, HeadCalibration& head) {
  for (const std::string& frame : robot_frames) {
    const auto found = transforms.find(frame, colour.frame);
    if (!found || frame.empty()) continue;
    head.calibration.has_mount = true;
    head.calibration.T_robot_camera = found->T_a_b;
    head.robot_frame = frame;
    head.notes.push_back("mount of " + colour.frame + " on " + frame + ", by tf: " + place(found->T_a_b) +
                         moves(*found));
    return;
  }
  std::string tried;
  for (const std::string& frame : robot_frames) tried += (tried.empty() ? "" : ", ") + frame;
  head.notes.push_back("no mount: no transform (/tf_static, /tf) leads from the robot (" + tried + ") to " +
                       (colour.frame.empty() ? colour.topic + ", which is of no frame" : colour.frame));
}

}  // namespace

HeadCalibration make_calibration(const RecordedCamera& colour, const RecordedCamera& depth,
                                 const TransformTree& transforms,
                                 const std::vector<std::string>& robot_frames) {
  if (!colour.info)
    throw DatasetError(
        "no CameraInfo belongs to " + colour.topic + " (" + camera_info_beside(colour.topic) +
        " is not there): --colour-info-topic names one, or --calibration FILE gives the intrinsics");
  HeadCalibration head;
  RgbdCalibration& calibration = head.calibration;
  calibration.sensor = "ros";
  calibration.colour = intrinsics(colour, head.notes);
  const bool shares =
      !depth.info && (are_of_one_frame(colour, depth) || is_registered_by_name(colour, depth, transforms));
  if (!depth.info && !shares)
    throw DatasetError(
        "no CameraInfo belongs to " + depth.topic + " (" + camera_info_beside(depth.topic) +
        " is not there): --depth-info-topic names one, or --calibration FILE gives the intrinsics");
  calibration.depth = shares ? calibration.colour : intrinsics(depth, head.notes);
  if (shares) calibration.depth = at_size(calibration.colour, depth, head.notes);
  place_depth(colour, depth, transforms, head);
  mount(colour, transforms, robot_frames, head);
  try {
    calibration.check();
  } catch (const std::invalid_argument& error) {
    throw DatasetError(std::string("its calibration cannot be used: ") + error.what());
  }
  return head;
}

}  // namespace lcmslam::ros
