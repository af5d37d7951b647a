#include "tools/evaluate/export_poses.hpp"

#include <fmt/format.h>
#include <iostream>

#include <lcmslam/evaluation/pose_text.hpp>
#include "tools/evaluate/pose_omissions.hpp"

namespace lcmslam {
namespace {

struct ExportedPoses {
  Trajectory trajectory;
  PoseFrames frames;
};

ExportedPoses read_poses(const std::string& estimate) {
  const auto [file, channel] = split_channel(estimate);
  if (!is_log(file)) {
    PoseText text = read_pose_text(file);
    return {std::move(text.trajectory), {text.frame, text.body}};
  }
  if (channel.empty())
    throw std::runtime_error("--export: name the channel, " + file + ":ICP_POSE for example");
  const PoseLog log = read_pose_log(file);
  const PoseChannel& path = log.channel(channel, file);
  for (const std::string& omission : omissions(log, file)) std::cout << omission << "\n";
  for (const std::string& omission : omissions(path, estimate)) std::cout << omission << "\n";
  return {path.trajectory, {path.frame, path.body}};
}

}  // namespace

void export_poses(const InputRequest& request, const std::string& file, bool kitti) {
  if (request.estimates.size() != 1 || !request.truth.empty())
    throw std::runtime_error(
        "--export: give one FILE or LOG:CHANNEL whose poses are to be written, no --truth");
  const std::string& estimate = request.estimates[0];
  auto [trajectory, frames] = read_poses(estimate);
  if (trajectory.empty()) throw std::runtime_error(estimate + ": has no poses");
  if (!request.estimate_body.empty()) {
    if (!frames.body.empty() && frames.body != request.estimate_body)
      std::cout << fmt::format(
          "{} says that its poses are the {}'s; by --estimate-frame they are the {}'s, "
          "and nothing is converted\n",
          estimate, frames.body, request.estimate_body);
    frames.body = request.estimate_body;
  }
  if (kitti)
    save_kitti(file, trajectory);
  else
    save_tum(file, trajectory, frames);
  const auto named = [](const std::string& name) { return name.empty() ? std::string("unknown") : name; };
  std::cout << fmt::format("{}: {} poses, body: {}, frame: {}\n", file, trajectory.size(), named(frames.body),
                           named(frames.frame));
}

}  // namespace lcmslam
