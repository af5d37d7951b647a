// The thesis's own variants: overlap by colour, alternation with SURF points (algorithm 3.2), frustum.

#include <gmock/gmock.h>

#include <opencv2/imgproc.hpp>

#include <lcmslam/dense_mapper/thesis/alternating.hpp>
#include <lcmslam/registration/kd_tree_target.hpp>
#include <lcmslam/registration/view_frustum.hpp>
#include <lcmslam/rgbd/colour_overlap.hpp>
#include "tests/support/cloud_scenes.hpp"

namespace lcmslam {
namespace {

CameraModel camera() {
  CameraModel c;
  c.width = 640;
  c.height = 480;
  c.fx = c.fy = 525;
  c.cx = 319.5;
  c.cy = 239.5;
  return c;
}

TEST(ViewFrustum, HoldsWhatTheImageShows) {
  const CameraModel c = camera();
  const ViewFrustum frustum(c);
  Random random(1);
  int inside = 0;
  for (int i = 0; i < 20000; ++i) {
    const Eigen::Vector3d p(random.uniform(-3, 3), random.uniform(-3, 3), random.uniform(-1, 4));
    const auto pixel = c.project(p);
    const bool shown = pixel && c.contains(*pixel);
    EXPECT_EQ(frustum.contains(p.cast<float>()), shown) << p.transpose();
    inside += shown ? 1 : 0;
  }
  EXPECT_GT(inside, 1000);
  EXPECT_FALSE(frustum.contains({0, 0, 0}));
  EXPECT_FALSE(frustum.contains({0, 0, -1}));
  EXPECT_FALSE(frustum.contains(Eigen::Vector3f::Constant(NAN)));
  EXPECT_THROW(ViewFrustum{CameraModel()}, std::invalid_argument);
}

TEST(ViewFrustum, KeepsPointsWithAllThatIsKnownOfThem) {
  Cloud cloud = room();
  cloud.sigmas.assign(cloud.size(), 0.01f);
  const Eigen::Isometry3d T_camera_cloud = optical_axes().inverse();
  const Cloud inside = points_inside(cloud, ViewFrustum(camera()), T_camera_cloud);
  EXPECT_GT(inside.size(), 100U);
  EXPECT_LT(inside.size(), cloud.size());
  EXPECT_EQ(inside.normals.size(), inside.size());
  EXPECT_EQ(inside.sigmas.size(), inside.size());
}

cv::Mat texture() {
  Random random(2);
  cv::Mat image(700, 1000, CV_8UC3);
  for (auto& pixel : cv::Mat_<cv::Vec3b>(image))
    for (int k = 0; k < 3; ++k) pixel[k] = static_cast<std::uint8_t>(256 * random.uniform());
  cv::GaussianBlur(image, image, {}, 6);
  cv::normalize(image, image, 0, 255, cv::NORM_MINMAX);
  return image;
}

TEST(ColourOverlap, FindsWhatBothImagesShow) {
  const cv::Mat world = texture();
  const cv::Mat target = world({100, 100, 640, 480});
  const cv::Mat source =
      world({340, 100, 640, 480});  // 240 pixels to the right: three of eight columns are new
  for (const double search : {0., 60.}) {
    SCOPED_TRACE(search);
    ColourOverlapSettings settings;
    settings.search = search;
    const ImageOverlap overlap = colour_overlap(source, target, settings, {230, 5});
    ASSERT_EQ(overlap.segments().size(), 48U);
    for (const Segment& segment : overlap.segments()) {
      const bool shown = segment.area.x + segment.area.width + 240 <= 640;
      EXPECT_EQ(segment.state, shown ? SegmentState::overlapping : SegmentState::outside) << segment.area;
      if (!shown) continue;
      EXPECT_GT(segment.coefficient, 0.9);
      const double x = segment.area.x + 0.5 * segment.area.width + 240,
                   y = segment.area.y + 0.5 * segment.area.height;
      EXPECT_NEAR(segment.found.x, x, 4);
      EXPECT_NEAR(segment.found.y, y, 4);
    }
    EXPECT_DOUBLE_EQ(overlap.overlap().value(), 5 / 8.);
  }
}

TEST(ColourOverlap, APlainSegmentIsUnknownAndItsPointsStay) {
  const cv::Mat world = texture();
  cv::Mat source = world({0, 0, 640, 480}).clone();
  source({0, 0, 160, 480}).setTo(cv::Scalar::all(90));
  const ImageOverlap overlap = colour_overlap(source, world({360, 220, 640, 480}));
  EXPECT_EQ(overlap.at(10, 10)->state, SegmentState::unknown);
  EXPECT_EQ(overlap.at(100, 470)->state, SegmentState::unknown);
  EXPECT_EQ(overlap.at(200, 10)->state, SegmentState::outside);
  EXPECT_EQ(overlap.at(-1, 10), nullptr);
  EXPECT_EQ(overlap.at(10, 480), nullptr);
  Cloud cloud;
  cloud.points = {{-0.55f, 0, 1}, {0, 0, 1}, {0, 0, -1}};  // pixels 31, 320, none
  EXPECT_EQ(overlapping_points(cloud, overlap, camera()).size(), 1U);

  const cv::Mat plain(480, 640, CV_8UC3, cv::Scalar::all(7));
  EXPECT_FALSE(colour_overlap(plain, plain).overlap());
}

TEST(ColourOverlap, RefusesImagesThatDoNotFit) {
  const cv::Mat image(48, 64, CV_8UC1, cv::Scalar(1));
  EXPECT_THROW(colour_overlap(image, cv::Mat()), std::invalid_argument);
  EXPECT_THROW(colour_overlap(image, cv::Mat(48, 64, CV_8UC3)), std::invalid_argument);
  EXPECT_THROW(colour_overlap(cv::Mat(48, 64, CV_32FC1), cv::Mat(48, 64, CV_32FC1)), std::invalid_argument);
  ColourOverlapSettings settings;
  settings.scale = 0;
  EXPECT_THROW(colour_overlap(image, image, settings), std::invalid_argument);
}

/// A room, the same room moved far, and some noisy corresponding points on it.
struct FarPair {
  Cloud source, target = room();
  FeaturePairs features;
  Eigen::Isometry3d T_target_source;

  explicit FarPair(std::uint64_t seed, int count = 15, double sigma = 0.02) {
    Random random(seed);
    T_target_source = se3_exp(twist(0.8, -0.6, 0.2, 0.3, -0.2, 2.0));
    source = transformed(room(0.061), T_target_source.inverse());  // other points of the same surfaces
    for (int i = 0; i < count; ++i) {
      const auto k = static_cast<std::size_t>(random.uniform() * static_cast<double>(target.size()));
      const auto noise = [&]() -> Eigen::Vector3d {
        return Eigen::Vector3d(random.normal(), random.normal(), random.normal()) * sigma;
      };
      const Eigen::Vector3d p = target.points[k].cast<double>();
      features.target.push_back((p + noise()).cast<float>());
      features.source.push_back((T_target_source.inverse() * (p + noise())).cast<float>());
    }
  }
};

double error(const Eigen::Isometry3d& T, const Eigen::Isometry3d& truth) {
  const Eigen::Isometry3d difference = truth.inverse() * T;
  return difference.translation().norm() + 2 * rotation_angle(difference);  // the room is 2 m away
}

TEST(Alternating, ConvergesWhereTheCloudAloneDoesNot) {
  for (const std::uint64_t seed : {1u, 2u, 3u, 4u, 5u}) {
    const FarPair pair(seed);
    const KdTreeTarget target(pair.target);
    AlternatingSettings settings;
    settings.pairing = FeaturePairing::fixed;
    RegistrationSettings alone = settings.registration;
    alone.max_iterations = 200;
    const auto raw = register_cloud(pair.source, target, Eigen::Isometry3d::Identity(), alone);
    EXPECT_GT(error(raw.T_target_source, pair.T_target_source), 0.1) << "the case is hard";

    const auto result =
        register_alternating(pair.source, target, pair.features, Eigen::Isometry3d::Identity(), settings);
    EXPECT_TRUE(result.ok()) << to_string(result.stop);
    EXPECT_LT(error(result.T_target_source, pair.T_target_source), 0.05) << seed;
    EXPECT_EQ(result.cloud_rms.size(), result.feature_rms.size());
  }
}

TEST(Alternating, StartFromTheFeaturesAndNearestPairsGoOnFromThere) {
  for (const auto solver : {SolverKind::svd, SolverKind::quaternion}) {
    const FarPair pair(7);
    const KdTreeTarget target(pair.target);
    AlternatingSettings settings;
    settings.registration.solver = solver;
    const auto start = align_start(pair.features, settings.registration);
    ASSERT_TRUE(start);
    EXPECT_LT(error(*start, pair.T_target_source), 0.15);
    const auto result = register_alternating(pair.source, target, pair.features, *start, settings);
    EXPECT_TRUE(result.ok());
    EXPECT_LT(error(result.T_target_source, pair.T_target_source), 0.05);
  }
}

TEST(Alternating, TheSmallerErrorIsTaken) {
  const FarPair noisy(3, 15, 0.05), exact(3, 15, 0);
  for (const FarPair* pair : {&noisy, &exact}) {
    const KdTreeTarget target(pair->target);
    AlternatingSettings settings;
    settings.pairing = FeaturePairing::fixed;
    const auto result =
        register_alternating(pair->source, target, pair->features, pair->T_target_source, settings);
    EXPECT_EQ(result.from_features, pair == &exact);
    EXPECT_EQ(result.from_features, result.feature_rms.back() < result.cloud_rms.back());
  }
}

TEST(Alternating, OneSetAloneGoesOn) {
  const FarPair pair(1);
  const KdTreeTarget target(pair.target);
  const KdTreeTarget nothing(Cloud{});
  AlternatingSettings settings;
  const auto cloud_only = register_alternating(pair.source, target, {}, pair.T_target_source, settings);
  EXPECT_TRUE(cloud_only.ok());
  EXPECT_FALSE(cloud_only.from_features);
  EXPECT_LT(error(cloud_only.T_target_source, pair.T_target_source), 0.05);
  settings.pairing = FeaturePairing::fixed;
  const auto features_only = register_alternating({}, nothing, pair.features, pair.T_target_source, settings);
  EXPECT_TRUE(features_only.ok());
  EXPECT_TRUE(features_only.from_features);
  const auto neither = register_alternating({}, nothing, {}, pair.T_target_source, settings);
  EXPECT_EQ(neither.stop, StopReason::too_few_pairs);
  EXPECT_TRUE(neither.T_target_source.matrix().allFinite());
}

TEST(Alternating, RefusesWhatMakesNoSense) {
  const KdTreeTarget target(room());
  FeaturePairs uneven;
  uneven.source.emplace_back(0, 0, 0);
  EXPECT_THROW(register_alternating(room(), target, uneven, Eigen::Isometry3d::Identity()),
               std::invalid_argument);
  AlternatingSettings settings;
  settings.cloud_iterations = 0;
  EXPECT_THROW(register_alternating(room(), target, {}, Eigen::Isometry3d::Identity(), settings),
               std::invalid_argument);
  settings = {};
  settings.registration.metric = MetricKind::point_to_plane;
  EXPECT_THROW(register_alternating(room(), target, {}, Eigen::Isometry3d::Identity(), settings),
               std::invalid_argument);
  EXPECT_FALSE(align_start({}, AlternatingSettings().registration));
}

}  // namespace
}  // namespace lcmslam
