#include "surf/guided_matching.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <map>

#include "geometry/random.hpp"
#include "surf/descriptor_search.hpp"
#include "unit/surf/heap_allocations.hpp"
#include "unit/surf/recorded_features.hpp"

namespace lcmslam {
namespace {

using testing::HasSubstr;

Vector6d random_twist(Random& random, double translation, double rotation) {
  Vector6d twist;
  for (int k = 0; k < 6; ++k) twist[k] = (k < 3 ? translation : rotation) * random.normal();
  return twist;
}

Matrix6d diagonal(double translation, double rotation) {
  Vector6d variances;
  variances << Eigen::Vector3d::Constant(translation * translation),
      Eigen::Vector3d::Constant(rotation * rotation);
  return variances.asDiagonal();
}

FeatureFrame empty_frame() {
  FeatureFrame frame;
  frame.width = 640;
  frame.height = 480;
  frame.fx = 525;
  frame.fy = 520;
  frame.cx = 319.5;
  frame.cy = 239.5;
  frame.pixel_sigma = 1;
  return frame;
}

struct Scene {
  FeatureFrame frame = empty_frame();
  std::vector<MapPoint> landmarks;
  DescriptorIndex index;
  std::map<int, int> feature_of;  // landmark: the feature that shows it
  PredictedPose truth;
};

Descriptor texture(std::uint64_t kind, double spread, Random& random) {
  Random pattern(kind, 7);
  Descriptor descriptor;
  for (auto& byte : descriptor)
    byte = std::uint8_t(
        std::lround(std::clamp(128 + 16 * pattern.normal() + spread * random.normal(), 1., 255.)));
  return descriptor;
}

// Landmarks all around the camera, only some 400 different textures among them: a building whose windows
// look alike. 300 of those in view are seen, and 200 other blobs.
Scene make_scene(std::uint64_t seed, int count) {
  Random random(seed, 3);
  Scene scene;
  scene.truth.T_world_camera = se3_exp(random_twist(random, 0.5, 0.5));
  for (int i = 0; i < count; ++i) {
    const Eigen::Vector3d direction(random.normal(), random.normal(), random.normal());
    MapPoint landmark{5 * i, random.uniform(2, 6) * direction.normalized(),
                      1e-4 * Eigen::Matrix3d::Identity()};
    const std::uint64_t kind = random.below(400);
    const int laplacian = kind % 2 ? 1 : -1;
    scene.index.insert(landmark.id, texture(kind, 4, random), laplacian);
    scene.landmarks.push_back(landmark);
    const Eigen::Vector3d noise(random.normal(), random.normal(), random.normal());
    MapPoint actual = landmark;
    actual.position += 0.01 * noise;
    const auto projection = project(actual, scene.truth.T_world_camera, scene.frame);
    if (!projection || scene.feature_of.size() >= 300) continue;
    Feature feature;
    feature.x = float(projection->pixel.x() + random.normal());
    feature.y = float(projection->pixel.y() + random.normal());
    if (feature.x < 0 || feature.x > 639 || feature.y < 0 || feature.y > 479) continue;
    feature.laplacian = std::int8_t(laplacian);
    feature.descriptor = scene.index.descriptor(landmark.id);
    for (auto& byte : feature.descriptor)
      byte = std::uint8_t(std::lround(std::clamp(byte + 6 * random.normal(), 1., 255.)));
    scene.feature_of[landmark.id] = int(scene.frame.features.size());
    scene.frame.features.push_back(feature);
  }
  for (int i = 0; i < 200; ++i) {
    Feature feature;
    feature.x = float(random.uniform(0, 639));
    feature.y = float(random.uniform(0, 479));
    const std::uint64_t kind = random.below(400);
    feature.laplacian = kind % 2 ? 1 : -1;
    feature.descriptor = texture(kind, 4, random);
    scene.frame.features.push_back(feature);
  }
  return scene;
}

int count_right(const Scene& scene, const std::vector<Match>& matches) {
  int right = 0;
  for (const Match& m : matches) {
    const auto seen = scene.feature_of.find(m.b);
    right += seen != scene.feature_of.end() && seen->second == m.a;
  }
  return right;
}

TEST(Projection, JacobiansAreTheNumericalOnes) {
  const FeatureFrame frame = empty_frame();
  for (std::uint64_t seed = 1; seed <= 50; ++seed) {
    Random random(seed);
    const Eigen::Isometry3d T_world_camera = se3_exp(random_twist(random, 1, 1));
    MapPoint point;
    point.position =
        T_world_camera * Eigen::Vector3d(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(1, 5));
    const auto projection = project(point, T_world_camera, frame);
    ASSERT_TRUE(projection);
    constexpr double step = 1e-6;
    for (int k = 0; k < 6; ++k) {
      const auto at = [&](double h) {
        return project(point, T_world_camera * se3_exp(h * Vector6d::Unit(k)), frame)->pixel;
      };
      const Eigen::Vector2d numerical = (at(step) - at(-step)) / (2 * step);
      EXPECT_LT((projection->by_pose.col(k) - numerical).norm(), 1e-4) << "seed " << seed << " pose " << k;
    }
    for (int k = 0; k < 3; ++k) {
      const auto at = [&](double h) {
        MapPoint moved = point;
        moved.position[k] += h;
        return project(moved, T_world_camera, frame)->pixel;
      };
      const Eigen::Vector2d numerical = (at(step) - at(-step)) / (2 * step);
      EXPECT_LT((projection->by_point.col(k) - numerical).norm(), 1e-4) << "seed " << seed << " point " << k;
    }
  }
}

// innovation' S^-1 innovation has mean 2 and below 9.21 lie 99 %, when everything is drawn from what
// is stated.
TEST(Projection, TheInnovationIsAsLargeAsItsCovarianceSays) {
  const FeatureFrame frame = empty_frame();
  Random random(1);
  constexpr int runs = 4000;
  double sum = 0;
  int inside = 0;
  for (int i = 0; i < runs; ++i) {
    PredictedPose pose;
    pose.T_world_camera = se3_exp(random_twist(random, 1, 1));
    pose.covariance = diagonal(0.02, 0.01);
    const Eigen::Isometry3d truth = pose.T_world_camera * se3_exp(random_twist(random, 0.02, 0.01));
    MapPoint point;
    point.position = pose.T_world_camera *
                     Eigen::Vector3d(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(2, 5));
    point.covariance = 4e-4 * Eigen::Matrix3d::Identity();
    MapPoint actual = point;
    for (int k = 0; k < 3; ++k) actual.position[k] += 0.02 * random.normal();
    const auto predicted = project(point, pose.T_world_camera, frame), seen = project(actual, truth, frame);
    const Eigen::Vector2d innovation =
        seen->pixel + Eigen::Vector2d(random.normal(), random.normal()) - predicted->pixel;
    const Eigen::Matrix2d S = innovation_covariance(*predicted, point, pose, frame);
    const double squared = innovation.dot(S.llt().solve(innovation));
    sum += squared;
    inside += squared < GuidedSettings{}.chi_square;
  }
  EXPECT_NEAR(sum / runs, 2, 0.1);  // standard deviation 2 / sqrt(4000) = 0.03
  EXPECT_NEAR(double(inside) / runs, 0.99, 0.006);
}

TEST(Projection, PointsBehindTheCameraOrNotFiniteHaveNone) {
  MapPoint point;
  point.position = {0, 0, -1};
  EXPECT_FALSE(project(point, Eigen::Isometry3d::Identity(), empty_frame()));
  point.position = {0, 0, 0.05};
  EXPECT_FALSE(project(point, Eigen::Isometry3d::Identity(), empty_frame()));
  point.position = {NAN, 0, 1};
  EXPECT_FALSE(project(point, Eigen::Isometry3d::Identity(), empty_frame()));
}

TEST(GuidedMatching, FindsMoreThanTheWholeMapLetsPass) {
  int guided = 0, guided_right = 0, plain = 0, plain_right = 0;
  double innovations = 0;
  GuidedMatcher matcher;
  DescriptorSearch search({1, 1});
  constexpr int runs = 10;
  for (std::uint64_t seed = 1; seed <= runs; ++seed) {
    const Scene scene = make_scene(seed, 8000);
    ASSERT_EQ(scene.feature_of.size(), 300u);
    Random random(seed, 4);
    PredictedPose predicted;
    predicted.covariance = diagonal(0.02, 0.01);
    predicted.T_world_camera = scene.truth.T_world_camera * se3_exp(random_twist(random, 0.02, 0.01));
    const GuidedResult& found = matcher.match(scene.frame, predicted, scene.landmarks, scene.index);
    EXPECT_TRUE(found.supported()) << "seed " << seed;
    EXPECT_LT(found.by_chance, int(found.matches.size()) / 2) << "seed " << seed;
    innovations += found.mean_squared_innovation / runs;
    guided += int(found.matches.size());
    guided_right += count_right(scene, found.matches);
    const auto& whole = search.match(scene.frame.features, scene.index);
    plain += int(whole.size());
    plain_right += count_right(scene, whole);
  }
  std::printf(
      "[          ] guided: %d of %d right, whole map: %d of %d right; mean squared innovation %.2f\n",
      guided_right, guided, plain_right, plain, innovations);
  EXPECT_GT(guided_right, 2 * plain_right);
  EXPECT_GT(guided_right, 0.85 * guided);
  EXPECT_LT(innovations, 3);
}

TEST(GuidedMatching, AWrongPredictionIsReported) {
  GuidedMatcher matcher;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const Scene scene = make_scene(seed, 8000);
    Random random(seed, 5);
    PredictedPose wrong;
    wrong.covariance = diagonal(0.02, 0.01);
    Vector6d twist = random_twist(random, 0.02, 0.01);
    twist[3] += 0.3 + random.uniform();  // radians
    wrong.T_world_camera = scene.truth.T_world_camera * se3_exp(twist);
    const GuidedResult& found = matcher.match(scene.frame, wrong, scene.landmarks, scene.index);
    EXPECT_GT(found.in_view, 100) << "seed " << seed;
    EXPECT_FALSE(found.supported()) << "seed " << seed << ": " << found.matches.size() << ", by chance "
                                    << found.by_chance;
  }
}

TEST(GuidedMatching, AVaguePredictionIsReported) {
  const Scene scene = make_scene(1, 2000);
  PredictedPose vague = scene.truth;
  vague.covariance = diagonal(1, 1);
  GuidedMatcher matcher;
  const GuidedResult& found = matcher.match(scene.frame, vague, scene.landmarks, scene.index);
  EXPECT_GT(found.in_view, 20);
  EXPECT_EQ(found.too_vague, found.in_view);
  EXPECT_TRUE(found.matches.empty());
  EXPECT_FALSE(found.supported());
}

TEST(GuidedMatching, ALandmarkMappedTwiceIsNoRivalOfItself) {
  FeatureFrame frame = empty_frame();
  frame.features.resize(1);
  frame.features[0].x = 319.5f;
  frame.features[0].y = 239.5f;
  frame.features[0].descriptor.fill(128);
  DescriptorIndex index;
  std::vector<MapPoint> landmarks(2);
  for (int i = 0; i < 2; ++i) {
    landmarks[std::size_t(i)] = {i, {0, 0, 2}, 1e-4 * Eigen::Matrix3d::Identity()};
    index.insert(i, frame.features[0].descriptor, 0);
  }
  const PredictedPose pose{Eigen::Isometry3d::Identity(), diagonal(0.02, 0.02)};
  GuidedMatcher matcher;
  EXPECT_EQ(matcher.match(frame, pose, landmarks, index).matches.size(), 1u);
  landmarks[1].position.x() = 0.06;  // four standard deviations of the difference: another thing
  EXPECT_TRUE(matcher.match(frame, pose, landmarks, index).matches.empty());
}

TEST(GuidedMatching, EqualsDirectComparison) {
  const Scene scene = make_scene(3, 4000);
  PredictedPose predicted = scene.truth;
  predicted.covariance = diagonal(0.03, 0.02);
  const GuidedSettings settings;
  GuidedMatcher matcher;
  const GuidedResult& found = matcher.match(scene.frame, predicted, scene.landmarks, scene.index, settings);
  // Every pair whose innovation passes, without grid or boxes.
  std::vector<std::vector<std::pair<int, int>>> of_feature(scene.frame.features.size());
  std::map<int, std::vector<std::pair<int, int>>> of_landmark;
  int candidates = 0;
  for (const MapPoint& landmark : scene.landmarks) {
    const auto projection = project(landmark, predicted.T_world_camera, scene.frame);
    if (!projection) continue;
    const Eigen::Vector2d pixel = projection->pixel;
    if (pixel.x() < 0 || pixel.x() > 639 || pixel.y() < 0 || pixel.y() > 479) continue;
    const Eigen::Matrix2d S = innovation_covariance(*projection, landmark, predicted, scene.frame);
    if (std::sqrt(settings.chi_square * S.diagonal().maxCoeff()) > settings.max_gate) continue;
    for (std::size_t f = 0; f < scene.frame.features.size(); ++f) {
      const Feature& feature = scene.frame.features[f];
      if ((feature.laplacian >= 0) != scene.index.is_dark(landmark.id)) continue;
      const Eigen::Vector2d innovation = Eigen::Vector2d(feature.x, feature.y) - pixel;
      if (innovation.dot(S.inverse() * innovation) >= settings.chi_square) continue;
      ++candidates;
      const int d2 = squared_distance(feature.descriptor, scene.index.descriptor(landmark.id));
      of_feature[f].emplace_back(d2, landmark.id);
      of_landmark[landmark.id].emplace_back(d2, int(f));
    }
  }
  EXPECT_EQ(found.candidates, candidates);
  std::size_t expected = 0;
  for (std::size_t f = 0; f < of_feature.size(); ++f) {
    auto& offers = of_feature[f];
    if (offers.empty()) continue;
    std::sort(offers.begin(), offers.end());
    const int d2 = offers[0].first, id = offers[0].second;
    if (d2 > std::pow(127 * settings.max_distance, 2)) continue;
    const auto place = [&](int landmark) { return scene.landmarks[std::size_t(landmark / 5)].position; };
    const auto rival = std::find_if(offers.begin() + 1, offers.end(), [&](const auto& offer) {
      return (place(offer.second) - place(id)).squaredNorm() / 2e-4 >= 11.345;
    });
    if (rival != offers.end() && !(d2 < settings.ratio * settings.ratio * rival->first)) continue;
    auto& back = of_landmark[id];
    std::sort(back.begin(), back.end());
    if (back[0].second != int(f)) continue;
    if (back.size() > 1 && !(d2 < settings.ratio * settings.ratio * back[1].first)) continue;
    ASSERT_LT(expected, found.matches.size());
    EXPECT_EQ(found.matches[expected].a, int(f));
    EXPECT_EQ(found.matches[expected].b, id);
    EXPECT_EQ(found.matches[expected].distance2, d2);
    ++expected;
  }
  EXPECT_EQ(found.matches.size(), expected);
  EXPECT_GT(expected, 50u);
}

TEST(GuidedMatching, AllocatesNothingOnceWarm) {
  const Scene scene = make_scene(1, 2000);
  PredictedPose predicted = scene.truth;
  predicted.covariance = diagonal(0.02, 0.01);
  GuidedMatcher matcher;
  matcher.match(scene.frame, predicted, scene.landmarks, scene.index);
  const long before = heap_allocations();
  matcher.match(scene.frame, predicted, scene.landmarks, scene.index);
  EXPECT_EQ(heap_allocations(), before);
}

TEST(GuidedMatching, OddInputs) {
  Scene scene = make_scene(1, 500);
  scene.truth.covariance = diagonal(0.02, 0.01);
  GuidedMatcher matcher;
  scene.frame.features[0].x = NAN;
  scene.frame.features[1].y = -1e9f;
  scene.frame.features[2].x = 1e9f;
  scene.landmarks[0].position.setConstant(NAN);
  scene.landmarks[1].covariance.setConstant(INFINITY);
  EXPECT_FALSE(matcher.match(scene.frame, scene.truth, scene.landmarks, scene.index).matches.empty());
  EXPECT_TRUE(matcher.match(scene.frame, scene.truth, {}, scene.index).matches.empty());
  EXPECT_TRUE(matcher.match(empty_frame(), scene.truth, scene.landmarks, scene.index).matches.empty());

  const auto message = [&](auto change) -> std::string {
    FeatureFrame frame = scene.frame;
    PredictedPose pose = scene.truth;
    auto landmarks = scene.landmarks;
    GuidedSettings settings;
    change(frame, pose, landmarks, settings);
    try {
      matcher.match(frame, pose, landmarks, scene.index, settings);
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    return "nothing thrown";
  };
  EXPECT_THAT(message([](auto& f, auto&, auto&, auto&) { f.fx = 0; }), HasSubstr("fx"));
  EXPECT_THAT(message([](auto& f, auto&, auto&, auto&) { f.width = 0; }), HasSubstr("no size"));
  EXPECT_THAT(message([](auto&, auto& p, auto&, auto&) { p.covariance(2, 3) = NAN; }),
              HasSubstr("not finite"));
  EXPECT_THAT(message([](auto&, auto& p, auto&, auto&) { p.covariance(1, 1) = -1; }), HasSubstr("negative"));
  EXPECT_THAT(message([](auto&, auto&, auto& l, auto&) { l[3].id = 4; }), HasSubstr("id 4 is not in"));
  EXPECT_THAT(message([](auto&, auto&, auto&, auto& s) { s.chi_square = 0; }), HasSubstr("chi_square is 0"));
  EXPECT_THAT(message([](auto&, auto&, auto&, auto& s) { s.ratio = 2; }), HasSubstr("ratio is 2"));
  EXPECT_THAT(message([](auto&, auto&, auto&, auto& s) { s.max_gate = NAN; }), HasSubstr("max_gate"));
}

// Rendered images with known poses: every other view makes the map, those between query it.
struct RecordedRoom {
  std::vector<FeatureFrame> frames;
  std::vector<Eigen::Isometry3d> T_world_camera;

  RecordedRoom() {
    const auto folder = data_folder() / "livingroom1";
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
  const RecordedRoom room;
  if (room.frames.size() < 40) GTEST_SKIP() << "no livingroom1 in " << data_folder();
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
