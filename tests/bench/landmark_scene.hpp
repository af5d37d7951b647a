#pragma once
// Scenes whose cost is measured: landmarks of known identity along a wall, of which a robot sees a few in
// each step, and a building of rooms full of landmarks that are known by their descriptors.

#include <algorithm>
#include <cmath>
#include <fstream>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "tests/unit/fastslam/synthetic_world.hpp"

namespace lcmslam::synthetic {

struct SceneStep {
  Motion motion;
  FeatureFrame frame;
};

/// A wall along which a robot drives up and down, facing it: landmark i stands at 0.1 i metres, 1.5 to 3.5 m
/// away. Each frame shows `seen` neighbours as 3-D points, with noise and known identity.
class Wall {
 public:
  Wall(int landmarks, int seen) : random_(7), seen_(std::min(seen, landmarks)) {
    for (int i = 0; i < landmarks; ++i)
      points_.emplace_back(0.1 * i, random_.uniform(1.5, 3.5), random_.uniform(0.3, 2.3));
  }

  /// Steps that show the whole wall once.
  int lap() const { return (static_cast<int>(points_.size()) + seen_ - 1) / seen_; }
  /// `stride`: landmarks from one step to the next, in the direction of travel.
  SceneStep next(int stride) {
    const int last = static_cast<int>(points_.size()) - seen_;
    const int before = first_;
    if (time_ > 0) first_ = std::clamp(first_ + (forth_ ? stride : -stride), 0, last);
    if (first_ == (forth_ ? last : 0)) forth_ = !forth_;
    SceneStep step;
    step.frame.width = 640;
    step.frame.height = 480;
    step.frame.fx = step.frame.fy = 554;
    step.frame.cx = 320;
    step.frame.cy = 240;
    step.frame.has_mount = true;
    step.frame.T_robot_camera = Eigen::Translation3d(0.1, 0, 1.3) * optical_axes();
    step.frame.utime = 1'000'000 + 33'333 * time_++;
    const Eigen::Isometry3d noise =
        planar_pose(random_.normal(0, 0.003), random_.normal(0, 0.003), random_.normal(0, 0.002));
    step.motion.T_from_to = pose(before).inverse() * pose(first_) * noise;
    step.motion.covariance.diagonal() << 9e-6, 9e-6, 9e-6, 4e-6, 4e-6, 4e-6;
    for (int i = first_; i < first_ + seen_; ++i) add(i, step.frame);
    return step;
  }

 private:
  Eigen::Isometry3d pose(int first) const { return planar_pose(0.1 * (first + 0.5 * seen_), 0, M_PI / 2); }

  void add(int i, FeatureFrame& frame) {
    const Eigen::Vector3d p =
        (pose(first_) * frame.T_robot_camera).inverse() * points_[static_cast<std::size_t>(i)];
    Feature f;
    f.kind = MeasurementKind::point;
    f.landmark_id = i;
    f.x = static_cast<float>(frame.fx * p.x() / p.z() + frame.cx);
    f.y = static_cast<float>(frame.fy * p.y() / p.z() + frame.cy);
    const double sigma = 0.01;
    f.point =
        (p + sigma * Eigen::Vector3d(random_.normal(), random_.normal(), random_.normal())).cast<float>();
    f.depth_sigma = static_cast<float>(sigma);
    frame.features.push_back(f);
  }

  Random random_;
  int seen_;
  std::vector<Eigen::Vector3d> points_;
  int first_ = 0;  // landmark in view
  bool forth_ = true;
  std::int64_t time_ = 0;
};

/// Landmarks and robot path as MRPT's simul-landmarks writes them beside its rawlog; empty without the files.
class MrptScene {
 public:
  MrptScene(const std::string& rawlog, double view_degrees) : view_(0.5 * view_degrees * M_PI / 180) {
    std::ifstream landmarks(rawlog + "_ground_truth.txt"), path(rawlog + "_ground_truth_robot_path.txt");
    for (const auto& row : numbers(landmarks, 7))
      points_.push_back({static_cast<int>(row[6]), {row[0], row[1], row[2]}});
    for (const auto& row : numbers(path, 6)) path_.push_back(planar_pose(row[0], row[1], row[3]));
    if (points_.empty()) path_.clear();
  }

  std::size_t size() const { return path_.size(); }

  SceneStep step(std::size_t i) {
    SceneStep step;
    FeatureFrame& frame = step.frame;
    frame.width = frame.height = 1;
    frame.fx = frame.fy = 573;
    frame.pixel_sigma = 1;  // 0.1 degrees
    frame.has_mount = true;
    frame.utime = 1'000'000 + 33'333 * static_cast<Utime>(i);
    if (i > 0)
      step.motion.T_from_to =
          path_[i - 1].inverse() * path_[i] *
          planar_pose(random_.normal(0, 0.003), random_.normal(0, 0.003), random_.normal(0, 0.002));
    step.motion.covariance.diagonal() << 9e-6, 9e-6, 9e-6, 4e-6, 4e-6, 4e-6;
    const Eigen::Isometry3d T_camera_world = (path_[i] * frame.T_robot_camera).inverse();
    for (const auto& [id, position] : points_) {
      const Eigen::Vector3d p = T_camera_world * position;
      if (!(p.z() > 0) || std::abs(std::atan2(p.x(), p.z())) > view_) continue;
      Feature f;
      f.kind = MeasurementKind::point;
      f.landmark_id = id;
      f.depth_sigma = 0.01F;
      const Eigen::Vector3d across(random_.normal(), random_.normal(), 0);
      f.point = ((p + p.z() / frame.fx * across) * (1 + 0.01 * random_.normal() / p.norm())).cast<float>();
      if (f.point.z() > 0) frame.features.push_back(f);
    }
    return step;
  }

 private:
  static std::vector<std::vector<double>> numbers(std::istream& in, std::size_t columns) {
    std::vector<std::vector<double>> rows;
    for (std::string line; std::getline(in, line);) {
      if (line.empty() || line[0] == '%') continue;
      std::istringstream text(line);
      std::vector<double> row;
      for (double x = 0; text >> x;) row.push_back(x);
      if (row.size() >= columns) rows.push_back(row);
    }
    return rows;
  }

  Random random_{3};
  double view_;
  std::vector<std::pair<int, Eigen::Vector3d>> points_;
  std::vector<Eigen::Isometry3d> path_;
};

/// Rooms of 6.4 x 5.2 m wall to wall, each full of landmarks. The robot turns once in the middle of a room,
/// then goes on to the next. `offered` features a frame, of which a share is invented or mistaken.
class Building {
 public:
  Building(int columns, int rows, int landmarks_a_room, std::size_t offered, std::uint64_t seed)
      : random_(seed), columns_(columns), rooms_(columns * rows), offered_(offered) {
    world_.landmarks = landmarks_a_room;
    for (int i = 0; i < rooms_; ++i) {
      points_.push_back(make_points(world_, random_));
      for (Point& p : points_.back()) p.position += origin(i);
    }
  }

  SceneStep next() {
    SceneStep step;
    const Eigen::Isometry3d T = pose(time_);
    if (time_ > 0) {
      step.motion.T_from_to =
          pose(time_ - 1).inverse() * T *
          planar_pose(random_.normal(0, 0.003), random_.normal(0, 0.003), random_.normal(0, 0.002));
      step.motion.covariance.diagonal() << 9e-6, 9e-6, 9e-6, 4e-6, 4e-6, 4e-6;
    }
    std::vector<int> truth;
    step.frame = see(world_, points_[static_cast<std::size_t>(room(time_))], T, random_, truth);
    auto& features = step.frame.features;
    for (std::size_t i = features.size(); i > 1; --i) std::swap(features[i - 1], features[random_.below(i)]);
    if (features.size() > offered_) features.resize(offered_);
    step.frame.utime = 1'000'000 + 33'333 * time_;
    step.frame.seq = time_++;
    return step;
  }

 private:
  static constexpr int kStepsARoom = 60;

  Eigen::Vector3d origin(int room) const { return {6.4 * (room % columns_), 5.2 * (room / columns_), 0}; }
  int room(std::int64_t time) const { return static_cast<int>(time / kStepsARoom) % rooms_; }
  Eigen::Isometry3d pose(std::int64_t time) const {
    const Eigen::Vector3d at = origin(room(time));
    return planar_pose(at.x(), at.y(), 2 * M_PI * static_cast<double>(time % kStepsARoom) / kStepsARoom);
  }

  Random random_;
  int columns_, rooms_;
  std::size_t offered_;
  WorldSettings world_;
  std::vector<std::vector<Point>> points_;
  std::int64_t time_ = 0;
};

}  // namespace lcmslam::synthetic
