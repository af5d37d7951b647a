#include "tools/evaluate/trajectory_inputs.hpp"

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <fstream>
#include <map>

#include <lcmslam/evaluation/pose_text.hpp>
#include <lcmslam/imaging/io/calibration_file.hpp>
#include "tools/evaluate/pose_omissions.hpp"

namespace lcmslam {
namespace {

const char* const truth_channel = "GROUND_TRUTH";
const char* const estimate_channels[] = {"FASTSLAM_POSE", "ICP_POSE", "ICP_FINAL", "ODOMETRY"};

/// The line of a text file's comments that speaks of ground truth; 0 when there is none.
int ground_truth_comment(const std::string& file) {
  std::ifstream text(file);
  std::string line;
  for (int number = 1; std::getline(text, line) && (line.empty() || line[0] == '#'); ++number) {
    for (char& c : line) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    std::replace(line.begin(), line.end(), '_', ' ');
    if (line.find("ground truth") != std::string::npos || line.find("groundtruth") != std::string::npos)
      return number;
  }
  return 0;
}

std::string stem(const std::string& file) {
  return std::filesystem::path(file).stem().string();
}

class InputReader {
 public:
  explicit InputReader(const InputRequest& request) : request_(request) {}

  EvaluationInputs read() {
    read_truth();
    for (const std::string& text : request_.estimates) read_estimates(text);
    if (request_.estimates.empty()) read_estimates(inputs_.truth.file);
    name_estimates();
    to_one_body();
    for (EvaluatedPath& estimate : inputs_.estimates) compare_with_truth(estimate);
    return std::move(inputs_);
  }

 private:
  void read_truth() {
    std::string text = request_.truth;
    if (text.empty()) {
      if (request_.estimates.size() != 1 || !is_log(split_channel(request_.estimates[0]).file))
        throw std::runtime_error("no truth: give --truth FILE (only a single log brings its own)");
      text = split_channel(request_.estimates[0]).file;
      check_own_truth(text);
    } else if (request_.estimates.empty() && !is_log(split_channel(text).file)) {
      throw std::runtime_error("no estimates: give the files to compare with " + text);
    }
    const auto [file, channel] = split_channel(text);
    inputs_.truth =
        is_log(file) ? from_log(file, channel.empty() ? truth_channel : channel) : from_text(file, channel);
    inputs_.truth.name = "truth";
    if (!request_.truth_body.empty()) inputs_.truth.body = request_.truth_body;
  }

  /// A log that a batch or a mapper left has estimates alone.
  void check_own_truth(const std::string& file) {
    const PoseLog& own = log(file);
    try {
      own.channel(truth_channel, file);
    } catch (const std::runtime_error& error) {
      throw std::runtime_error(std::string(error.what()) +
                               "; give --truth FILE: of a batch.lcmlog the log that it was made from");
    }
  }

  void read_estimates(const std::string& text) {
    const auto [file, channel] = split_channel(text);
    if (!is_log(file)) return add(from_text(file, channel));
    if (!channel.empty()) return add(from_log(file, channel));
    bool found = false;
    for (const char* name : estimate_channels) {
      if (log(file).channels().count(name) == 0) continue;
      add(from_log(file, name));
      found = true;
    }
    if (!found) log(file).channel(estimate_channels[0], file);  // throws: names what there is
  }

  void add(EvaluatedPath path) {
    if (!request_.estimate_body.empty()) path.body = request_.estimate_body;
    inputs_.estimates.push_back(std::move(path));
  }

  EvaluatedPath from_text(const std::string& file, const std::string& channel) {
    if (!channel.empty()) throw std::runtime_error(file + ": is no LCM log and has no channel " + channel);
    PoseText text = read_pose_text(file);
    EvaluatedPath path{"", file, "", text.body, std::move(text.trajectory), 0, 0, ""};
    if (path.trajectory.empty()) throw TrajectoryError(file + ": has no poses");
    if (!text.assumption.empty()) note(file + " " + text.assumption);
    if (const int line = ground_truth_comment(file); line > 0)
      path.truth_origin = file + ":" + std::to_string(line) + " says so";
    return path;
  }

  EvaluatedPath from_log(const std::string& file, const std::string& name) {
    const PoseChannel& channel = log(file).channel(name, file);
    if (channel.trajectory.empty())
      throw std::runtime_error(file + ": no message of channel " + name + " is a usable pose");
    EvaluatedPath path{"", file, name, channel.body, channel.trajectory, channel.lost, channel.degraded, ""};
    if (channel.is_ground_truth()) path.truth_origin = "it is a channel of ground truth";
    if (channel.source.find("truth") != std::string::npos)
      path.truth_origin = "its messages give '" + channel.source + "' as their source";
    const std::string full_name = file + ":" + name;
    for (const std::string& omission : omissions(channel, full_name)) note(omission);
    return path;
  }

  const PoseLog& log(const std::string& file) {
    if (const auto found = logs_.find(file); found != logs_.end()) return found->second;
    const PoseLog& log = logs_.emplace(file, read_pose_log(file)).first->second;
    for (const std::string& omission : omissions(log, file)) note(omission);
    return log;
  }

  void name_estimates() {
    for (EvaluatedPath& e : inputs_.estimates) e.name = e.channel.empty() ? stem(e.file) : e.channel;
    std::map<std::string, int> uses;
    for (const EvaluatedPath& e : inputs_.estimates) ++uses[e.name];
    for (EvaluatedPath& e : inputs_.estimates)
      if (uses[e.name] > 1) e.name = e.channel.empty() ? e.file : stem(e.file) + ":" + e.channel;
  }

  /// Robot unless all that is known speaks of one other frame.
  std::string common_body() {
    std::vector<std::string> known;
    for (const EvaluatedPath* path : all())
      if (!path->body.empty()) known.push_back(path->body);
    const bool same = !known.empty() && std::all_of(known.begin(), known.end(), [&](const std::string& body) {
      return body == known.front();
    });
    return same ? known.front() : known.empty() ? "" : "robot";
  }

  void to_one_body() {
    const std::string wanted = common_body();
    for (EvaluatedPath* path : all()) {
      if (path->body == wanted) continue;
      if (path->body.empty()) {
        note(path->file + " does not say whose pose it is: taken as the " + wanted +
             "'s (--truth-frame, --estimate-frame)");
      } else if (path->body == "camera" && wanted == "robot") {
        const auto [calibration, from] = find_calibration(*path);
        path->trajectory = in_other_frame(path->trajectory, calibration.T_robot_camera.inverse());
        note(label(*path) + " speaks of the camera: converted to the robot, with T_robot_camera of " + from);
      } else {
        throw std::runtime_error(label(*path) + " speaks of the frame '" + path->body +
                                 "', which cannot be brought to '" + wanted + "'");
      }
      path->body = wanted;
    }
  }

  /// And where it is from.
  std::pair<RgbdCalibration, std::string> find_calibration(const EvaluatedPath& path) {
    const std::string& given = request_.calibration;
    if (!given.empty() && !is_log(given)) return {load_calibration(given), given};
    if (!given.empty() && !log(given).calibration())
      throw std::runtime_error(given + ": has no CAMERA_CALIBRATION");
    if (!given.empty()) return {*log(given).calibration(), given + ":CAMERA_CALIBRATION"};
    if (const auto own = logs_.find(path.file); own != logs_.end() && own->second.calibration())
      return {*own->second.calibration(), path.file + ":CAMERA_CALIBRATION"};
    for (const auto& [file, log] : logs_)
      if (log.calibration()) return {*log.calibration(), file + ":CAMERA_CALIBRATION"};
    throw std::runtime_error(label(path) +
                             " speaks of the camera and others of the robot: no log here has a "
                             "CAMERA_CALIBRATION that says where the camera is; --calibration names a log or "
                             "a calibration file that does");
  }

  /// Poses that are the truth's own to the last digits that a text file has were copied from it.
  void compare_with_truth(EvaluatedPath& estimate) const {
    constexpr double same = 1e-8;
    if (!estimate.truth_origin.empty()) return;
    for (const StampedPose& pose : estimate.trajectory) {
      const auto truth = pose_at(inputs_.truth.trajectory, pose.utime, 0);
      if (!truth || !truth->isApprox(pose.T_world_body, same)) return;
    }
    estimate.truth_origin = "its poses are the truth's";
  }

  std::vector<EvaluatedPath*> all() {
    std::vector<EvaluatedPath*> paths = {&inputs_.truth};
    for (EvaluatedPath& e : inputs_.estimates) paths.push_back(&e);
    return paths;
  }
  static std::string label(const EvaluatedPath& path) {
    return path.channel.empty() ? path.file : path.file + ":" + path.channel;
  }
  void note(const std::string& text) { inputs_.notes.push_back(text); }

  const InputRequest& request_;
  EvaluationInputs inputs_;
  std::map<std::string, PoseLog> logs_;
};

}  // namespace

FileChannel split_channel(const std::string& text) {
  const std::size_t colon = text.rfind(':');
  if (colon == std::string::npos || std::filesystem::exists(text)) return {text, ""};
  return {text.substr(0, colon), text.substr(colon + 1)};
}

EvaluationInputs read_inputs(const InputRequest& request) {
  return InputReader(request).read();
}

}  // namespace lcmslam
