#include "procs/map-server/page/message_items.hpp"

#include <algorithm>
#include <cmath>

#include <lcmslam/imaging/io/codec.hpp>
#include <lcmslam/messages/geometry_messages.hpp>

namespace lcmslam {
namespace {

using nlohmann::json;

constexpr int page_quality = 80;  // of JPEGs that are made for the page

json row(const Eigen::Vector3d& v) {
  return {rounded_for_page(v.x()), rounded_for_page(v.y()), rounded_for_page(v.z())};
}

/// Standard deviations of a pose's error, x y z roll pitch yaw in the body's frame.
json sigmas(const double (&covariance)[36]) {
  json values = json::array();
  for (std::size_t i = 0; i < 6; ++i) values.push_back(rounded_for_page(std::sqrt(covariance[7 * i])));
  return values;
}

}  // namespace

json page_pose(const Eigen::Isometry3d& T) {
  const Eigen::Quaterniond q(T.linear());
  json values = row(T.translation());
  for (const double value : {q.w(), q.x(), q.y(), q.z()}) values.push_back(rounded_for_page(value));
  return values;
}

const char* page_status(int status) {
  switch (status) {
    case pose_estimate_t::TRACKING:
      return "TRACKING";
    case pose_estimate_t::DEGRADED:
      return "DEGRADED";
    case pose_estimate_t::LOST:
      return "LOST";
    case pose_estimate_t::RELOCALISED:
      return "RELOCALISED";
    default:
      return "INITIALISING";
  }
}

json pose_member(const pose_estimate_t& pose) {
  return {{"T", page_pose(from_message(pose.T_map_robot, "T_map_robot"))},
          {"status", page_status(pose.status)},
          {"quality", rounded_for_page(pose.quality)},
          {"inliers", pose.inliers},
          {"detail", pose.detail},
          {"sigma", sigmas(pose.covariance)}};
}

json pose_member(const odometry_t& odometry, const Eigen::Isometry3d& T_map_robot) {
  return {{"T", page_pose(T_map_robot)},
          {"status", page_status(odometry.status)},
          {"quality", rounded_for_page(odometry.quality)},
          {"detail", odometry.source},
          {"sigma", sigmas(odometry.covariance)}};
}

PageItem particles_item(const particles_t& message) {
  PageItem item{"particles", ""};
  if (message.n_particles > 0 && (message.best < 0 || message.best >= message.n_particles))
    throw DecodeError("best: " + std::to_string(message.best) + " is none of the particles");
  item.header = {{"best", message.best},
                 {"effective", rounded_for_page(message.effective_sample_size)},
                 {"total", message.total}};
  for (const particle_t& particle : message.particles) {
    for (const float x : particle.trans) append_bytes(item.bytes, x);
    append_bytes(item.bytes, particle.weight);
  }
  return item;
}

PageItem report_item(const icp_report_t& message) {
  json rms = json::array();
  for (const float value : message.rms) rms.push_back(rounded_for_page(value));
  PageItem item{"report", ""};
  item.header = {{"utime", message.utime},
                 {"rms", std::move(rms)},
                 {"inliers", message.inliers},
                 {"overlap", rounded_for_page(message.overlap)},
                 {"stop", message.stop_text}};
  item.header["correction"] = {rounded_for_page(message.correction_trans),
                               rounded_for_page(message.correction_rot)};
  return item;
}

std::optional<PageItem> image_item(const EncodedFrame& frame, const associations_t* associations) {
  if (frame.colour.coding == ImageCoding::none) return std::nullopt;
  std::optional<EncodedImage> made;  // browsers know no raw images
  if (frame.colour.coding != ImageCoding::jpeg)
    made = encode_colour(decode_colour(frame.colour), frame.colour.utime, page_quality);
  const EncodedImage& colour = made ? *made : frame.colour;
  PageItem item{"image", ""};
  json tracks = json::array();
  if (associations != nullptr)
    for (const association_t& a : associations->associations)
      tracks.push_back({std::round(10 * a.x) / 10, std::round(10 * a.y) / 10, a.landmark, a.outcome});
  item.header = {{"utime", colour.utime}, {"width", colour.width}, {"height", colour.height}};
  item.header["tracks"] = std::move(tracks);
  item.bytes.assign(colour.bytes.begin(), colour.bytes.end());
  return item;
}

ProcessSaid process_said(const status_t& status, double age) {
  static const char* const states[] = {"starting", "running", "finished", "stopping", "failed"};
  ProcessSaid said{
      status.process,     status.state >= 0 && status.state < 5 ? states[status.state] : "unknown",
      status.detail,      age,
      status.cpu,         status.memory,
      status.latency_p50, status.latency_p95};
  for (const output_status_t& output : status.outputs) said.rate = std::max(said.rate, output.rate);
  for (const input_status_t& input : status.inputs) {
    said.lost += input.lost;
    said.unreadable += input.decode_errors;
    said.dropped += input.queue_drops;
  }
  said.kernel_drops = status.kernel_drops;
  return said;
}

}  // namespace lcmslam
