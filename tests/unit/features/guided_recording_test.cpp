// Guided matching on recorded images.

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>

#include <lcmslam/features/descriptor_search.hpp>
#include <lcmslam/features/guided_matching.hpp>
#include "tests/support/recorded_features.hpp"
#include "tests/support/recordings.hpp"
#include "tests/unit/features/guided_scene.hpp"

namespace lcmslam {
namespace {

using namespace test;

// Rendered images with known poses: every other view makes the map, those between query it.
struct RecordedRoom {
  std::vector<FeatureFrame> frames;
  std::vector<Eigen::Isometry3d> T_world_camera;

  RecordedRoom() {
    const auto folder = recording_path("livingroom1");
    std::ifstream log(folder / "test_scene" / "trajectory.log");
    std::vector<Eigen::Isometry3d> poses;
    for (int a, b, c; log >> a >> b >> c;) {
      Eigen::Matrix4d matrix;
      for (int k = 0; k < 16; ++k) log >> matrix(k / 4, k % 4);
      poses.emplace_back(matrix);
    }
    constexpr std::size_t step = 5;
    const auto features = recorded_features(folder / "image", step, 600);
    for (std::size_t i = 0; i < features.size() && step * i < poses.size(); ++i) {
      FeatureFrame frame = empty_frame();
      frame.fx = frame.fy = 525;
      char name[32];
      std::snprintf(name, sizeof name, "%05zu.png", step * i);
      const cv::Mat depth = cv::imread((folder / "depth" / name).string(), cv::IMREAD_UNCHANGED);
      for (Feature feature : features[i]) {
        const float z =
            float(depth.at<std::uint16_t>(int(std::lround(feature.y)), int(std::lround(feature.x)))) / 1e3f;
        if (z <= 0) continue;
        feature.kind = MeasurementKind::point;
        feature.point = {float(feature.x - frame.cx) / 525 * z, float(feature.y - frame.cy) / 525 * z, z};
        feature.depth_sigma = 0.01f;
        frame.features.push_back(feature);
      }
      frames.push_back(frame);
      T_world_camera.push_back(poses[step * i]);
    }
  }
};

TEST(GuidedMatching, FindsMoreInRecordedImagesToo) {
  LCMSLAM_SKIP_WITHOUT("livingroom1");
  const RecordedRoom room;
  ASSERT_GE(room.frames.size(), 40U);
  DescriptorIndex index;
  std::vector<MapPoint> landmarks;
  GuidedMatcher matcher;
  for (std::size_t i = 0; i < room.frames.size(); i += 2) {
    const FeatureFrame& frame = room.frames[i];
    const PredictedPose known{room.T_world_camera[i], diagonal(0.002, 0.001)};
    std::vector<bool> mapped(frame.features.size(), false);
    for (const Match& m : matcher.match(frame, known, landmarks, index).matches)
      mapped[std::size_t(m.a)] = true;
    for (std::size_t k = 0; k < frame.features.size(); ++k) {
      if (mapped[k]) continue;
      const Feature& f = frame.features[k];
      const Eigen::Matrix3d R = room.T_world_camera[i].linear();
      landmarks.push_back({int(landmarks.size()), room.T_world_camera[i] * f.point.cast<double>(),
                           R * point_covariance(f, frame) * R.transpose()});
      index.insert(landmarks.back().id, f.descriptor, f.laplacian);
    }
  }
  DescriptorSearch search;
  int guided = 0, guided_right = 0, plain = 0, plain_right = 0, views = 0, wrong_supported = 0;
  for (std::size_t i = 1; i < room.frames.size(); i += 2) {
    const FeatureFrame& frame = room.frames[i];
    const auto right = [&](const std::vector<Match>& matches) {
      int count = 0;
      for (const Match& m : matches) {
        const auto projection = project(landmarks[std::size_t(m.b)], room.T_world_camera[i], frame);
        const Feature& f = frame.features[std::size_t(m.a)];
        count += projection && (projection->pixel - Eigen::Vector2d(f.x, f.y)).norm() < 5;
      }
      return count;
    };
    Random random(i);
    PredictedPose predicted;
    predicted.covariance = diagonal(0.02, 0.01);
    predicted.T_world_camera = room.T_world_camera[i] * se3_exp(random_twist(random, 0.02, 0.01));
    const GuidedResult& found = matcher.match(frame, predicted, landmarks, index);
    EXPECT_TRUE(found.supported()) << "view " << i << ": " << found.matches.size() << " matches, "
                                   << found.by_chance << " by chance";
    guided += int(found.matches.size());
    guided_right += right(found.matches);
    const auto& whole = search.match(frame.features, index);
    plain += int(whole.size());
    plain_right += right(whole);
    predicted.T_world_camera = predicted.T_world_camera * se3_exp(0.4 * Vector6d::Unit(4));  // 23 degrees
    wrong_supported += matcher.match(frame, predicted, landmarks, index).supported();
    ++views;
  }
  std::printf(
      "[          ] %d views, %zu landmarks: guided %d of %d right, whole map %d of %d right; %d wrong "
      "predictions supported\n",
      views, landmarks.size(), guided_right, guided, plain_right, plain, wrong_supported);
  EXPECT_GT(guided_right, 1.15 * plain_right);
  EXPECT_GT(double(guided_right) / guided, double(plain_right) / plain - 0.01);
  EXPECT_EQ(wrong_supported, 0);
}

}  // namespace
}  // namespace lcmslam
