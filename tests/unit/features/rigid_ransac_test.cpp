#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <set>
#include <stdexcept>

#include <lcmslam/features/rigid_ransac.hpp>

namespace lcmslam {
namespace {

using testing::HasSubstr;

// Two views of the same points, measured with the noise that the frames state; the first
// `outliers` matches join different points.
struct Views {
  FeatureFrame a, b;
  std::vector<Match> matches;
  Eigen::Isometry3d T_a_b = Eigen::Isometry3d::Identity();
};

Feature measured(const Eigen::Vector3d& true_point, const FeatureFrame& frame, double noise, Random& random) {
  Feature feature;
  feature.kind = MeasurementKind::point;
  feature.point = true_point.cast<float>();
  feature.depth_sigma = static_cast<float>(0.001 + 0.002 * true_point.z() * true_point.z());
  const Eigen::Matrix3d root = point_covariance(feature, frame).llt().matrixL();
  const Eigen::Vector3d white(random.normal(), random.normal(), random.normal());
  feature.point = (true_point + noise * (root * white)).cast<float>();
  return feature;
}

Views make_views(std::uint64_t seed, int count, int outliers, double noise = 1) {
  Random random(seed, 1);
  const auto normals = [&] { return Eigen::Vector3d(random.normal(), random.normal(), random.normal()); };
  Views views;
  views.a.fx = views.a.fy = 520;
  views.a.pixel_sigma = 1;
  views.b = views.a;
  Vector6d twist;
  twist << 0.1 * normals(), 0.1 * normals();
  views.T_a_b = se3_exp(twist);
  for (int i = 0; i < count; ++i) {
    const double z = random.uniform(1, 4);
    const Eigen::Vector3d in_b(random.uniform(-0.5, 0.5) * z, random.uniform(-0.4, 0.4) * z, z);
    views.b.features.push_back(measured(in_b, views.b, noise, random));
    views.a.features.push_back(measured(views.T_a_b * in_b, views.a, noise, random));
    views.matches.push_back({i, i < outliers ? (i + 1) % outliers : i, 0});
  }
  return views;
}

std::vector<PointPair> pairs_of(const Views& views) {
  std::vector<PointPair> pairs;
  for (const Match& m : views.matches) {
    const Feature& a = views.a.features[std::size_t(m.a)];
    const Feature& b = views.b.features[std::size_t(m.b)];
    pairs.push_back({a.point.cast<double>(), b.point.cast<double>(), point_covariance(a, views.a),
                     point_covariance(b, views.b)});
  }
  return pairs;
}

Vector6d error_of(const RigidRansacResult& result, const Views& views) {
  return se3_log(result.T_a_b.inverse() * views.T_a_b);
}

TEST(RigidRansac, ExactPointsGiveTheExactMotion) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const Views views = make_views(seed, 60, 30, 0);
    Random random(seed);
    const auto result = align_ransac(views.a, views.b, views.matches, {}, random);
    ASSERT_TRUE(result.success) << "seed " << seed << ": " << result.reason;
    EXPECT_LT(error_of(result, views).norm(), 1e-5) << "seed " << seed;  // points are floats
    std::set<int> inliers(result.inliers.begin(), result.inliers.end());
    for (int i = 30; i < 60; ++i) EXPECT_TRUE(inliers.count(i)) << "seed " << seed << " match " << i;
  }
}

TEST(RigidRansac, FindsTheMotionAmongHalfOutliers) {
  int kept = 0, wrong = 0;
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    const Views views = make_views(seed, 200, 100);
    Random random(seed);
    const auto result = align_ransac(views.a, views.b, views.matches, {}, random);
    ASSERT_TRUE(result.success) << "seed " << seed << ": " << result.reason;
    EXPECT_TRUE(result.reason.empty());
    EXPECT_TRUE(std::is_sorted(result.inliers.begin(), result.inliers.end()));
    EXPECT_LT(error_of(result, views).head<3>().norm(), 0.02) << "seed " << seed;
    EXPECT_LT(error_of(result, views).tail<3>().norm(), 0.01) << "seed " << seed;
    for (int i : result.inliers) ++(i < 100 ? wrong : kept);
  }
  EXPECT_GT(kept, 0.975 * 40 * 100);  // the limit lets 99 % pass
  EXPECT_LT(wrong, 0.01 * 40 * 100);
}

// NEES: error' S^-1 error has mean 6 when the covariance tells the truth; over 300 runs its average has
// a standard deviation of sqrt(12 / 300) = 0.2.
TEST(RigidRansac, TheCovarianceTellsTheTruth) {
  double sum = 0;
  constexpr int runs = 300;
  for (std::uint64_t seed = 1; seed <= runs; ++seed) {
    const Views views = make_views(1000 + seed, 80, 20);
    Random random(seed);
    const auto result = align_ransac(views.a, views.b, views.matches, {}, random);
    ASSERT_TRUE(result.success) << "seed " << seed << ": " << result.reason;
    const Vector6d error = error_of(result, views);
    sum += error.dot(result.covariance.ldlt().solve(error));
  }
  std::printf("[          ] NEES average %.3f over %d runs (6 expected)\n", sum / runs, runs);
  EXPECT_NEAR(sum / runs, 6, 0.8);
}

TEST(RigidRansac, RefinementStandsAtTheMinimum) {
  const Views views = make_views(5, 50, 0);
  const auto pairs = pairs_of(views);
  std::vector<int> indices(pairs.size());
  for (std::size_t i = 0; i < indices.size(); ++i) indices[i] = int(i);
  Eigen::Isometry3d refined = views.T_a_b;
  Matrix6d covariance;
  ASSERT_TRUE(refine_rigid(pairs, indices, refined, covariance));
  // Weights held at the solution, as iteratively re-weighted least squares does.
  std::vector<Eigen::Matrix3d> information;
  for (const auto& p : pairs)
    information.push_back(
        (p.covariance_a + refined.linear() * p.covariance_b * refined.linear().transpose()).inverse());
  const auto cost = [&](const Vector6d& twist) {
    double sum = 0;
    for (std::size_t i = 0; i < pairs.size(); ++i) {
      const Eigen::Vector3d e = pairs[i].point_a - refined * se3_exp(twist) * pairs[i].point_b;
      sum += e.dot(information[i] * e);
    }
    return 0.5 * sum;
  };
  const Matrix6d normal = covariance.inverse();
  for (int k = 0; k < 6; ++k) {
    const double sigma = std::sqrt(covariance(k, k)), step = 0.01 * sigma;
    const Vector6d ahead = step * Vector6d::Unit(k);
    // Gradient 0 in units of its own deviation; curvature the normal matrix.
    EXPECT_NEAR((cost(ahead) - cost(-ahead)) / (2 * step) * sigma, 0, 1e-3) << "component " << k;
    const double curvature = (cost(ahead) - 2 * cost(Vector6d::Zero()) + cost(-ahead)) / (step * step);
    EXPECT_NEAR(curvature / normal(k, k), 1, 0.05) << "component " << k;
  }
}

TEST(RigidRansac, WeightsPointsByTheirNoise) {
  Views views = make_views(6, 60, 0);
  const auto pairs = pairs_of(views);
  std::vector<int> all(60);
  for (int i = 0; i < 60; ++i) all[std::size_t(i)] = i;
  Eigen::Isometry3d weighted = views.T_a_b;
  Matrix6d covariance;
  ASSERT_TRUE(refine_rigid(pairs, all, weighted, covariance));
  // A hundred times the variance: a hundred times the covariance, the same motion.
  auto louder = pairs;
  for (auto& p : louder) {
    p.covariance_a *= 100;
    p.covariance_b *= 100;
  }
  Eigen::Isometry3d same = views.T_a_b;
  Matrix6d larger;
  ASSERT_TRUE(refine_rigid(louder, all, same, larger));
  EXPECT_LT(se3_log(weighted.inverse() * same).norm(), 1e-6);
  EXPECT_LT((larger - 100 * covariance).norm(), 1e-4 * larger.norm());
}

TEST(RigidRansac, SameSeedSameBits) {
  const Views views = make_views(7, 100, 60);
  Random first(3), second(3);
  const auto a = align_ransac(views.a, views.b, views.matches, {}, first);
  const auto b = align_ransac(views.a, views.b, views.matches, {}, second);
  EXPECT_EQ(a.T_a_b.matrix(), b.T_a_b.matrix());
  EXPECT_EQ(a.covariance, b.covariance);
  EXPECT_EQ(a.inliers, b.inliers);
  EXPECT_EQ(a.iterations, b.iterations);
}

TEST(RigidRansac, StopsEarlyWhenMostAgree) {
  RigidRansacSettings settings;
  settings.max_iterations = 5000;
  Random random(1);
  const Views good = make_views(8, 300, 0), bad = make_views(8, 300, 200);
  const int easy = align_ransac(good.a, good.b, good.matches, settings, random).iterations;
  const auto hard = align_ransac(bad.a, bad.b, bad.matches, settings, random);
  EXPECT_TRUE(hard.success) << hard.reason;
  EXPECT_LT(easy, 100);
  EXPECT_GT(hard.iterations, easy);
  EXPECT_LT(hard.iterations, settings.max_iterations);
}

// As many samples as make it likely that one of them held three inliers (Fischler & Bolles 1981).
TEST(RigidRansac, GoesOnUntilThreeInliersWereLikelyDrawn) {
  const RigidRansacSettings settings;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const Views views = make_views(seed, 60, 30);
    Random random(seed);
    const RigidRansacResult result = align_ransac(views.a, views.b, views.matches, settings, random);
    ASSERT_TRUE(result.success) << "seed " << seed;
    const double share = static_cast<double>(result.inliers.size()) / 60;
    const double needed = std::log(1 - settings.confidence) / std::log1p(-share * share * share);
    EXPECT_GT(result.iterations, 0.9 * needed) << "seed " << seed;
  }
}

TEST(RigidRansac, MatchesWithoutDepthAreLeftOut) {
  Views views = make_views(9, 60, 0);
  for (int i = 0; i < 60; i += 2) views.a.features[std::size_t(i)].kind = MeasurementKind::bearing;
  views.b.features[1].point.setConstant(NAN);
  views.b.features[3].depth_sigma = NAN;
  Random random(1);
  const auto result = align_ransac(views.a, views.b, views.matches, {}, random);
  ASSERT_TRUE(result.success) << result.reason;
  for (int i : result.inliers) {
    EXPECT_EQ(i % 2, 1);
    EXPECT_GT(i, 3);
  }
  EXPECT_GT(result.inliers.size(), 24u);
}

TEST(RigidRansac, FailuresSayWhy) {
  Random random(1);
  const auto reason = [&](const Views& views) {
    const auto result = align_ransac(views.a, views.b, views.matches, {}, random);
    EXPECT_FALSE(result.success);
    EXPECT_TRUE(result.T_a_b.matrix().allFinite());
    return result.reason;
  };
  EXPECT_THAT(reason(make_views(1, 0, 0)), HasSubstr("0 matches with depth, 12 needed"));
  EXPECT_THAT(reason(make_views(1, 11, 0)), HasSubstr("11 matches with depth, 12 needed"));
  EXPECT_THAT(reason(make_views(1, 40, 40)), HasSubstr("inliers, 12 needed"));

  Views line = make_views(2, 30, 0);
  for (int i = 0; i < 30; ++i)
    line.a.features[std::size_t(i)].point = line.b.features[std::size_t(i)].point =
        Eigen::Vector3f(0.02f * float(i), 0.01f * float(i), 2.f);
  EXPECT_FALSE(reason(line).empty());
  Views heap = make_views(2, 30, 0);
  for (int i = 0; i < 30; ++i)
    heap.a.features[std::size_t(i)].point = heap.b.features[std::size_t(i)].point =
        Eigen::Vector3f(0.f, 0.f, 2.f);
  EXPECT_FALSE(reason(heap).empty());

  // Points on one line leave the turn about it free.
  auto pairs = pairs_of(line);
  std::vector<int> all(30);
  for (int i = 0; i < 30; ++i) all[std::size_t(i)] = i;
  Eigen::Isometry3d T_a_b = Eigen::Isometry3d::Identity();
  Matrix6d covariance;
  EXPECT_FALSE(refine_rigid(pairs, all, T_a_b, covariance));
}

TEST(RigidRansac, FindsTheMotionFromTwentyToEightyPercentOutliers) {
  for (const double outliers : {0.2, 0.4, 0.6, 0.8}) {
    int found = 0;
    constexpr int runs = 60;
    for (std::uint64_t seed = 1; seed <= runs; ++seed) {
      const Views views = make_views(100 + seed, 150, int(150 * outliers));
      Random random(seed);
      const auto result = align_ransac(views.a, views.b, views.matches, {}, random);
      const Vector6d error = error_of(result, views);
      found += result.success && error.dot(result.covariance.ldlt().solve(error)) < 35;  // of 6 DoF
    }
    EXPECT_GE(found, runs - 1) << outliers << " outliers";
  }
}

// Local optimisation makes up for the noise of three points: about as few samples as theory asks for.
TEST(RigidRansac, NeedsNoMoreSamplesThanWithoutNoise) {
  double tried = 0;
  constexpr int runs = 40;
  for (std::uint64_t seed = 1; seed <= runs; ++seed) {
    const Views views = make_views(200 + seed, 200, 100);
    Random random(seed);
    tried += align_ransac(views.a, views.b, views.matches, {}, random).iterations / double(runs);
  }
  const double in_theory = std::log(0.001) / std::log1p(-0.125);  // 52
  EXPECT_LT(tried, 1.15 * in_theory);
}

// Noise spreads points of a line or a heap, as if they fixed the motion: refused, never wrong and sure.
TEST(RigidRansac, NoisyLinesAndHeapsAreRefusedPlanesAndSpotsAreNot) {
  enum Shape { line, heap, plane, spot };
  for (const Shape shape : {line, heap, plane, spot})
    for (std::uint64_t seed = 1; seed <= 40; ++seed) {
      Random random(seed, 6);
      Views views = make_views(seed, 0, 0);
      for (int i = 0; i < 60; ++i) {
        const double s = random.uniform(-0.6, 0.6), t = random.uniform(-0.6, 0.6), u = random.normal();
        Eigen::Vector3d in_b(0.1, 0.2, 2.5);
        if (shape == line) in_b += s * Eigen::Vector3d(0.8, 0.3, 0.5);
        if (shape == plane) in_b += Eigen::Vector3d(s, t, 0.2 * s);
        if (shape == spot) in_b += 0.15 * Eigen::Vector3d(s, t, u);
        views.b.features.push_back(measured(in_b, views.b, 1, random));
        views.a.features.push_back(measured(views.T_a_b * in_b, views.a, 1, random));
        views.matches.push_back({i, i < 15 ? (i + 1) % 15 : i, 0});
      }
      const auto result = align_ransac(views.a, views.b, views.matches, {}, random);
      EXPECT_EQ(result.success, shape == plane || shape == spot)
          << "shape " << shape << ", seed " << seed << ": " << result.reason;
      if (!result.success) continue;
      const Vector6d error = error_of(result, views);
      EXPECT_LT(error.dot(result.covariance.ldlt().solve(error)), 35)
          << "shape " << shape << ", seed " << seed;
    }
}

TEST(RigidRansac, PairsThatAreNoMeasurementsAreNeverInliers) {
  const Views views = make_views(3, 60, 0);
  auto pairs = pairs_of(views);
  pairs[0].point_a.x() = NAN;
  pairs[1].covariance_b(0, 0) = INFINITY;
  pairs[2].covariance_a = -pairs[2].covariance_a;
  pairs[3].covariance_a.setZero();
  Random random(1);
  const auto result = align_ransac(pairs, {}, random);
  ASSERT_TRUE(result.success) << result.reason;
  EXPECT_GT(result.inliers.front(), 3);
  EXPECT_GT(result.inliers.size(), 50u);
}

TEST(RigidRansac, AMatchOfAFeatureThatDoesNotExistIsNamed) {
  Views views = make_views(3, 20, 0);
  Random random(1);
  const auto message = [&](Match match) -> std::string {
    auto matches = views.matches;
    matches[7] = match;
    try {
      align_ransac(views.a, views.b, matches, {}, random);
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    return "nothing thrown";
  };
  EXPECT_THAT(message({20, 0, 0}), HasSubstr("match 7 names feature 20 of frame a, which has 20"));
  EXPECT_THAT(message({0, -1, 0}), HasSubstr("match 7 names feature -1 of frame b, which has 20"));
}

TEST(RigidRansac, RefusesWrongSettings) {
  Random random(1);
  const auto message = [&](auto change) -> std::string {
    RigidRansacSettings settings;
    change(settings);
    try {
      align_ransac({}, settings, random);
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    return "nothing thrown";
  };
  EXPECT_THAT(message([](auto& s) { s.min_inliers = 2; }), HasSubstr("min_inliers is 2"));
  EXPECT_THAT(message([](auto& s) { s.max_iterations = 0; }), HasSubstr("max_iterations is 0"));
  EXPECT_THAT(message([](auto& s) { s.confidence = 1; }), HasSubstr("confidence"));
  EXPECT_THAT(message([](auto& s) { s.chi_square = NAN; }), HasSubstr("chi_square"));
  EXPECT_THAT(message([](auto& s) { s.max_refinements = 0; }), HasSubstr("max_refinements is 0"));
}

}  // namespace
}  // namespace lcmslam
