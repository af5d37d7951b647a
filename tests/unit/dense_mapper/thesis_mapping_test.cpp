// The thesis's variants in the mapper: each along a known path.

#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>
#include <tuple>
#include <vector>

#include <lcmslam/cloud/coloured_cloud.hpp>
#include <lcmslam/dense_mapper/dense_mapper.hpp>
#include <lcmslam/dense_mapper/thesis/growing_cloud.hpp>
#include <lcmslam/dense_mapper/thesis/thesis_tracker.hpp>
#include "tests/support/cloud_scenes.hpp"

namespace lcmslam {
namespace {

CameraModel camera() {
  CameraModel c;
  c.width = 640;
  c.height = 480;
  c.fx = c.fy = 400;
  c.cx = 319.5;
  c.cy = 239.5;
  return c;
}

/// The room as a camera at T_world_camera sees it, and points of it with descriptors of their own.
struct View {
  ColouredCloud cloud;
  FeatureFrame features;
};

View view_from(const Eigen::Isometry3d& T_world_camera, std::uint64_t seed) {
  Random random(seed);
  const Cloud scene = transformed(room(0.04), T_world_camera.inverse());
  View view;
  view.features.width = 640, view.features.height = 480;
  view.features.fx = view.features.fy = 400, view.features.cx = 319.5, view.features.cy = 239.5;
  for (std::size_t i = 0; i < scene.size(); ++i) {
    const auto pixel = camera().project(scene.points[i].cast<double>());
    if (!pixel || !camera().contains(*pixel)) continue;
    const Eigen::Vector3f p =
        scene.points[i] + static_cast<float>(random.normal(0, 0.002)) * scene.normals[i];
    view.cloud.points.push_back(p);
    view.cloud.normals.push_back(scene.normals[i]);
    view.cloud.sigmas.push_back(0.002f);
    view.cloud.colours.emplace_back(10, 20, 30);
    if (i % 40 != 0) continue;
    Feature f;
    f.x = static_cast<float>(pixel->x()), f.y = static_cast<float>(pixel->y());
    f.laplacian = 1;
    f.kind = MeasurementKind::point;
    f.point = p;
    f.depth_sigma = 0.003f;
    Random own(i);
    for (auto& byte : f.descriptor) byte = static_cast<std::uint8_t>(own.below(256));
    view.features.features.push_back(f);
  }
  return view;
}

class EveryVariant : public testing::TestWithParam<std::tuple<VariantKind, SolverKind>> {};
INSTANTIATE_TEST_SUITE_P(
    Variants, EveryVariant,
    testing::Combine(testing::Values(VariantKind::plain, VariantKind::alternating, VariantKind::frustum),
                     testing::Values(SolverKind::svd, SolverKind::quaternion, SolverKind::small_angle)));

TEST_P(EveryVariant, FollowsAKnownPath) {
  DenseMapperSettings settings;
  std::tie(settings.variant, settings.thesis.icp.registration.solver) = GetParam();
  settings.thesis.icp.registration.max_distance = 0.3;
  DenseMapper mapper(settings);
  const Eigen::Isometry3d mount = optical_axes();
  const ColourView colour{cv::Mat(480, 640, CV_8UC3, cv::Scalar::all(90)), camera(), camera(),
                          Eigen::Isometry3d::Identity()};  // a plain image: all is unknown
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity(), T_last = T;
  for (int i = 0; i < 12; ++i) {
    SCOPED_TRACE(i);
    const View view = view_from(T * mount, static_cast<std::uint64_t>(i));
    Motion motion;
    motion.T_from_to = T_last.inverse() * T * se3_exp(twist(0.01, -0.01, 0, 0, 0, 0.01));  // wheels err
    motion.covariance = 1e-4 * Matrix6d::Identity();
    DenseFrame frame =
        coloured_frame(100'000 * i, view.cloud, mount, i > 0 ? std::optional(motion) : std::nullopt);
    frame.features = view.features;
    frame.colour = colour;
    const auto step = mapper.step(frame);
    EXPECT_EQ(to_string(step.status), "tracking");
    const Eigen::Isometry3d error = T.inverse() * step.T_world_robot;
    // Point to point slides, but far less than the wheels, which are 0.15 m off in the end.
    EXPECT_LT(error.translation().norm(), 0.06);
    EXPECT_LT(rotation_angle(error), 0.03);
    if (i > 0) {
      EXPECT_GT(step.registration.overlap, 0.5);
      EXPECT_FALSE(step.registration.rms.empty());
      EXPECT_GT(step.registration.covariance.determinant(), 0);
    }
    T_last = T;
    T = T * se3_exp(twist(0.02, 0.01, 0, 0, 0.005, 0.02));
  }
}

// Another driver, another size of its images: overlap of two such images is not known, and all points count.
TEST(Alternating, GoesOnWhereImagesHaveAnotherSize) {
  DenseMapperSettings settings;
  settings.variant = VariantKind::alternating;
  settings.thesis.icp.registration.max_distance = 0.3;
  DenseMapper mapper(settings);
  const Eigen::Isometry3d mount = optical_axes();
  for (int i = 0; i < 4; ++i) {
    const View view = view_from(mount, static_cast<std::uint64_t>(i));
    DenseFrame frame = coloured_frame(100'000 * i, view.cloud, mount, Motion());
    frame.features = view.features;
    const cv::Mat image = i < 2 ? cv::Mat(480, 640, CV_8UC3, cv::Scalar::all(90))
                                : cv::Mat(240, 320, CV_8UC3, cv::Scalar::all(90));
    frame.colour = ColourView{image, camera(), camera(), Eigen::Isometry3d::Identity()};
    EXPECT_EQ(to_string(mapper.step(frame).status), "tracking") << i;
  }
}

// No odometry at all, half a metre and 30 degrees a step: only the SURF pairs lead there.
TEST(Alternating, TheMapperFollowsLargeStepsWithoutOdometry) {
  const Eigen::Isometry3d mount = optical_axes();
  const Eigen::Isometry3d T = se3_exp(twist(-0.4, 0.3, 0.1, 0.1, 0, -0.4));
  for (const auto kind : {VariantKind::plain, VariantKind::alternating}) {
    DenseMapperSettings settings;
    settings.variant = kind;
    settings.thesis.icp.registration.max_distance = 0.3;
    DenseMapper mapper(settings);
    const View first = view_from(mount, 1), second = view_from(T * mount, 2);
    DenseFrame frame = coloured_frame(0, first.cloud, mount);
    frame.features = first.features;
    mapper.step(frame);
    frame = coloured_frame(100'000, second.cloud, mount);
    frame.features = second.features;
    const auto step = mapper.step(frame);
    const double error = (T.inverse() * step.T_world_robot).translation().norm();
    if (kind == VariantKind::alternating) {
      EXPECT_LT(error, 0.03);
    } else {
      EXPECT_GT(error, 0.1) << "the case is hard";
    }
  }
}

// A wall with bumps, and a camera that goes along it to the right: what its image shows moves by `gone`
// pixels, so that of the eight columns of segments the last three are new.
constexpr int gone = 240;
constexpr double wall_distance = 2;     // m
constexpr double shown_again = 5. / 8;  // of the second image

double wall_depth(const Eigen::Vector2d& at) {
  static const std::vector<Eigen::Vector2d> bumps = [] {
    Random random(3);
    std::vector<Eigen::Vector2d> centres;
    for (int i = 0; i < 14; ++i) centres.emplace_back(random.uniform(-1.7, 2.9), random.uniform(-1.3, 1.3));
    return centres;
  }();
  double depth = wall_distance;
  for (const auto& bump : bumps) depth -= 0.12 * std::exp(-(at - bump).squaredNorm() / (2 * 0.2 * 0.2));
  return depth;
}

cv::Mat wall_texture() {
  cv::Mat image(480, 640 + gone, CV_8UC3);
  cv::RNG random(5);
  random.fill(image, cv::RNG::UNIFORM, 0, 256);
  cv::GaussianBlur(image, image, {}, 6);
  cv::normalize(image, image, 0, 255, cv::NORM_MINMAX);
  return image;
}

/// From `x` m along the wall: other points of it each time, and twelve SURF points that err by 3 cm.
DenseFrame wall_frame(double x, std::uint64_t seed) {
  const CameraModel model = camera();
  Random random(seed);
  ColouredCloud cloud;
  for (int i = 0; i < 5000; ++i) {
    const Eigen::Vector3d ray =
        model.ray({random.uniform(0, model.width - 1), random.uniform(0, model.height - 1)});
    double depth = wall_distance;
    for (int k = 0; k < 10; ++k) depth = wall_depth({x + depth * ray.x(), depth * ray.y()});
    cloud.points.emplace_back(((depth + random.normal(0, 0.002)) * ray).cast<float>());
  }
  cloud.normals.assign(cloud.size(), Eigen::Vector3f(0, 0, -1));
  cloud.colours.assign(cloud.size(), cv::Vec3b(10, 20, 30));
  cloud.sigmas.assign(cloud.size(), 0.002F);
  DenseFrame frame = coloured_frame(static_cast<Utime>(100'000 * seed), cloud, optical_axes());
  frame.features = FeatureFrame();
  for (std::uint64_t i = 0; i < 12; ++i) {
    Random own(i);
    const Eigen::Vector2d at(own.uniform(-0.3, 1.3), own.uniform(-1, 1));  // in both images
    const Eigen::Vector3d error(random.normal(0, 0.03), random.normal(0, 0.03), random.normal(0, 0.03));
    Feature f;
    f.laplacian = 1;
    f.kind = MeasurementKind::point;
    for (auto& byte : f.descriptor) byte = static_cast<std::uint8_t>(own.below(256));
    f.point = (Eigen::Vector3d(at.x() - x, at.y(), wall_depth(at)) + error).cast<float>();
    frame.features->features.push_back(f);
  }
  return frame;
}

// Step 1 of algorithm 3.2 in the mapper: the points of what both images show are registered and no others.
// Without texture all are, and what the target lacks pulls them aside.
TEST(Alternating, TheMapperRegistersWhatBothImagesShow) {
  const double way = gone * wall_distance / camera().fx;
  const Eigen::Isometry3d T = planar_pose(0, -way, 0);
  DenseFrame first = wall_frame(0, 1), second = wall_frame(way, 2);
  const auto points = static_cast<double>(second.cloud.size());
  const cv::Mat texture = wall_texture(), plain(480, 640, CV_8UC3, cv::Scalar::all(90));
  const auto with_images = [&](const cv::Mat& of_first, const cv::Mat& of_second, int feature_iterations) {
    DenseMapperSettings settings;
    settings.variant = VariantKind::alternating;
    settings.voxel_size = 0;
    settings.filter.max_incidence = 3.1416;
    settings.thesis.checked_features = false;
    settings.thesis.icp.feature_iterations = feature_iterations;
    const Eigen::Isometry3d one = Eigen::Isometry3d::Identity();
    first.colour = ColourView{of_first, camera(), camera(), one};
    second.colour = ColourView{of_second, camera(), camera(), one};
    DenseMapper mapper(settings);
    mapper.step(first);
    return mapper.step(second);
  };
  const auto registered = [](const DenseMapper::Step& step) {  // points
    return static_cast<double>(step.registration.pairs) / step.registration.overlap;
  };
  for (const int feature_iterations : {0, 1}) {
    SCOPED_TRACE(feature_iterations);
    const auto sub = with_images(texture({0, 0, 640, 480}), texture({gone, 0, 640, 480}), feature_iterations);
    const auto all = with_images(plain, plain, feature_iterations);
    EXPECT_NEAR(registered(sub) / points, shown_again, 0.03);
    EXPECT_NEAR(registered(all) / points, 1, 1e-9);
    EXPECT_LT(distance_between(sub.T_world_robot, T), 0.03);
    EXPECT_LT(angle_between(sub.T_world_robot, T), 0.02);
    EXPECT_GT(distance_between(all.T_world_robot, T), 0.15) << "what is new on the right does not harm";
  }
}

// Figures 3.8 to 3.11: without an initial alignment the raw clouds and the SURF subset alone stay off.
TEST(Alternating, WithoutAStartTheSettingsDecideWhereItBegins) {
  ThesisSettings settings;
  EXPECT_EQ(start_kind(VariantKind::plain, settings), StartKind::prediction);
  EXPECT_EQ(start_kind(VariantKind::alternating, settings), StartKind::features);
  EXPECT_FALSE(needs_features(VariantKind::frustum, settings));
  EXPECT_FALSE(needs_features(VariantKind::modern, settings));
  EXPECT_TRUE(needs_features(VariantKind::alternating, settings));

  // No iteration moves it: what comes out is the start.
  const Eigen::Isometry3d mount = optical_axes();
  const Eigen::Isometry3d T_last = se3_exp(twist(0.3, 0, 0, 0, 0, 0.2));
  const Eigen::Isometry3d T = T_last * se3_exp(twist(0.2, 0.1, 0, 0, 0, 0.15));
  const Eigen::Isometry3d T_predicted = T_last * se3_exp(twist(0.1, 0, 0, 0, 0, 0));
  const View first = view_from(T_last * mount, 1), second = view_from(T * mount, 2);
  const auto frame_of = [&](const View& view) {
    DenseFrame frame = coloured_frame(0, view.cloud, mount);
    frame.features = view.features;
    return frame;
  };
  const DenseFrame last = frame_of(first), now = frame_of(second);
  settings.icp.registration.max_distance = 1e-6;  // no pair
  for (const auto& [start, T_expected, tolerance] :
       {std::tuple(StartKind::prediction, T_predicted, 1e-9), std::tuple(StartKind::last_pose, T_last, 1e-9),
        std::tuple(StartKind::features, T, 0.01)}) {
    settings.start = start;
    EXPECT_EQ(needs_features(VariantKind::plain, settings), start == StartKind::features);
    ThesisTracker tracker(VariantKind::plain, settings);
    EXPECT_EQ(tracker.memory_bytes(), 0U);
    tracker.accept({last, transformed(geometry_of(first.cloud), mount)}, T_last, true);
    EXPECT_GE(tracker.memory_bytes(), tracker.target().memory_bytes());
    EXPECT_GT(tracker.memory_bytes(), 0U);
    const auto result =
        tracker.register_frame({now, transformed(geometry_of(second.cloud), mount)}, T_predicted);
    EXPECT_LT(distance_between(result.T_target_source, T_expected), tolerance) << static_cast<int>(start);
    EXPECT_LT(angle_between(result.T_target_source, T_expected), tolerance) << static_cast<int>(start);
  }
}

// Section 3.3: what the mapper publishes is the growing cloud, point by point, with the frames' colours.
TEST(Variants, ThePublishedMapIsTheGrowingCloud) {
  DenseMapperSettings settings;
  settings.variant = VariantKind::plain;
  settings.voxel_size = 0;
  settings.graph.enabled = false;
  settings.thesis.icp.registration.max_distance = 0.3;
  DenseMapper mapper(settings);
  GrowingCloud expected(settings.thesis.merge_distance);
  const Eigen::Isometry3d mount = optical_axes();
  std::size_t published = 0;
  for (int i = 0; i < 12; ++i) {
    const DenseFrame frame = coloured_frame(
        100'000 * i,
        view_from(planar_pose(0.05 * i, 0, 0.05 * i) * mount, static_cast<std::uint64_t>(i)).cloud, mount);
    const auto step = mapper.step(frame);
    ASSERT_EQ(to_string(step.status), "tracking") << i;
    Cloud cloud = usable_points(frame.cloud, settings.filter);
    move(cloud, mount);
    expected.add(transformed(cloud, step.T_world_robot));
    published += (step.keyframe ? 1 : 0) + mapper.take_changed().size();
  }
  EXPECT_GE(mapper.keyframes().size(), 2U);
  EXPECT_LE(published, 2 * mapper.keyframes().size())
      << "a keyframe goes out when it begins and when it ends";
  EXPECT_FALSE(mapper.take_changed(true).empty()) << "the newest one's later points go out at the end";
  std::size_t points = 0;
  for (const auto& keyframe : mapper.keyframes()) {
    points += keyframe.cloud.size();
    ASSERT_EQ(keyframe.cloud.colours.size(), keyframe.cloud.size());
    for (std::size_t k = 0; k < keyframe.cloud.size(); ++k) {
      TargetPoint found;
      const Eigen::Vector3f point = keyframe.T_world_camera.cast<float>() * keyframe.cloud.points[k];
      ASSERT_TRUE(expected.find(point, 1e-4F, found));
      EXPECT_EQ(keyframe.cloud.colours[k], cv::Vec3b(10, 20, 30));
    }
  }
  EXPECT_EQ(points, expected.size());
}

// What the uncorrected estimators give never leaves the mapper: rotations only.
TEST(Variants, PosesAreRotationsWhateverTheEstimator) {
  for (const auto solver :
       {SolverKind::svd_uncorrected, SolverKind::quaternion_as_printed, SolverKind::small_angle_as_printed}) {
    DenseMapperSettings settings;
    settings.variant = VariantKind::plain;
    settings.thesis.icp.registration.solver = solver;
    DenseMapper mapper(settings);
    for (int i = 0; i < 4; ++i) {
      const Eigen::Isometry3d T = planar_pose(0.05 * i, 0, 0.1 * i) * optical_axes();
      const auto step = mapper.step(coloured_frame(100'000 * i, view_from(T, 1).cloud, optical_axes()));
      const Eigen::Matrix3d R = step.T_world_robot.linear();
      EXPECT_TRUE(step.T_world_robot.matrix().allFinite());
      EXPECT_NEAR(R.determinant(), 1, 1e-9);
      EXPECT_LT((R * R.transpose() - Eigen::Matrix3d::Identity()).norm(), 1e-9);
    }
  }
}

}  // namespace
}  // namespace lcmslam
