#pragma once
// A robot's drive as ROS recorded it: bags of ROS 1 and MCAP files as frames of a camera head and odometry.
//
//   ros::RosRecording recording({"drive.bag"}, options);
//   for (const std::string& note : recording.notes()) ...      // what was chosen and assumed
//   while (const auto event = recording.next()) ...            // in order of time

#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include <lcmslam/imaging/calibration.hpp>
#include <lcmslam/imaging/io/encoded_frame.hpp>
#include <lcmslam/odometry/twist_odometry.hpp>
#include <lcmslam/recordings/recording_file.hpp>
#include <lcmslam/ros/topic_choice.hpp>
#include <lcmslam/ros/transform_tree.hpp>
#include <lcmslam/ros/truth_body.hpp>

namespace lcmslam::ros {

struct RosOptions {
  Topics topics;                       ///< where they are not to be chosen
  std::filesystem::path calibration;   ///< in the place of CameraInfo and tf; empty: by those
  double max_stamp_difference = 0.02;  ///< s between a colour image and its depth image
  int jpeg_quality = 90;               ///< of colour images that are not JPEG yet
};

/// One message of odometry: pose of the robot since some start, and its velocity.
struct OdometryEvent {
  Utime utime = 0;
  Eigen::Isometry3d T_odom_robot = Eigen::Isometry3d::Identity();
  Twist twist;
};

struct TruthEvent {
  Utime utime = 0;
  std::string body;  ///< "robot", or "camera": the colour camera
  Eigen::Isometry3d T_world_body = Eigen::Isometry3d::Identity();
};

using RosEvent = std::variant<EncodedFrame, OdometryEvent, TruthEvent>;

class RosRecording {
 public:
  /// Looks through the files once. Throws std::runtime_error (DatasetError, ConfigError) when there is no
  /// colour, no depth, or no calibration: it names what would help,
  /// and the first of problems().
  RosRecording(const std::vector<std::filesystem::path>& files, const RosOptions& options);
  ~RosRecording();

  const RgbdCalibration& calibration() const { return calibration_; }
  std::size_t frames() const { return frames_; }

  /// In order of the stamps; nothing at the end. What cannot be read is left out and listed in problems().
  std::optional<RosEvent> next();

  const std::vector<std::string>& notes() const { return notes_; }
  /// What is damaged or was left out, each beginning with the file or topic; grows as images are read.
  std::vector<std::string> problems() const;

 private:
  struct Entry {
    Utime utime = 0;
    std::size_t file = 0;
    RecordedMessage message;
  };
  struct Topic {
    TopicFacts facts;
    std::string encoding;        // of its messages
    std::vector<Entry> entries;  // of images and poses, by time
    std::optional<CameraInfo> info;
  };
  enum class EventKind { truth, odometry, frame };
  struct Event {
    Utime utime = 0;
    EventKind kind = EventKind::frame;
    std::size_t first = 0, second = 0;  // entries; the second is depth's
  };

  void look_through(std::size_t file);
  void look_at(const RecordedMessage& message, ByteView bytes, std::size_t file);
  void add_entry(Topic& topic, const RosHeader& header, const RecordedMessage& message, std::size_t file);
  double clock_offset_of(const std::string& images) const;
  void list_unusable_transforms();
  void sort_entries(Topic& topic);
  void choose(const RosOptions& options);
  /// Returns the frame of the robot that the mount is of, empty where nobody says it.
  std::string settle_calibration(const RosOptions& options, const Topics& wanted);
  void list_events(double max_stamp_difference);
  void pair_images(double max_stamp_difference);
  Topic& topic(const std::string& name, const std::string& type, const std::string& encoding);
  Topic* find(const std::string& name);
  EncodedFrame read_frame(const Event& event);
  Pose read_pose_of(const Topic& topic, std::size_t entry);
  EncodedImage read_image_of(const Topic& topic, std::size_t entry, bool depth);

  std::vector<std::unique_ptr<RecordingFile>> files_;
  std::vector<std::string> names_;  // of the files
  std::vector<Topic> topics_;
  TransformTree transforms_;
  std::map<std::string, std::size_t> unusable_transforms_;  // how often, by topic and frames
  std::map<std::string, double> clock_offsets_;             // s, the last of each topic of that name
  RgbdCalibration calibration_;
  TruthBody truth_body_;
  int jpeg_quality_ = 90;
  Topic *colour_ = nullptr, *depth_ = nullptr, *odometry_ = nullptr, *truth_ = nullptr;
  std::vector<Event> events_;
  std::size_t next_ = 0, frames_ = 0;
  std::int64_t seq_ = 0;
  std::size_t unstamped_ = 0;
  std::vector<std::string> notes_, problems_;
};

/// The bags and MCAP files that a path means: itself, or those in a folder, sorted by name; empty when it is
/// neither.
std::vector<std::filesystem::path> ros_files(const std::filesystem::path& path);

}  // namespace lcmslam::ros
