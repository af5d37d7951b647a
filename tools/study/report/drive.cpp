#include "tools/study/report/drive.hpp"

#include <fmt/format.h>
#include <cmath>

#include <lcmslam/configuration/share.hpp>
#include <lcmslam/images_t.hpp>
#include <lcmslam/imaging/io/codec.hpp>
#include <lcmslam/messages/camera_messages.hpp>
#include <lcmslam/messages/decode.hpp>
#include <lcmslam/messages/feature_messages.hpp>
#include <lcmslam/runtime/options.hpp>
#include "procs/camera/publish_event.hpp"

namespace lcmslam {
namespace {

constexpr std::size_t most_drives = 8;    // of some ten megabytes each
constexpr Utime calibration_every = 1e6;  // us

class MessageList : public Publisher {
 public:
  MessageList() : Publisher(1) {}
  std::vector<BatchMessage> messages;

 private:
  void send(const std::string& channel, const std::vector<std::uint8_t>& bytes, Utime utime) override {
    messages.push_back({channel, bytes, utime});
  }
};

double seconds_between(Utime from, Utime to) {
  return 1e-6 * static_cast<double>(to - from);
}

/// The drive with FEATURES of its images in the place of those it has.
Drive with_features(Drive drive) {
  std::vector<BatchMessage> all;
  drive.frames.clear();
  BatchGraph graph(
      load_config(share_path("config/replay.yaml").string(), {}), {"surf", "odometry"}, 1,
      [&](const BatchMessage& m) {
        if (m.channel != "FEATURES") return;
        all.push_back(m);
        drive.frames.push_back(from_message(decode_message<features_t>(m.bytes.data(), m.bytes.size())));
      });
  for (BatchMessage& message : drive.messages) {
    if (message.channel == "FEATURES") continue;
    all.push_back(message);
    graph.deliver(std::move(message));
  }
  graph.finish();
  drive.messages = std::move(all);
  return drive;
}

std::string name_of(const DriveSettings& s) {
  return fmt::format("{} {} {} {} {}", s.scene, s.seed, s.seconds, s.frame_rate, s.laps);
}

std::shared_ptr<const Drive> render(const DriveSettings& settings) {
  SimulationSourceSettings source;
  source.simulation.scene = share_path("config/scenes/" + settings.scene + ".yaml");
  source.simulation.seed = static_cast<std::uint64_t>(settings.seed);
  source.simulation.seconds = settings.seconds;
  source.simulation.frame_rate = settings.frame_rate;
  source.simulation.laps = settings.laps;
  source.simulation.threads = 2;
  Drive drive = take_drive(*make_live_simulation(source));
  drive.simulation = std::make_shared<Simulation>(source.simulation);
  return std::make_shared<const Drive>(std::move(drive));
}

}  // namespace

double Drive::distance_to_surface(const Eigen::Vector3d& point_world) const {
  return simulation ? simulation->distance_to_surface(point_world) : std::nan("");
}

DriveSettings usual_drive(bool quick, const std::string& scene, int seed) {
  return quick ? DriveSettings{scene, seed, 4, 3, 1} : DriveSettings{scene, seed, 20, 4, 1};
}

Drive take_drive(CameraSource& source) {
  Drive drive;
  drive.calibration = source.calibration();
  MessageList list;
  Utime first = 0, newest_calibration = 0;
  Eigen::Isometry3d T_camera_robot = Eigen::Isometry3d::Identity();
  if (drive.calibration.has_mount) T_camera_robot = drive.calibration.T_robot_camera.inverse();
  if (!drive.calibration.has_mount) T_camera_robot = optical_axes().inverse();
  while (const auto event = source.next()) {
    const Utime now = event_utime(*event);
    if (first == 0) first = now;
    if (newest_calibration == 0 || now >= newest_calibration + calibration_every) {
      camera_calibration_t message = to_message(drive.calibration);
      message.utime = newest_calibration = now;
      list.publish("CAMERA_CALIBRATION", message);
    }
    if (const auto* truth = std::get_if<GroundTruth>(&*event)) {
      const bool of_camera = truth->child_frame == "camera";
      drive.truth.push_back(
          {truth->utime, of_camera ? truth->T_world_child * T_camera_robot : truth->T_world_child});
    } else {
      publish_event(list, *event);
    }
    drive.seconds = seconds_between(first, now);
  }
  sort_trajectory(drive.truth);
  drive.messages = std::move(list.messages);
  return with_features(std::move(drive));
}

std::shared_ptr<const Drive> DriveStore::drive(const DriveSettings& settings) {
  const std::lock_guard<std::mutex> lock(mutex_);
  const std::string name = name_of(settings);
  for (const auto& [known, drive] : kept_)
    if (known == name) return drive;
  if (kept_.size() >= most_drives) kept_.pop_front();
  kept_.emplace_back(name, render(settings));
  return kept_.back().second;
}

cv::Mat colour_image(const Drive& drive, Utime utime) {
  for (const BatchMessage& message : drive.messages)
    if (message.channel == "CAMERA" && message.utime == utime)
      return decode_colour(
          from_message(decode_message<images_t>(message.bytes.data(), message.bytes.size())).colour);
  return {};
}

Drive with_images(const Drive& drive, const ImageChange& change) {
  Drive changed = drive;
  int number = 0;
  for (BatchMessage& message : changed.messages) {
    if (message.channel != "CAMERA") continue;
    const auto images = decode_message<images_t>(message.bytes.data(), message.bytes.size());
    const EncodedFrame before = from_message(images);
    RgbdFrame frame = decode(before);
    frame.utime = before.utime;
    frame.depth_utime = before.depth.utime;
    change(frame, number++, seconds_between(drive.messages.front().utime, message.utime));
    EncodedFrame after = encode(frame);
    after.sensor = before.sensor;
    after.seq = before.seq;
    images_t coded = to_message(after);
    set_origin(coded, Origin{before.seq, 1});
    message.bytes = encode_message(coded);
  }
  return with_features(std::move(changed));
}

Drive with_calibration(const Drive& drive, const RgbdCalibration& calibration) {
  Drive changed = drive;
  changed.calibration = calibration;
  std::int64_t seq = 0;
  for (BatchMessage& message : changed.messages) {
    if (message.channel != "CAMERA_CALIBRATION") continue;
    camera_calibration_t told = to_message(calibration);
    told.utime = message.utime;
    set_origin(told, Origin{seq++, 1});
    message.bytes = encode_message(told);
  }
  return with_features(std::move(changed));
}

Drive every_nth(const Drive& drive, int n) {
  Drive changed = drive;
  changed.messages.clear();
  changed.frames.clear();
  int images = 0, features = 0;
  for (const BatchMessage& message : drive.messages) {
    if (message.channel == "CAMERA" && images++ % n != 0) continue;
    if (message.channel == "FEATURES") {
      const int number = features++;
      if (number % n != 0) continue;
      changed.frames.push_back(drive.frames[static_cast<std::size_t>(number)]);
    }
    changed.messages.push_back(message);
  }
  return changed;
}

Drive without_wheels(const Drive& drive, double from, double to) {
  Drive changed = drive;
  const Utime first = drive.messages.front().utime;
  changed.messages.clear();
  for (const BatchMessage& message : drive.messages) {
    const double seconds = seconds_between(first, message.utime);
    if (message.channel != "ENCODERS" || seconds < from || seconds >= to) changed.messages.push_back(message);
  }
  return changed;
}

}  // namespace lcmslam
