// Each metric with each solver that minimises it, each correspondence, and by turns each kernel, selection
// and rejection, through one check on recorded pairs.

#include <gtest/gtest.h>

#include <algorithm>

#include <lcmslam/registration/preparation.hpp>
#include <lcmslam/registration/registration.hpp>
#include "tests/support/recorded_clouds.hpp"
#include "tests/support/recordings.hpp"
#include "tests/support/targets.hpp"

namespace lcmslam {
namespace {

struct Parts {
  std::string name;
  RegistrationSettings settings;
  CorrespondenceKind correspondence;
};

void PrintTo(const Parts& parts, std::ostream* out) {
  *out << parts.name;
}

std::string letters(std::string text) {
  for (char& c : text)
    if (!std::isalnum(static_cast<unsigned char>(c))) c = '_';
  return text;
}

std::vector<Parts> all_parts() {
  const SolverKind iterative[] = {SolverKind::gauss_newton, SolverKind::levenberg_marquardt};
  const SolverKind closed[] = {SolverKind::svd, SolverKind::svd_uncorrected, SolverKind::quaternion,
                               SolverKind::small_angle, SolverKind::small_angle_as_printed};
  std::vector<std::pair<MetricKind, SolverKind>> minimised;
  for (const auto metric :
       {MetricKind::point_to_point, MetricKind::point_to_plane, MetricKind::plane_to_plane})
    for (const auto solver : iterative) minimised.emplace_back(metric, solver);
  for (const auto solver : closed) minimised.emplace_back(MetricKind::point_to_point, solver);

  std::vector<Parts> all;
  int k = 0;
  for (const auto& [metric, solver] : minimised)
    for (const auto correspondence : {CorrespondenceKind::kd_tree, CorrespondenceKind::projective,
                                      CorrespondenceKind::normal_shooting, CorrespondenceKind::voxel_map}) {
      Parts parts;
      RegistrationSettings& s = parts.settings;
      s.metric = metric;
      s.solver = solver;
      s.kernel = static_cast<KernelKind>(k % 3);
      // stable balances the planes' constraints, which says nothing about points.
      s.selection = static_cast<SelectionKind>(k % (metric == MetricKind::point_to_point ? 4 : 5));
      s.selected_points = 1500;
      const int rejection = k % 4;  // next to the adaptive distance and the normals' angle
      s.mutual = rejection == 1;
      s.boundary = rejection == 2;
      s.trimmed_fraction = rejection == 3 ? 0.9 : 1;
      s.max_iterations = 60;
      if (metric == MetricKind::point_to_point) {  // slides slowly along surfaces
        s.weigh_by_noise = false;
        s.max_iterations = 200;
        s.epsilon_translation = 2e-5;
        s.epsilon_rotation = 1e-5;
      }
      parts.correspondence = correspondence;
      parts.name = letters(to_string(metric) + "_" + to_string(solver) + "_" + to_string(correspondence));
      all.push_back(parts);
      ++k;
    }
  return all;
}

class EveryPart : public testing::TestWithParam<Parts> {
 protected:
  // Forward, inverse and from shifted starts.
  void check(const RecordedPair& pair, const RegistrationSettings& settings, double shift, double turn,
             double metres, double degrees) const {
    if (settings.metric == MetricKind::point_to_point) metres *= 1.5, degrees *= 1.5;  // it slides
    const auto target_of = [&](const Cloud& cloud) {
      return make_target(prepared_target(cloud, settings, Eigen::Vector3d::Zero()),
                         GetParam().correspondence);
    };
    const auto target = target_of(pair.target), source_as_target = target_of(pair.source);
    const Eigen::Isometry3d& T = pair.T_target_source;
    for (const double sign : {-1.0, 0.0, 1.0}) {
      const Eigen::Isometry3d start =
          T * se3_exp(sign * twist(shift, -shift / 2, shift / 2, turn / 2, turn, -turn / 2));
      expect_right(register_cloud(pair.source, *target, start, settings), T, metres, degrees);
      expect_right(register_cloud(pair.target, *source_as_target, start.inverse(), settings), T.inverse(),
                   metres, degrees);
    }
  }

  static void expect_right(const RegistrationResult& result, const Eigen::Isometry3d& truth, double metres,
                           double degrees) {
    EXPECT_TRUE(result.ok()) << to_string(result.stop);
    const Eigen::Isometry3d e = truth.inverse() * result.T_target_source;
    EXPECT_LT(e.translation().norm(), metres);
    EXPECT_LT(rotation_angle(e) * 180 / 3.14159265, degrees);
    EXPECT_GT(result.overlap, 0.2);
    EXPECT_GT(result.inliers, 0);
    EXPECT_FALSE(result.rms.empty());
    EXPECT_TRUE(result.covariance.allFinite());
    EXPECT_GT(result.covariance.determinant(), 0);
  }
};
INSTANTIATE_TEST_SUITE_P(Parts, EveryPart, testing::ValuesIn(all_parts()),
                         [](const auto& test) { return test.param.name; });

// A LiDAR's full circle does not fit a pinhole image, and the map's voxels are those of a room.
std::vector<Parts> parts_for_lidar() {
  std::vector<Parts> parts = all_parts();
  parts.erase(std::remove_if(parts.begin(), parts.end(),
                             [](const Parts& p) {
                               return p.correspondence == CorrespondenceKind::projective ||
                                      p.correspondence == CorrespondenceKind::voxel_map;
                             }),
              parts.end());
  return parts;
}
class EveryLidarPart : public EveryPart {};
INSTANTIATE_TEST_SUITE_P(Parts, EveryLidarPart, testing::ValuesIn(parts_for_lidar()),
                         [](const auto& test) { return test.param.name; });

TEST_P(EveryLidarPart, OutdoorLidarPair) {
  static const auto pair = lidar_pair();
  LCMSLAM_SKIP_WITHOUT("registration/small_gicp");
  ASSERT_TRUE(pair);
  RegistrationSettings settings = GetParam().settings;
  settings.max_distance = 2;
  settings.min_distance = 0.8;
  settings.noise_floor = 0.05;
  check(*pair, settings, 0.2, 0.02, 0.15, 1.2);
}

TEST_P(EveryPart, HandHeldPair) {
  static const auto pair = []() -> std::optional<RecordedPair> {
    const auto recording = Fr1Recording::open();
    if (!recording) return std::nullopt;
    return RecordedPair{voxel_filtered(geometry_of(recording->cloud(503)), 0.05),
                        voxel_filtered(geometry_of(recording->cloud(500)), 0.03),
                        recording->T_world_camera(500).inverse() * recording->T_world_camera(503)};
  }();
  LCMSLAM_SKIP_WITHOUT("tum_fr1_rpy");
  ASSERT_TRUE(pair);
  check(*pair, GetParam().settings, 0.03, 0.03, 0.05, 2.0);
}

TEST_P(EveryPart, WideBaselinePair) {
  static const auto pair = slambook2_pair();
  LCMSLAM_SKIP_WITHOUT("rgbd_slambook2");
  ASSERT_TRUE(pair);
  check(*pair, GetParam().settings, 0.03, 0.02, 0.10, 3.0);
}

}  // namespace
}  // namespace lcmslam
