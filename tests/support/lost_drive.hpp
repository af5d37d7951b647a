#pragma once
// The drive through the kitchen put together anew: parts of it one after the other, between which the robot
// is carried while its wheels stand still, with images that are not what the cameras saw; and what both
// mappers made of it, against truth.

#include <cmath>
#include <optional>

#include <lcmslam/landmarks_t.hpp>
#include <lcmslam/messages/camera_messages.hpp>
#include <lcmslam/messages/followed_graph.hpp>
#include "procs/fastslam/fastslam_node.hpp"
#include "procs/icp/icp_node.hpp"
#include "tests/support/recorded_drive.hpp"
#include "tests/support/simulated_kitchen.hpp"

namespace lcmslam::testing {

class LostDrive {
 public:
  /// Of the recorded drive, s.
  struct Part {
    double from, to;
  };
  struct Plan {
    std::vector<Part> parts = {{RecordedDrive::moves, RecordedDrive::ends}};
    /// Changes the images of a time, s after the first part's begin.
    std::function<void(RgbdFrame&, double seconds)> spoil;
    /// rad that all wheels have turned for nothing until then.
    std::function<double(double seconds)> slip = [](double) { return 0.0; };
    /// Whether the processor gets to an image at all.
    std::function<bool(int image, double seconds)> taken = [](int, double) { return true; };
    double pause = 0.35;        ///< s between two parts: about a frame, or a gap in all that is heard
    double new_map_after = 30;  ///< s, of fastslam
    int seed = 1;               ///< of the particles
  };

  explicit LostDrive(const Plan& plan) : plan_(plan) {
    const std::vector<Timed> messages = recorded();
    const RgbdCalibration calibration = SimulatedKitchen::instance().simulation().calibration();
    double now = 0;
    for (const Part& part : plan_.parts) {
      bool first_wheels = true;
      double last = now;
      for (const Timed& message : messages) {
        if (message.seconds < part.from || message.seconds > part.to) continue;
        const double seconds = now + message.seconds - part.from;
        deliver(message, now - part.from, seconds, first_wheels);
        last = seconds;
      }
      pieces_.push_back({utime_at(now), now - part.from});
      now = last + plan_.pause;
    }
    bus.finish();
  }

  /// When a part begins, s after the first one's begin.
  double begin_of(std::size_t part) const {
    return 1e-6 * static_cast<double>(pieces_.at(part).begin - pieces_.front().begin);
  }
  double seconds_of(Utime utime) const { return 1e-6 * static_cast<double>(utime - pieces_.front().begin); }
  Eigen::Isometry3d truth_at(Utime utime) const {
    double shift = pieces_.front().shift;
    for (const Piece& piece : pieces_)
      if (utime >= piece.begin) shift = piece.shift;
    return RecordedDrive::instance().truth_at(utime - micro(shift));
  }

  std::vector<pose_estimate_t> poses(const std::string& channel, const std::string& frame = "map") const {
    std::vector<pose_estimate_t> all = bus.on<pose_estimate_t>(channel);
    all.erase(std::remove_if(all.begin(), all.end(), [&](const auto& m) { return m.frame != frame; }),
              all.end());
    return all;
  }
  /// From a map's frame, which is where its first pose stands, to the world's.
  Eigen::Isometry3d T_world_map(const std::string& channel, const std::string& frame = "map") const {
    const auto all = poses(channel, frame);
    return truth_at(all.at(0).utime) * from_message(all[0].T_map_robot, "T_map_robot").inverse();
  }
  double error_of(const pose_estimate_t& m, const std::string& channel) const {
    const Eigen::Isometry3d T = T_world_map(channel, m.frame) * from_message(m.T_map_robot, "T_map_robot");
    return (T.translation() - truth_at(m.utime).translation()).norm();
  }
  static bool claims(const pose_estimate_t& m) {
    return m.status == pose_estimate_t::TRACKING || m.status == pose_estimate_t::RELOCALISED;
  }
  /// m, RMS of poses that claim to be tracked in a frame, between two times.
  double rms(const std::string& channel, double from, double to = 1e9,
             const std::string& frame = "map") const {
    double squares = 0;
    int count = 0;
    for (const auto& m : poses(channel, frame)) {
      if (!claims(m) || seconds_of(m.utime) < from || seconds_of(m.utime) > to) continue;
      squares += std::pow(error_of(m, channel), 2);
      ++count;
    }
    return count > 0 ? std::sqrt(squares / count) : std::nan("");
  }
  /// s from `begin` on to the first pose that does not claim to be tracked; nothing when all do.
  std::optional<double> told_after(const std::string& channel, double begin) const {
    for (const auto& m : bus.on<pose_estimate_t>(channel))
      if (seconds_of(m.utime) >= begin && !claims(m)) return seconds_of(m.utime) - begin;
    return std::nullopt;
  }
  /// s from `begin` on until poses in the first map claim to be tracked, within 0.1 m of the truth.
  std::optional<double> found_after(const std::string& channel, double begin) const {
    for (const auto& m : poses(channel))
      if (seconds_of(m.utime) >= begin && claims(m) && error_of(m, channel) < 0.1)
        return seconds_of(m.utime) - begin;
    return std::nullopt;
  }

  /// Landmarks of a map at its end.
  struct Count {
    int all = 0, wrong = 0;
  };
  /// Wrong: farther from every true surface than 5 cm and than three sigmas.
  Count landmarks(const std::string& frame = "map") const {
    std::map<std::int64_t, landmark_t> map;
    for (const auto& m : bus.on<landmarks_t>("FASTSLAM_LANDMARKS")) {
      if (m.frame != frame) continue;
      for (const std::int64_t id : m.removed) map.erase(id);
      for (const landmark_t& landmark : m.landmarks) map[landmark.id] = landmark;
    }
    Count count;
    const Eigen::Isometry3d T = T_world_map("FASTSLAM_POSE", frame);
    for (const auto& [id, landmark] : map) {
      const Eigen::Vector3d mean(landmark.mean[0], landmark.mean[1], landmark.mean[2]);
      const double off = SimulatedKitchen::instance().simulation().distance_to_surface(T * mean);
      const double sigma =
          std::sqrt(std::max({landmark.covariance[0], landmark.covariance[3], landmark.covariance[5]}));
      ++count.all;
      count.wrong += off > std::max(0.05, 3 * sigma) ? 1 : 0;
    }
    return count;
  }
  /// Wrong: farther than 0.1 m from where the camera was.
  Count keyframes(const std::string& frame = "map") const {
    FollowedGraph graph;
    for (const auto& m : bus.on<graph_t>("ICP_GRAPH"))
      if (m.frame == frame) graph.apply(m);
    const Eigen::Isometry3d T = T_world_map("ICP_POSE", frame);
    const Eigen::Isometry3d T_robot_camera =
        SimulatedKitchen::instance().simulation().calibration().T_robot_camera;
    Count count;
    for (const auto& [id, node] : graph.nodes()) {
      const Eigen::Isometry3d found = T * from_message(node.T_map_camera, "T_map_camera");
      const Eigen::Isometry3d right = truth_at(node.keyframe_utime) * T_robot_camera;
      ++count.all;
      count.wrong += (found.translation() - right.translation()).norm() > 0.1 ? 1 : 0;
    }
    return count;
  }

  const Plan& plan() const { return plan_; }

 private:
  Plan plan_;

 public:
  TestBus bus;
  OdometryNode& odometry = bus.add<OdometryNode>();
  SurfNode& surf = bus.add<SurfNode>(ConfigNode::parse("{max_features: 600}"), 500);
  FastSlamNode& fastslam = bus.add<FastSlamNode>(
      ConfigNode::parse("{particles: 50, seed: " + std::to_string(plan_.seed) +
                        ", new_map_after: " + std::to_string(plan_.new_map_after) + "}"));
  IcpNode& icp = bus.add<IcpNode>();

 private:
  struct Timed {
    RecordedDrive::Message message;
    double seconds;
  };
  struct Piece {
    Utime begin;
    double shift;  // s from the recorded drive's time to this one's
  };

  static Utime micro(double seconds) { return static_cast<Utime>(std::lround(1e6 * seconds)); }
  Utime utime_at(double seconds) const { return RecordedDrive::instance().start() + micro(seconds); }

  static const std::vector<Timed>& recorded() {
    static const std::vector<Timed> messages = [] {
      std::vector<Timed> all;
      TestBus nobody;
      RecordedDrive::Part part;
      part.from = 0;
      part.disturb = [&](const RecordedDrive::Message& message, double seconds) {
        all.push_back({message, seconds});
        return RecordedDrive::Messages{};
      };
      RecordedDrive::instance().play(nobody, part);
      return all;
    }();
    return messages;
  }

  void deliver(const Timed& timed, double shift, double seconds, bool& first_wheels) {
    if (!calibrated_) {
      bus.deliver("CAMERA_CALIBRATION", SimulatedKitchen::instance().calibration());
      calibrated_ = true;
    }
    const auto& [channel, bytes] = timed.message;
    if (channel == "CAMERA") {
      if (!plan_.taken(recorded_images_++, seconds)) return;
      bus.deliver(channel, images(decode_message<images_t>(bytes.data(), bytes.size()), shift, seconds));
      bus.work();  // keyframes go out
    } else if (channel == "ENCODERS") {
      bus.deliver(channel, wheels(decode_message<encoders_t>(bytes.data(), bytes.size()), shift, seconds,
                                  first_wheels));
      first_wheels = false;
    }
  }

  images_t images(images_t m, double shift, double seconds) {
    if (plan_.spoil) {
      const RgbdCalibration& calibration = SimulatedKitchen::instance().simulation().calibration();
      RgbdFrame frame = decode_images(m, calibration);
      plan_.spoil(frame, seconds);
      EncodedFrame encoded = encode(frame);
      encoded.sensor = calibration.sensor;
      m = to_message(encoded);
    }
    m.utime += micro(shift);
    for (image_t& image : m.images) image.utime += micro(shift);
    set_origin(m, {images_++, 1000});
    return m;
  }

  // Turned since the start: nothing between two parts.
  encoders_t wheels(encoders_t m, double shift, double seconds, bool first) {
    if (first) {
      before_.resize(m.wheels.size(), 0);
      if (last_.empty()) last_ = before_;
      for (std::size_t i = 0; i < m.wheels.size(); ++i) before_[i] = last_[i] - m.wheels[i].angle;
    }
    last_.resize(m.wheels.size());
    for (std::size_t i = 0; i < m.wheels.size(); ++i) {
      m.wheels[i].angle += before_[i];
      last_[i] = m.wheels[i].angle;
      m.wheels[i].angle += plan_.slip(seconds);
    }
    m.utime += micro(shift);
    set_origin(m, {encoders_++, 1001});
    return m;
  }

  std::vector<Piece> pieces_;
  std::vector<double> before_, last_;  // rad of each wheel: added to what was recorded, and as it stood last
  std::int64_t images_ = 0, encoders_ = 0;
  int recorded_images_ = 0;
  bool calibrated_ = false;
};

}  // namespace lcmslam::testing
