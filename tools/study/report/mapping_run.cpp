#include "tools/study/report/mapping_run.hpp"

#include <Eigen/SVD>
#include <algorithm>
#include <atomic>
#include <cmath>
#include <mutex>
#include <set>
#include <thread>

#include <lcmslam/configuration/share.hpp>
#include <lcmslam/graph_t.hpp>
#include <lcmslam/icp_report_t.hpp>
#include <lcmslam/images_t.hpp>
#include <lcmslam/imaging/io/codec.hpp>
#include <lcmslam/keyframe_t.hpp>
#include <lcmslam/landmarks_t.hpp>
#include <lcmslam/map_store/dense_map.hpp>
#include <lcmslam/messages/camera_messages.hpp>
#include <lcmslam/messages/decode.hpp>
#include <lcmslam/messages/followed_graph.hpp>
#include <lcmslam/messages/map_messages.hpp>
#include <lcmslam/runtime/options.hpp>
#include "tools/evaluate/pose_log.hpp"

namespace lcmslam {
namespace {

/// What the mappers say, as it comes.
class RunListener {
 public:
  explicit RunListener(MappingRun& run) : run_(run) {}

  void take(const BatchMessage& m) {
    poses_.add(m.channel, m.bytes.data(), m.bytes.size());
    believed_.hear(m.channel, m.bytes);
    if (m.channel == "FASTSLAM_LANDMARKS") {
      const auto tile = decode_message<landmarks_t>(m.bytes.data(), m.bytes.size());
      for (const std::int64_t id : tile.removed) landmarks_.erase(id);
      for (const Landmark& l : landmarks_of(tile)) landmarks_[l.id] = l;
      run_.map_bytes["fastslam"] += static_cast<std::int64_t>(m.bytes.size());
    } else if (m.channel == "FASTSLAM_ASSOCIATIONS") {
      run_.associations.push_back(decode_message<associations_t>(m.bytes.data(), m.bytes.size()));
      run_.landmark_counts.push_back(static_cast<int>(landmarks_.size()));
    } else if (m.channel == "ICP_REPORT") {
      const auto report = decode_message<icp_report_t>(m.bytes.data(), m.bytes.size());
      if (report.n_iterations == 0) return;
      run_.iterations.push_back(report.n_iterations);
      run_.residuals.push_back(static_cast<double>(report.rms.back()));
    } else if (m.channel == "ICP_KEYFRAME") {
      cloud_.add(from_message(decode_message<keyframe_t>(m.bytes.data(), m.bytes.size())));
      run_.map_bytes["icp"] += static_cast<std::int64_t>(m.bytes.size());
    } else if (m.channel == "ICP_GRAPH") {
      const auto graph = decode_message<graph_t>(m.bytes.data(), m.bytes.size());
      graph_.apply(graph);
      follow(cloud_, graph_, graph);
      run_.map_bytes["icp"] += static_cast<std::int64_t>(m.bytes.size());
    }
  }

  void finish() {
    poses_.finish();
    run_.odometry = path("ODOMETRY");
    run_.fastslam = path("FASTSLAM_POSE");
    run_.smoothed = path("FASTSLAM_SMOOTHED");
    run_.icp = path("ICP_POSE");
    run_.icp_final = path("ICP_FINAL");
    std::map<std::string, BelievedPath> believed = believed_.paths();
    run_.fastslam_believed = std::move(believed["FASTSLAM_POSE"]);
    run_.icp_believed = std::move(believed["ICP_POSE"]);
    run_.fastslam_lost = lost("FASTSLAM_POSE");
    run_.icp_lost = lost("ICP_POSE");
    run_.fastslam_restarts = restarts("FASTSLAM_POSE");
    run_.icp_restarts = restarts("ICP_POSE");
    if (run_.fastslam_restarts > 0)
      run_.fastslam = run_.smoothed = {};
    else
      for (const auto& [id, landmark] : landmarks_) run_.landmarks.push_back(landmark);
    if (run_.icp_restarts > 0)
      run_.icp = run_.icp_final = {};
    else
      for (const auto& [id, keyframe] : cloud_.keyframes()) add(keyframe);
  }

 private:
  Trajectory path(const std::string& channel) const {
    const auto found = poses_.channels().find(channel);
    return found == poses_.channels().end() ? Trajectory() : found->second.trajectory;
  }
  int lost(const std::string& channel) const {
    const auto found = poses_.channels().find(channel);
    return found == poses_.channels().end() ? 0 : found->second.lost + found->second.earlier_lost;
  }
  int restarts(const std::string& channel) const {
    const auto found = poses_.channels().find(channel);
    return found == poses_.channels().end() ? 0 : found->second.restarts;
  }
  void add(const DenseKeyframe& keyframe) {
    const Eigen::Isometry3f T = keyframe.T_world_camera.cast<float>();
    const ColouredCloud& cloud = keyframe.cloud;
    const Eigen::Vector3f unknown = Eigen::Vector3f::Constant(std::nanf(""));
    for (std::size_t i = 0; i < cloud.size(); ++i) {
      run_.cloud.points.push_back(T * cloud.points[i]);
      run_.cloud.normals.push_back(cloud.normals.empty() ? unknown
                                                         : Eigen::Vector3f(T.linear() * cloud.normals[i]));
      run_.cloud.colours.push_back(cloud.colours[i]);
    }
  }

  MappingRun& run_;
  PoseLog poses_;
  BelievedPoses believed_;
  DenseMap cloud_;
  FollowedGraph graph_;
  std::map<std::int64_t, Landmark> landmarks_;
};

std::vector<std::string> overrides_of(const MapperChoice& choice) {
  const std::string seed = std::to_string(choice.seed);
  std::vector<std::string> all = {"fastslam.seed=" + seed, "odometry.seed=" + seed,
                                  "odometry.noise.seed=" + seed, "odometry.source=" + choice.odometry};
  all.insert(all.end(), choice.set.begin(), choice.set.end());
  return all;
}

using CellKey = std::array<int, 3>;
CellKey cell_of(const Eigen::Vector3d& p) {
  const Eigen::Vector3d c = (p / SeenSurface::side).array().floor();
  return {static_cast<int>(c.x()), static_cast<int>(c.y()), static_cast<int>(c.z())};
}

}  // namespace

MappingRun map_drive(const Drive& drive, const MapperChoice& choice) {
  const std::string file = choice.preset == "thesis" ? "config/thesis.yaml" : "config/replay.yaml";
  std::vector<std::string> processes = {"odometry"};
  if (choice.preset == "thesis") processes.emplace_back("surf");  // its features are others than the drive's
  if (choice.fastslam) processes.emplace_back("fastslam");
  if (choice.icp) processes.emplace_back("icp");
  MappingRun run;
  RunListener listener(run);
  BatchGraph graph(load_config(share_path(file).string(), overrides_of(choice)), processes, 1,
                   [&](const BatchMessage& m) { listener.take(m); });
  for (const BatchMessage& message : drive.messages)
    if (graph.is_input(message.channel)) graph.deliver(message);
  graph.finish();
  listener.finish();
  run.icp_megabytes = std::nan("");
  for (const auto& process : graph.summary()) {
    run.cpu_seconds[process.process] = process.cpu_seconds;
    for (const auto& [name, value] : process.report.values)
      if (process.process == "icp" && name == "memory_mb") run.icp_megabytes = value;
  }
  return run;
}

void run_side_by_side(std::size_t count, const std::function<void(std::size_t)>& f) {
  std::atomic<std::size_t> next = 0;
  std::exception_ptr failure;
  std::mutex mutex;
  const auto work = [&] {
    for (std::size_t i = next++; i < count; i = next++) try {
        f(i);
      } catch (...) {
        const std::lock_guard<std::mutex> lock(mutex);
        failure = std::current_exception();
      }
  };
  std::thread other(work);
  work();
  other.join();
  if (failure) std::rethrow_exception(failure);
}

double path_error(const Trajectory& truth, const Trajectory& path) {
  constexpr std::size_t fewest = 3;
  if (path.size() < fewest || truth.empty()) return std::nan("");
  if (2 * (path.back().utime - path.front().utime) < truth.back().utime - truth.front().utime)
    return std::nan("");
  EvaluationSettings settings;
  settings.association = Association::interpolate_truth;
  try {
    return evaluate(truth, path, settings).absolute.translation.rmse;
  } catch (const std::invalid_argument&) {
    return std::nan("");
  }
}

Eigen::Isometry3d fit_to_truth(const Trajectory& truth, const Trajectory& path) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  Eigen::Matrix3d rotations = Eigen::Matrix3d::Zero();
  Eigen::Vector3d there = Eigen::Vector3d::Zero(), here = Eigen::Vector3d::Zero();
  double count = 0;
  for (const StampedPose& pose : path) {
    const auto T_world_robot = pose_at(truth, pose.utime);
    if (!T_world_robot) continue;
    rotations += T_world_robot->linear() * pose.T_world_body.linear().transpose();
    there += T_world_robot->translation();
    here += pose.T_world_body.translation();
    count += 1;
  }
  if (count == 0) return T;
  // The nearest rotation to the sum: the chordal mean (Hartley et al. 2013).
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(rotations, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const Eigen::Matrix3d UV = svd.matrixU() * svd.matrixV().transpose();
  T.linear() =
      svd.matrixU() * Eigen::Vector3d(1, 1, UV.determinant()).asDiagonal() * svd.matrixV().transpose();
  T.translation() = (there - T.linear() * here) / count;
  return T;
}

std::vector<double> surface_distances(const Drive& drive, const Eigen::Isometry3d& T_world_map,
                                      const std::vector<Eigen::Vector3d>& points, std::size_t most) {
  std::vector<double> distances;
  const std::size_t step = 1 + points.size() / most;
  for (std::size_t i = 0; i < points.size(); i += step)
    if (points[i].allFinite()) distances.push_back(drive.distance_to_surface(T_world_map * points[i]));
  std::sort(distances.begin(), distances.end());
  return distances;
}

std::vector<Eigen::Vector3d> places_of(const std::vector<Landmark>& landmarks) {
  std::vector<Eigen::Vector3d> places;
  places.reserve(landmarks.size());
  for (const Landmark& landmark : landmarks) places.push_back(landmark.mean);
  return places;
}

std::vector<Eigen::Vector3d> places_of(const ColouredCloud& cloud) {
  std::vector<Eigen::Vector3d> places;
  for (const Eigen::Vector3f& point : cloud.points) places.emplace_back(point.cast<double>());
  return places;
}

SeenSurface seen_surface(const Drive& drive) {
  constexpr int every_image = 5, every_pixel = 3;
  std::map<CellKey, std::pair<Eigen::Vector3d, int>> cells;
  const RgbdCalibration& c = drive.calibration;
  int number = 0;
  for (const BatchMessage& message : drive.messages) {
    if (message.channel != "CAMERA" || number++ % every_image != 0) continue;
    const EncodedFrame frame =
        from_message(decode_message<images_t>(message.bytes.data(), message.bytes.size()));
    const auto T_world_robot = pose_at(drive.truth, c.depth_time(frame.depth.utime));
    if (!T_world_robot) continue;
    const Eigen::Isometry3d T = *T_world_robot * c.T_robot_camera * c.T_colour_depth;
    const cv::Mat depth = decode_depth(frame.depth);
    for (int v = 0; v < depth.rows; v += every_pixel)
      for (int u = 0; u < depth.cols; u += every_pixel) {
        const double z = 1e-3 * depth.at<std::uint16_t>(v, u);
        if (z < c.depth_min || z > c.depth_max) continue;
        const Eigen::Vector3d p = T * (z * c.depth.ray({static_cast<double>(u), static_cast<double>(v)}));
        auto& [sum, count] = cells.try_emplace(cell_of(p), Eigen::Vector3d::Zero(), 0).first->second;
        sum += p;
        ++count;
      }
  }
  constexpr int fewest = 3;  // fewer are mixed pixels, in the air
  SeenSurface seen;
  for (const auto& [key, cell] : cells)
    if (cell.second >= fewest) seen.cells.emplace_back(cell.first / cell.second);
  return seen;
}

double coverage(const SeenSurface& seen, const Eigen::Isometry3d& T_world_map,
                const std::vector<Eigen::Vector3d>& points) {
  std::map<CellKey, std::vector<Eigen::Vector3d>> cells;
  for (const Eigen::Vector3d& point : points) {
    const Eigen::Vector3d p = T_world_map * point;
    if (!p.allFinite()) continue;
    auto& cell = cells[cell_of(p)];
    if (cell.size() < 8) cell.push_back(p);
  }
  const auto is_covered = [&](const Eigen::Vector3d& p) {
    const CellKey at = cell_of(p);
    for (int i = 0; i < 27; ++i) {
      const auto cell = cells.find({at[0] + i % 3 - 1, at[1] + i / 3 % 3 - 1, at[2] + i / 9 - 1});
      if (cell == cells.end()) continue;
      for (const Eigen::Vector3d& q : cell->second)
        if ((p - q).norm() < SeenSurface::side) return true;
    }
    return false;
  };
  const auto covered = std::count_if(seen.cells.begin(), seen.cells.end(), is_covered);
  return static_cast<double>(covered) / static_cast<double>(std::max<std::size_t>(1, seen.cells.size()));
}

}  // namespace lcmslam
