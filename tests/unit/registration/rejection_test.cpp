#include <lcmslam/registration/rejection.hpp>

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>

#include <lcmslam/registration/kd_tree_target.hpp>
#include <lcmslam/registration/preparation.hpp>
#include <lcmslam/registration/registration.hpp>
#include <lcmslam/rgbd/colour_overlap.hpp>
#include "tests/support/cloud_scenes.hpp"
#include "tests/support/vga_camera.hpp"

namespace lcmslam {
namespace {

const Eigen::Isometry3d identity = Eigen::Isometry3d::Identity();

Pair pair_of(std::size_t index, const Eigen::Vector3d& source, const Eigen::Vector3d& target) {
  Pair p;
  p.index = index;
  p.source = p.moved = source;
  p.target = target;
  return p;
}

TEST(Rejection, NormalAngle) {
  std::vector<Pair> pairs;
  for (const double angle : {0.0, 0.4, 0.6, 3.0, std::numeric_limits<double>::quiet_NaN()}) {
    Pair p;
    p.moved_normal = Eigen::Vector3d(std::cos(angle), std::sin(angle), 0);
    p.target_normal = Eigen::Vector3d::UnitX();
    pairs.push_back(p);
  }
  NormalAngleRejector(0.5).reject(pairs, Eigen::Isometry3d::Identity());
  ASSERT_EQ(pairs.size(), 3u);
  EXPECT_EQ(pairs[1].moved_normal.x(), std::cos(0.4));
  EXPECT_TRUE(std::isnan(pairs[2].moved_normal.x()));  // unknown normals pass
}

TEST(Rejection, TrimmedKeepsTheNearest) {
  std::vector<Pair> pairs;
  for (const double d : {5.0, 1.0, 4.0, 2.0, 3.0}) {
    Pair p;
    p.moved = Eigen::Vector3d(d, 0, 0);
    p.target.setZero();
    pairs.push_back(p);
  }
  TrimmedRejector(0.6).reject(pairs, Eigen::Isometry3d::Identity());
  ASSERT_EQ(pairs.size(), 3u);
  EXPECT_EQ(pairs[0].moved.x(), 1);
  EXPECT_EQ(pairs[1].moved.x(), 2);
  EXPECT_EQ(pairs[2].moved.x(), 3);
}

// A cloud that lies on itself, or a sensor that measures in steps.
TEST(Rejection, TrimmedKeepsOfEqualsTheFirst) {
  std::vector<Pair> pairs;
  for (std::size_t i = 0; i < 10; ++i) pairs.push_back(pair_of(i, {0, 0, 0}, {i % 2 == 0 ? 0.1 : 0, 0, 0}));
  TrimmedRejector(0.7).reject(pairs, Eigen::Isometry3d::Identity());
  std::vector<std::size_t> kept;
  for (const Pair& p : pairs) kept.push_back(p.index);
  EXPECT_EQ(kept, (std::vector<std::size_t>{0, 1, 2, 3, 5, 7, 9}));
  TrimmedRejector(0.2).reject(pairs, Eigen::Isometry3d::Identity());
  ASSERT_EQ(pairs.size(), 1U);
  EXPECT_EQ(pairs[0].index, 1U);
}

TEST(Rejection, PlanesNeedNormals) {
  std::vector<Pair> pairs(2);
  pairs[0].target_normal = Eigen::Vector3d::UnitX();
  pairs[1].target_normal.setConstant(std::numeric_limits<double>::quiet_NaN());
  MissingNormalRejector().reject(pairs, Eigen::Isometry3d::Identity());
  EXPECT_EQ(pairs.size(), 1u);
}

TEST(Rejection, MutualKeepsEachOthersNearest) {
  Cloud source;
  source.points = {{0, 0, 0}, {0.4f, 0, 0}, {5, 0, 0}};
  const Eigen::Isometry3d T(Eigen::Translation3d(0, 7, 0));  // both sets elsewhere
  std::vector<Pair> pairs = {pair_of(0, {0, 0, 0}, {0.5, 7, 0}), pair_of(1, {0.4, 0, 0}, {0.5, 7, 0}),
                             pair_of(2, {5, 0, 0}, {5.1, 7, 0})};
  MutualRejector(source).reject(pairs, T);
  ASSERT_EQ(pairs.size(), 2U);
  EXPECT_EQ(pairs[0].index, 1U);
  EXPECT_EQ(pairs[1].index, 2U);
}

TEST(Rejection, BoundaryOfAWall) {
  Cloud target = wall(0.05);
  mark_boundary(target);
  std::vector<Pair> pairs;
  int border = 0;
  for (std::size_t i = 0; i < target.size(); ++i) {
    const Eigen::Vector3d p = target.points[i].cast<double>();
    const bool outermost = std::abs(p.y()) > 1.49 || std::abs(p.z()) > 0.99;
    border += outermost ? 1 : 0;
    EXPECT_EQ(target.boundary[i] != 0, outermost) << p.transpose();
    pairs.push_back(pair_of(i, p, p));
    pairs.back().boundary = target.boundary[i] != 0;
  }
  BoundaryRejector().reject(pairs, identity);
  EXPECT_EQ(pairs.size(), target.size() - static_cast<std::size_t>(border));
}

// Two views of a wall that overlap by half: at the end of the target the pairs pull sideways.
TEST(Rejection, BoundaryFreesAViewThatReachesBeyondTheTarget) {
  Cloud target, source;
  add_rectangle(target, {2, -1, -1}, {0, 0, 2}, {0, 2, 0});
  add_rectangle(source, {2, 0, -1}, {0, 0, 2}, {0, 2, 0});
  RegistrationSettings s;
  s.metric = MetricKind::point_to_point;
  s.solver = SolverKind::svd;
  s.kernel = KernelKind::none;
  s.weigh_by_noise = false;
  s.distance_sigmas = 0;
  s.max_distance = 0.5;
  s.max_iterations = 1;
  const auto pull = [&] {
    const KdTreeTarget tree(prepared_target(target, s, Eigen::Vector3d::Zero()));
    return register_cloud(source, tree, identity, s).T_target_source.translation().y();
  };
  EXPECT_LT(pull(), -0.02);
  s.boundary = true;
  EXPECT_NEAR(pull(), 0, 1e-6);
}

TEST(Rejection, FrustumJudgesPointsWhereTheyHaveMoved) {
  const ViewFrustum frustum(vga_camera());
  const Eigen::Isometry3d T_camera_target(Eigen::Translation3d(0, 0, 1));
  std::vector<Pair> pairs = {pair_of(0, {0, 0, 1}, {0, 0, 1}), pair_of(1, {3, 0, 1}, {3, 0, 1}),
                             pair_of(2, {0, 0, -2}, {0, 0, -2})};
  FrustumRejector(frustum, T_camera_target).reject(pairs, identity);
  ASSERT_EQ(pairs.size(), 1U);
  EXPECT_EQ(pairs[0].index, 0U);
}

TEST(Rejection, ColourOverlapLeavesOutWhatTheTargetDoesNotShow) {
  Random random(2);
  cv::Mat world(480, 1000, CV_8UC1);
  for (auto& pixel : cv::Mat_<std::uint8_t>(world)) pixel = static_cast<std::uint8_t>(256 * random.uniform());
  cv::GaussianBlur(world, world, {}, 6);
  cv::normalize(world, world, 0, 255, cv::NORM_MINMAX);
  const ImageOverlap overlap = colour_overlap(world({320, 0, 640, 480}), world({0, 0, 640, 480}));
  const CameraModel c = vga_camera();
  Cloud source;
  source.points = {{-0.4f, 0, 1}, {0.4f, 0, 1}};  // shown by both, new at the right
  SensorViews views;
  views.overlap = &overlap;
  views.source_camera = &c;
  std::vector<Pair> pairs = {pair_of(0, {-0.4, 0, 1}, {0, 0, 1}), pair_of(1, {0.4, 0, 1}, {0, 0, 1})};
  ColourOverlapRejector(source, views).reject(pairs, identity);
  ASSERT_EQ(pairs.size(), 1U);
  EXPECT_EQ(pairs[0].index, 0U);
}

TEST(Rejection, AViewThatIsAskedForMustBeGiven) {
  const KdTreeTarget target(room());
  for (const bool frustum : {true, false}) {
    RegistrationSettings settings;
    (frustum ? settings.frustum : settings.colour_overlap) = true;
    EXPECT_THROW(register_cloud(room(), target, identity, settings), std::invalid_argument);
  }
}

}  // namespace
}  // namespace lcmslam
