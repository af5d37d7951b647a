// Rejectors that know the clouds or the sensors, selection by normals, colour, preparation, stop.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <thread>

#include <lcmslam/registration/kd_tree_target.hpp>
#include <lcmslam/registration/preparation.hpp>
#include <lcmslam/registration/registration.hpp>
#include <lcmslam/registration/selection.hpp>
#include <lcmslam/registration/stop_criterion.hpp>
#include <lcmslam/rgbd/colour_overlap.hpp>
#include "tests/support/cloud_scenes.hpp"

namespace lcmslam {
namespace {

const Eigen::Isometry3d identity = Eigen::Isometry3d::Identity();

CameraModel camera() {
  CameraModel c;
  c.width = 640;
  c.height = 480;
  c.fx = c.fy = 525;
  c.cx = 319.5;
  c.cy = 239.5;
  return c;
}

Pair pair_of(std::size_t index, const Eigen::Vector3d& source, const Eigen::Vector3d& target) {
  Pair p;
  p.index = index;
  p.source = p.moved = source;
  p.target = target;
  return p;
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
  const ViewFrustum frustum(camera());
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
  const CameraModel c = camera();
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

// A floor with a small step: nearly all normals point up.
Cloud floor_with_step() {
  Cloud cloud;
  add_rectangle(cloud, {0, 0, 0}, {4, 0, 0}, {0, 4, 0});
  add_rectangle(cloud, {4, 0, 0}, {0, 4, 0}, {0, 0, 0.2});
  add_rectangle(cloud, {0, 4, 0}, {0, 0, 0.2}, {4, 0, 0});
  return cloud;
}

TEST(Selection, NormalSpaceAndStableTakeTheRareDirections) {
  const Cloud cloud = floor_with_step();
  const auto sideways = [&](SelectionKind kind) {
    RegistrationSettings settings;
    settings.selection = kind;
    settings.selected_points = 600;
    const auto selected = select_points(cloud, settings);
    EXPECT_EQ(selected.size(), 600U);
    EXPECT_TRUE(std::is_sorted(selected.begin(), selected.end()));
    EXPECT_EQ(std::adjacent_find(selected.begin(), selected.end()), selected.end());
    EXPECT_EQ(selected, select_points(cloud, settings)) << "not repeatable";
    const auto is_sideways = [&](std::size_t i) { return std::abs(cloud.normals[i].z()) < 0.5f; };
    return std::count_if(selected.begin(), selected.end(), is_sideways);
  };
  EXPECT_LT(sideways(SelectionKind::uniform), 100);
  EXPECT_LT(sideways(SelectionKind::random), 100);
  EXPECT_GE(sideways(SelectionKind::normal_space), 390);  // two of three directions
  EXPECT_GE(sideways(SelectionKind::stable), 300);
}

TEST(Selection, WithoutNormalsItIsRandom) {
  Cloud cloud = room();
  cloud.normals.clear();
  cloud.points[3].setConstant(NAN);
  RegistrationSettings settings;
  settings.selected_points = 100;
  settings.selection = SelectionKind::random;
  const auto random = select_points(cloud, settings);
  for (const auto kind : {SelectionKind::normal_space, SelectionKind::stable}) {
    settings.selection = kind;
    EXPECT_EQ(select_points(cloud, settings), random);
  }
}

TEST(NormalShooting, TakesTheCandidateAlongTheNormal) {
  Cloud cloud;
  cloud.points = {{0.1f, 0, 0}, {0, 0, 0.2f}};
  const NormalShootingTarget target(cloud);
  TargetPoint found;
  ASSERT_TRUE(target.find({0, 0, 0}, 1, found));
  EXPECT_EQ(found.point.x(), 0.1f);
  ASSERT_TRUE(target.find_along({0, 0, 0}, {0, 0, -1}, 1, found));
  EXPECT_EQ(found.point.z(), 0.2f);
  ASSERT_TRUE(target.find_along({0, 0, 0}, {0, 0, -1}, 0.15f, found));  // the other one is too far
  EXPECT_EQ(found.point.x(), 0.1f);
  ASSERT_TRUE(target.find_along({0, 0, 0}, Eigen::Vector3f::Constant(NAN), 1, found));
  EXPECT_EQ(found.point.x(), 0.1f);
  EXPECT_FALSE(target.find_along({0, 0, 0}, {0, 0, 1}, 0.05f, found));
}

// A painted wall: grey values that vary smoothly along it.
Cloud painted_wall(double spacing = 0.03) {
  Cloud cloud = wall(spacing);
  for (const auto& p : cloud.points)
    cloud.intensities.push_back(0.5f + 0.25f * std::sin(4 * p.y()) + 0.2f * std::cos(5 * p.z()));
  return cloud;
}

TEST(Colour, GradientsAreThoseOfThePaint) {
  Cloud cloud = painted_wall();
  estimate_gradients(cloud);
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const Eigen::Vector3f& p = cloud.points[i];
    if (std::abs(p.y()) > 1.4f || std::abs(p.z()) > 0.9f) continue;
    const Eigen::Vector3f expected(0, std::cos(4 * p.y()), -std::sin(5 * p.z()));
    EXPECT_LT((cloud.gradients[i] - expected).norm(), 0.08f) << p.transpose();
  }
  Cloud plain = wall();
  estimate_gradients(plain);
  EXPECT_FALSE(plain.gradients[0].allFinite());
}

// In front of a bare wall three directions slide; paint holds them.
TEST(Colour, FixesWhatGeometryLeavesFree) {
  RegistrationSettings settings;
  settings.colour_scale = 0.2;
  const KdTreeTarget target(prepared_target(painted_wall(), settings, Eigen::Vector3d::Zero()));
  const Eigen::Isometry3d start = se3_exp(twist(0.01, 0.05, -0.04, 0.02, 0, 0));
  for (const auto metric : {MetricKind::point_to_plane, MetricKind::plane_to_plane})
    for (const auto solver : {SolverKind::gauss_newton, SolverKind::levenberg_marquardt}) {
      settings.metric = metric;
      settings.solver = solver;
      settings.colour_scale = 0.2;
      const auto with = register_cloud(painted_wall(0.037), target, start, settings);
      EXPECT_TRUE(with.ok()) << to_string(with.stop);
      EXPECT_TRUE(with.degenerate.empty());
      EXPECT_LT(with.T_target_source.translation().norm(), 0.005);
      EXPECT_LT(rotation_angle(with.T_target_source), 0.005);
      settings.colour_scale = 0;
      const auto without = register_cloud(painted_wall(0.037), target, start, settings);
      EXPECT_EQ(without.degenerate.size(), 3U);
      EXPECT_GT(without.T_target_source.translation().norm(), 0.03);
    }
}

TEST(Preparation, GivesWhatThePartsAskFor) {
  Cloud bare(room().points);
  RegistrationSettings settings;
  settings.metric = MetricKind::point_to_point;
  EXPECT_FALSE(prepared_target(bare, settings, Eigen::Vector3d::Zero()).has_normals());
  settings.metric = MetricKind::plane_to_plane;
  settings.boundary = true;
  const Cloud target = prepared_target(bare, settings, Eigen::Vector3d::Zero());
  EXPECT_TRUE(target.has_normals());
  EXPECT_EQ(target.boundary.size(), target.size());
  EXPECT_TRUE(target.gradients.empty());  // no intensities
  EXPECT_TRUE(prepared_source(bare, settings, Eigen::Vector3d::Zero()).has_normals());
}

TEST(StopCriterion, SmallStepsOrASettledError) {
  RegistrationSettings settings;
  settings.epsilon_translation = 0.01;
  settings.epsilon_rotation = 0.01;
  settings.epsilon_rms = 1e-3;
  const StopCriterion stop(settings);
  const auto step = [](double metres, double radians) { return se3_exp(twist(metres, 0, 0, radians, 0, 0)); };
  EXPECT_TRUE(stop.arrived(identity, step(0.005, 0.005), {1}));
  EXPECT_FALSE(stop.arrived(identity, step(0.02, 0.005), {1}));
  EXPECT_FALSE(stop.arrived(identity, step(0.005, 0.02), {1}));
  EXPECT_FALSE(stop.arrived(identity, step(1, 1), {1, 0.5}));
  EXPECT_TRUE(stop.arrived(identity, step(1, 1), {1, 0.5, 0.4995}));
}

TEST(Registration, DegenerateDirectionsHaveNames) {
  RegistrationResult result;
  result.degenerate = {twist(0, 0, 1, 0, 0, 0), twist(0.1, 0, 0, 0, 0, -0.9)};
  EXPECT_EQ(degenerate_names(result), (std::vector<std::string>{"z", "yaw"}));
}

// The corridor's own direction is named.
TEST(Registration, ACorridorIsFreeAlongX) {
  const auto result = register_cloud(corridor(), KdTreeTarget(corridor()), identity, {});
  EXPECT_EQ(degenerate_names(result), std::vector<std::string>{"x"});
}

TEST(Registration, TwoCloudsFromFarThroughTheFacade) {
  Random random(5);
  for (const auto metric :
       {MetricKind::point_to_point, MetricKind::point_to_plane, MetricKind::plane_to_plane}) {
    const Eigen::Isometry3d T = se3_exp(twist(0.1, -0.1, 0.05, 0.05, 0.05, 0.1));
    const Cloud source(transformed(room(0.037), T.inverse()).points), target(room(0.03).points);
    const auto result = register_clouds(source, target, identity, wide_passes(metric));
    EXPECT_TRUE(result.ok()) << to_string(result.stop);
    const Eigen::Isometry3d error = T.inverse() * result.T_target_source;
    EXPECT_LT(error.translation().norm(), 0.01);
    EXPECT_LT(rotation_angle(error), 0.005);
  }
  EXPECT_THROW(register_clouds(room(), room(), identity, {}), std::invalid_argument);
}

TEST(Registration, ALookMovesNothingAndAgreesWithTheRun) {
  const KdTreeTarget target(room(0.03));
  const auto run = register_cloud(room(0.037), target, identity, {});
  RegistrationSettings settings;
  settings.max_distance = 0.06;
  const auto seen = look(room(0.037), target, run.T_target_source, settings);
  EXPECT_TRUE(seen.T_target_source.matrix() == run.T_target_source.matrix());
  EXPECT_NEAR(seen.overlap, run.overlap, 0.02);
  EXPECT_NEAR(seen.rms.at(0), run.rms.back(), 1e-3);
  EXPECT_EQ(look({}, target, identity, settings).stop, StopReason::too_few_pairs);
}

TEST(Registration, IsTheSameInEveryThread) {
  RegistrationSettings settings;
  settings.metric = MetricKind::plane_to_plane;
  settings.selection = SelectionKind::stable;
  settings.selected_points = 500;
  settings.mutual = true;
  const KdTreeTarget target(room(0.04));
  const Eigen::Isometry3d start = se3_exp(twist(0.02, 0.02, 0, 0.01, 0, 0.02));
  std::vector<RegistrationResult> results(8);
  std::vector<std::thread> threads;
  for (auto& result : results)
    threads.emplace_back([&] { result = register_cloud(room(), target, start, settings); });
  for (auto& thread : threads) thread.join();
  for (const auto& result : results) {
    EXPECT_TRUE(result.T_target_source.matrix() == results[0].T_target_source.matrix());
    EXPECT_TRUE(result.covariance == results[0].covariance);
    EXPECT_EQ(result.rms, results[0].rms);
  }
}

}  // namespace
}  // namespace lcmslam
