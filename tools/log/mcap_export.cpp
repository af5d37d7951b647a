#include "tools/log/mcap_export.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <filesystem>
#include <iterator>
#include <memory>
#include <optional>
#include <utility>

#include <lcmslam/imaging/io/codec.hpp>
#include <lcmslam/messages/camera_messages.hpp>
#include <lcmslam/messages/decode.hpp>
#include <lcmslam/messages/geometry_messages.hpp>
#include <lcmslam/messages/map_messages.hpp>
#include <lcmslam/messages/motion_messages.hpp>
#include <lcmslam/recordings/mcap_writer.hpp>
#include <lcmslam/ros/definitions.hpp>
#include <lcmslam/ros/message_writers.hpp>
#include "tools/log/message_facts.hpp"
#include "tools/log/message_reader.hpp"
#include "tools/output_file.hpp"

namespace lcmslam {
namespace {

constexpr double latest = 4'294'967'295e6;  // us: ROS counts seconds in 32 bits
const std::string colour_frame = "camera_colour_optical_frame", depth_frame = "camera_depth_optical_frame";

/// "ICP_POSE" -> "/icp_pose"
std::string topic_of(std::string_view channel) {
  std::string topic = "/";
  for (const char c : channel) topic += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return topic;
}

/// As ROS names the robot's frame.
std::string frame_of(const std::string& frame) {
  if (frame == "robot") return "base_link";
  return frame == "camera" ? colour_frame : frame;
}

/// Messages of LCM come in, those of ROS go out.
class McapExporter {
 public:
  /// `tf_channel`: whose poses say where the robot is.
  McapExporter(McapWriter& writer, std::string tf_channel, McapExport& result)
      : writer_(writer), tf_channel_(std::move(tf_channel)), result_(result) {}

  /// Whether the message has a counterpart. Throws DecodeError, CodecError.
  bool take(const LogEventView& event) {
    const MessageType* type = message_type(event.data, event.size);
    if (type == nullptr) return false;
    log_time_ = event.timestamp;
    channel_ = std::string(event.channel);
    return take_as<images_t>(*type, event) || take_as<camera_calibration_t>(*type, event) ||
           take_as<odometry_t>(*type, event) || take_as<pose_t>(*type, event) ||
           take_as<pose_estimate_t>(*type, event) || take_as<ground_truth_t>(*type, event) ||
           take_as<keyframe_t>(*type, event);
  }

 private:
  template <class M>
  bool take_as(const MessageType& type, const LogEventView& event) {
    if (type.name != M::getTypeName()) return false;
    take(decode_message<M>(event.data, event.size));
    return true;
  }

  void take(const images_t& message) {
    const EncodedFrame frame = from_message(message);
    const std::string topic = topic_of(channel_);
    if (frame.colour.coding == ImageCoding::jpeg)
      write(topic + "/colour/image/compressed", "sensor_msgs/msg/CompressedImage", frame.colour.utime,
            ros::write_compressed_image({frame.colour.utime, colour_frame}, "jpeg",
                                        {frame.colour.bytes.data(), frame.colour.bytes.size()}));
    else if (frame.colour.coding != ImageCoding::none)
      write(topic + "/colour/image", "sensor_msgs/msg/Image", frame.colour.utime,
            ros::write_image({frame.colour.utime, colour_frame}, decode_colour(frame.colour)));
    const RosHeader header{calibration_.depth_time(frame.depth.utime),
                           calibration_.depth_registered ? colour_frame : depth_frame};
    tell_clock_offset(topic + "/depth/clock_offset", header.utime);
    if (frame.depth.coding != ImageCoding::none)
      write(topic + "/depth/image", "sensor_msgs/msg/Image", header.utime,
            ros::write_image(header, decode_depth(frame.depth)));
    if (frame.amplitude.coding != ImageCoding::none)
      write(topic + "/amplitude/image", "sensor_msgs/msg/Image", header.utime,
            ros::write_image(header, decode_gray(frame.amplitude)));
  }

  /// ROS knows one clock, so depth's stamps are put on colour's; a reader that knows this topic has the
  /// camera's own again, and does not add a calibration's offset twice.
  void tell_clock_offset(const std::string& topic, Utime utime) {
    const double offset = calibration_.depth_clock_offset;
    const std::string type = "std_msgs/msg/Float64";
    if (offset == 0 && channels_.count({topic, type}) == 0) return;
    write(topic, type, utime, ros::write_number(offset));
  }

  void take(const camera_calibration_t& message) {
    calibration_ = from_message(message);
    std::string topic = topic_of(channel_);
    const std::string ending = "_calibration";
    if (topic.size() > ending.size() && topic.substr(topic.size() - ending.size()) == ending)
      topic.erase(topic.size() - ending.size());
    const RosHeader colour{message.utime, colour_frame};
    const RosHeader depth{message.utime, calibration_.depth_registered ? colour_frame : depth_frame};
    write(topic + "/colour/camera_info", "sensor_msgs/msg/CameraInfo", message.utime,
          ros::write_camera_info(colour, calibration_.colour));
    write(topic + "/depth/camera_info", "sensor_msgs/msg/CameraInfo", message.utime,
          ros::write_camera_info(depth, calibration_.depth));
    std::vector<ros::Transform> transforms;
    if (calibration_.has_mount)
      transforms.push_back({{message.utime, "base_link"}, colour_frame, calibration_.T_robot_camera});
    if (!calibration_.depth_registered)
      transforms.push_back({colour, depth_frame, calibration_.T_colour_depth});
    if (!transforms.empty())
      write("/tf_static", "tf2_msgs/msg/TFMessage", message.utime, ros::write_transforms(transforms));
  }

  void take(const odometry_t& message) {
    const MotionSample sample = from_message(message);
    const Matrix6d velocity =
        Eigen::Map<const Eigen::Matrix<double, 6, 6, Eigen::RowMajor>>(message.velocity_covariance);
    write(
        topic_of(channel_), "nav_msgs/msg/Odometry", message.utime,
        ros::write_odometry({message.utime, frame_of(message.frame)}, frame_of(message.child_frame),
                            sample.T_odom_robot, sample.covariance, Eigen::Vector3d(message.linear_velocity),
                            Eigen::Vector3d(message.angular_velocity), velocity));
    place_robot(message.utime, frame_of(message.frame), sample.T_odom_robot);
  }

  void take(const pose_t& message) {
    const Eigen::Isometry3d pose = from_message(message);
    write(topic_of(channel_), "nav_msgs/msg/Odometry", message.utime,
          ros::write_odometry({message.utime, "odom"}, "base_link", pose, Matrix6d::Zero(),
                              Eigen::Vector3d(message.vel), Eigen::Vector3d(message.rotation_rate),
                              Matrix6d::Zero()));
    place_robot(message.utime, "odom", pose);
  }

  void take(const pose_estimate_t& message) {
    const Eigen::Isometry3d pose = from_message(message.T_map_robot, "T_map_robot");
    const bool is_known = std::all_of(std::begin(message.covariance), std::end(message.covariance),
                                      [](double value) { return std::isfinite(value); });
    const Matrix6d covariance = is_known ? covariance_from_message(message.covariance, "covariance")
                                         : Matrix6d(Matrix6d::Zero());  // ROS's word for unknown
    write(topic_of(channel_), "geometry_msgs/msg/PoseWithCovarianceStamped", message.utime,
          ros::write_pose_with_covariance({message.utime, frame_of(message.frame)}, pose, covariance));
    place_robot(message.utime, frame_of(message.frame), pose);
  }

  /// PoseStamped names no body and counts for the robot's; a camera's path goes where a body has a name.
  void take(const ground_truth_t& message) {
    const RosHeader header{message.utime, frame_of(message.frame)};
    const Eigen::Isometry3d pose = from_message(message.T_frame_child, "T_frame_child");
    if (message.child_frame == "robot")
      return write(topic_of(channel_), "geometry_msgs/msg/PoseStamped", message.utime,
                   ros::write_pose(header, pose));
    const Eigen::Vector3d unknown = Eigen::Vector3d::Constant(std::nan(""));
    write(topic_of(channel_), "nav_msgs/msg/Odometry", message.utime,
          ros::write_odometry(header, frame_of(message.child_frame), pose, Matrix6d::Zero(), unknown, unknown,
                              Matrix6d::Zero()));
  }

  /// A tile of a keyframe's cloud, in the map as the mapper saw it then.
  void take(const keyframe_t& message) {
    const DenseKeyframe keyframe = from_message(message).part;
    const Eigen::Isometry3f T_map_camera = keyframe.T_world_camera.cast<float>();
    std::vector<ros::ColouredPoint> points;
    for (std::size_t i = 0; i < keyframe.cloud.points.size(); ++i) {
      const auto& colour = keyframe.cloud.colours[i];
      points.push_back({T_map_camera * keyframe.cloud.points[i], colour[2], colour[1], colour[0]});
    }
    write(topic_of(channel_), "sensor_msgs/msg/PointCloud2", message.utime,
          ros::write_points({message.utime, frame_of(message.frame)}, points));
  }

  void place_robot(Utime utime, const std::string& frame, const Eigen::Isometry3d& pose) {
    if (channel_ != tf_channel_) return;
    write("/tf", "tf2_msgs/msg/TFMessage", utime,
          ros::write_transforms({{{utime, frame}, "base_link", pose}}));
  }

  void write(const std::string& topic, const std::string& type, Utime utime, const CdrWriter& message) {
    check_range(static_cast<double>(utime), 0, latest, "utime");
    const auto [known, is_new] = channels_.try_emplace({topic, type});
    if (is_new) known->second = writer_.add_channel(topic, type, ros::message_definition(type));
    const bool is_sane = log_time_ >= 0 && static_cast<double>(log_time_) <= latest;
    writer_.write(known->second, (is_sane ? log_time_ : utime) * 1000, utime * 1000, message.view());
    ++result_.topics[topic];
  }

  McapWriter& writer_;
  std::string tf_channel_;
  McapExport& result_;
  std::map<std::pair<std::string, std::string>, std::uint16_t> channels_;  // by topic and type
  RgbdCalibration calibration_;
  std::string channel_;  // of the message that is taken
  Utime log_time_ = 0;
};

/// The best pose that the logs have: only one may say where the robot is.
std::string choose_tf_channel(const std::map<std::string, std::size_t>& channels) {
  for (const char* channel : {"ICP_POSE", "FASTSLAM_POSE", "ODOMETRY", "POSE_BODY"})
    if (channels.count(channel) > 0) return channel;
  return "";
}

/// Logs of one drive by log time; a channel that several have is taken from the first.
class MergedLogs {
 public:
  explicit MergedLogs(const std::vector<std::string>& logs) {
    for (std::size_t i = 0; i < logs.size(); ++i) {
      for (const std::string& channel : scan_log(logs[i]).channels) channels_.emplace(channel, i);
      readers_.push_back(std::make_unique<MessageReader>(logs[i]));
      ahead_.push_back(readers_.back()->next());
    }
  }

  const std::map<std::string, std::size_t>& channels() const { return channels_; }

  /// Calls `take` with every message.
  template <class Take>
  void for_each(const Take& take) {
    while (const auto log = earliest()) {
      const LogEventView event = *ahead_[*log];
      // What a damaged event hides comes to light when it is left out: the scan did not see it.
      if (channels_.emplace(event.channel, *log).first->second == *log) take(event);
      ahead_[*log] = readers_[*log]->next();
    }
  }

  std::vector<LogDamage> damages() const {
    std::vector<LogDamage> all;
    for (const auto& reader : readers_)
      for (const LogDamage& damage : reader->damages()) all.push_back(damage);
    return all;
  }

 private:
  std::optional<std::size_t> earliest() const {
    std::optional<std::size_t> first;
    for (std::size_t i = 0; i < ahead_.size(); ++i)
      if (ahead_[i] && (!first || ahead_[i]->timestamp < ahead_[*first]->timestamp)) first = i;
    return first;
  }

  std::map<std::string, std::size_t> channels_;  // and the log that they are taken from
  std::vector<std::unique_ptr<MessageReader>> readers_;
  std::vector<std::optional<LogEventView>> ahead_;
};

}  // namespace

McapExport export_mcap(const std::vector<std::string>& logs, const LogOutput& output,
                       const std::string& compression) {
  std::error_code ignored;
  for (const std::string& log : logs)
    if (std::filesystem::equivalent(log, output.file, ignored))
      throw std::runtime_error(output.file + ": is the input; name another file");
  check_output_file(output.file, output.overwrite);
  McapExport result;
  McapWriter::Options options;
  options.compression = compression == "none" ? "" : compression;
  MergedLogs merged(logs);
  McapWriter writer(output.file, options);
  McapExporter exporter(writer, choose_tf_channel(merged.channels()), result);
  merged.for_each([&](const LogEventView& event) {
    throw_when_stopped();
    const std::string channel(event.channel);
    try {
      if (!exporter.take(event)) ++result.without_counterpart[channel];
    } catch (const DecodeError&) {
      ++result.undecoded[channel];
    } catch (const CodecError&) {
      ++result.undecoded[channel];
    }
  });
  result.damages = merged.damages();
  if (result.topics.empty())
    throw std::runtime_error(logs.front() +
                             ": has nothing that ROS has a message for (images, calibration, poses)");
  writer.close();
  result.bytes = writer.bytes();
  return result;
}

}  // namespace lcmslam
