// The feature study's evaluation on matches whose truth is known, and the study in small on a recording.

#include "tools/study/feature_study.hpp"
#include "tests/support/recordings.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <nlohmann/json.hpp>

#include <lcmslam/geometry/random.hpp>
#include <lcmslam/geometry/transform.hpp>

namespace lcmslam {
namespace {

using ::testing::ElementsAre;

constexpr double depth_m = 2;
const cv::Matx33d pinhole(500, 0, 320, 0, 500, 240, 0, 0, 1);

/// A wall at right angles to the view, 2 m away.
StudyView wall() {
  return {cv::Mat::zeros(480, 640, CV_8UC1), cv::Mat(480, 640, CV_32FC1, cv::Scalar(depth_m)), pinhole};
}

/// Camera b stands to the left of a, so that what a sees at x, b sees `pixels` further right.
Eigen::Isometry3d shift(double pixels) {
  Eigen::Isometry3d T_b_a = Eigen::Isometry3d::Identity();
  T_b_a.translation().x() = pixels * depth_m / pinhole(0, 0);
  return T_b_a;
}

ImageFeatures features_at(const std::vector<cv::Point2f>& places) {
  ImageFeatures features;
  for (const cv::Point2f& place : places) features.keypoints.emplace_back(place, 10.f);
  return features;
}

FeatureScore score(const StudyView& a, const StudyView& b, double pixels,
                   const std::vector<cv::Point2f>& in_a, const std::vector<cv::Point2f>& in_b,
                   const std::vector<cv::Vec2i>& matches) {
  return score_features(a, b, shift(pixels), features_at(in_a), features_at(in_b), matches, {});
}

TEST(FeatureEvaluation, TolerancesAreInPixelsOfTheSecondImage) {
  const FeatureScore s =
      score(wall(), wall(), 20, {{100, 100}, {200, 200}, {300, 300}, {400, 400}},
            {{122.5f, 100}, {224, 200}, {320, 306}, {420, 400}}, {{0, 0}, {1, 1}, {2, 2}, {3, 3}});
  EXPECT_EQ(s.visible, 4);
  EXPECT_EQ(s.repeated, 2);  // 2.5 and 0 pixels off, not 4 and 6
  EXPECT_EQ(s.matches, 4);
  EXPECT_EQ(s.correct, 3);  // all but the one that is 6 pixels off
}

TEST(FeatureEvaluation, RepeatabilityLooksAtPlacesAndNotAtMatches) {
  const FeatureScore s =
      score(wall(), wall(), 0, {{100, 100}, {200, 200}}, {{200, 200}, {100, 100}}, {{0, 0}, {1, 1}});
  EXPECT_EQ(s.repeated, 2);
  EXPECT_EQ(s.correct, 0);
}

TEST(FeatureEvaluation, KeypointsOutsideTheOtherImageDoNotCount) {
  // Of a, the last moves out of b's image; of b, the first lies where a does not look.
  const FeatureScore s =
      score(wall(), wall(), 100, {{100, 100}, {600, 100}}, {{50, 100}, {200, 100}}, {{0, 1}, {1, 0}});
  EXPECT_EQ(s.visible, 1);
  EXPECT_EQ(s.repeated, 1);
  EXPECT_EQ(s.matches, 2);  // but a match to nowhere is a wrong one
  EXPECT_EQ(s.correct, 1);
}

TEST(FeatureEvaluation, RepeatabilityIsOfTheImageWithFewerKeypoints) {
  const FeatureScore s =
      score(wall(), wall(), 0, {{100, 100}, {200, 100}, {300, 100}, {400, 100}}, {{100, 100}, {555, 99}}, {});
  EXPECT_EQ(s.visible, 2);
  EXPECT_DOUBLE_EQ(s.repeatability(), 0.5);
}

TEST(FeatureEvaluation, AClusterOnOneKeypointIsFoundAgainOnce) {
  const FeatureScore s = score(wall(), wall(), 0, {{100, 100}, {101, 100}, {100, 101}, {300, 300}},
                               {{100, 100}, {500, 100}, {400, 100}, {450, 200}}, {});
  EXPECT_DOUBLE_EQ(s.repeatability(), 0.25);
}

TEST(FeatureEvaluation, OnlyWhatHasDepthAtBothEndsCounts) {
  StudyView a = wall(), b = wall();
  a.depth(cv::Rect(90, 90, 20, 20)) = 0;
  b.depth(cv::Rect(190, 190, 20, 20)) = 0;
  const std::vector<cv::Point2f> places = {{100, 100}, {200, 200}, {300, 300}};
  const FeatureScore s = score(a, b, 0, places, places, {{0, 0}, {1, 1}, {2, 2}});
  EXPECT_EQ(s.visible, 1);
  EXPECT_EQ(s.repeated, 1);
  EXPECT_EQ(s.matches, 1);
  EXPECT_EQ(s.correct, 1);
}

TEST(FeatureEvaluation, WithoutAnythingThereIsNoDivisionByZero) {
  const FeatureScore s = score(wall(), wall(), 0, {}, {}, {});
  EXPECT_EQ(s.repeatability(), 0);
  EXPECT_EQ(s.precision(), 0);
}

TEST(FeatureMatching, IsMutualWithTheRatio) {
  // Row 0 finds row 1; row 1 stands between two equal ones; row 2's nearest prefers row 0.
  const cv::Mat a = (cv::Mat_<float>(3, 2) << 0, 0, 10, 0, 0, 1);
  const cv::Mat b = (cv::Mat_<float>(3, 2) << 10, 3, 0, 0.1f, 10, -3);
  const auto matches = mutual_matches(a, b, cv::NORM_L2, 0.8);
  EXPECT_THAT(matches, ElementsAre(cv::Vec2i(0, 1)));
  EXPECT_EQ(mutual_matches(a, b, cv::NORM_L2, 1).size(), 1u);  // equal is not nearer
  EXPECT_TRUE(mutual_matches(a, cv::Mat(), cv::NORM_L2, 0.8).empty());
}

TEST(FeatureMatching, CountsBitsOfBinaryDescriptors) {
  const cv::Mat a = (cv::Mat_<uchar>(1, 2) << 0x00, 0xff);
  const cv::Mat b = (cv::Mat_<uchar>(2, 2) << 0x80, 0xff, 0x07, 0xff);  // 1 and 3 bits, but 128 and 7
  EXPECT_THAT(mutual_matches(a, b, cv::NORM_HAMMING, 0.8), ElementsAre(cv::Vec2i(0, 0)));
}

/// Points before a camera that then moves, and `wrong` more whose pixels mean nothing.
struct Motion {
  Eigen::Isometry3d T_b_a;
  PointsAndPixels pool;

  Motion(int right, int wrong) {
    T_b_a = se3_exp((Vector6d() << 0.1, -0.05, 0.07, 0.05, 0.1, -0.08).finished());
    Random random(7);
    for (int i = 0; i < right + wrong; ++i) {
      const Eigen::Vector3d p(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(2, 4));
      const Eigen::Vector3d q = T_b_a * p;
      pool.points.emplace_back(float(p.x()), float(p.y()), float(p.z()));
      if (i < right)
        pool.pixels.emplace_back(float(500 * q.x() / q.z() + 320), float(500 * q.y() / q.z() + 240));
      else
        pool.pixels.emplace_back(float(random.uniform(0, 640)), float(random.uniform(0, 480)));
    }
  }
};

TEST(ReferencePose, IsTheMotionThatMostMatchesAgreeOn) {
  const Motion motion(60, 30);
  const auto T_b_a = reference_pose(motion.pool, pinhole, motion.T_b_a, {});
  ASSERT_TRUE(T_b_a);
  EXPECT_LT(se3_log(motion.T_b_a.inverse() * *T_b_a).norm(), 1e-4);
  const auto again = reference_pose(motion.pool, pinhole, motion.T_b_a, {});
  EXPECT_TRUE(again && again->matrix() == T_b_a->matrix());
}

TEST(ReferencePose, NeedsEnoughInliers) {
  const Motion few(20, 30);
  EXPECT_FALSE(reference_pose(few.pool, pinhole, few.T_b_a, {}));
  EXPECT_FALSE(reference_pose({}, pinhole, few.T_b_a, {}));
}

TEST(ReferencePose, MustAgreeWithTheRecording) {
  const Motion motion(60, 0);
  const auto recorded = [&](double x, double degrees) -> Eigen::Isometry3d {
    return motion.T_b_a * se3_exp((Vector6d() << x, 0, 0, 0, 0, degrees * CV_PI / 180).finished());
  };
  EXPECT_TRUE(reference_pose(motion.pool, pinhole, recorded(0.2, 0), {}));
  EXPECT_FALSE(reference_pose(motion.pool, pinhole, recorded(0.3, 0), {}));
  EXPECT_TRUE(reference_pose(motion.pool, pinhole, recorded(0, 7), {}));
  EXPECT_FALSE(reference_pose(motion.pool, pinhole, recorded(0, 9), {}));
}

TEST(FeatureMethods, StrongestComeFirstWithTheirDescriptors) {
  ImageFeatures features = features_at({{1, 0}, {2, 0}, {3, 0}});
  features.keypoints[1].response = 5;
  features.keypoints[2].response = 7;
  features.descriptors = (cv::Mat_<float>(3, 1) << 1, 2, 3);
  const ImageFeatures two = first_features(strongest_first(features), 2);
  ASSERT_EQ(two.keypoints.size(), 2u);
  EXPECT_EQ(two.keypoints[0].pt.x, 3);
  EXPECT_EQ(cv::countNonZero(two.descriptors != (cv::Mat_<float>(2, 1) << 3, 2)), 0);
}

TEST(FeatureMethods, KeypointsWithoutDepthAreDroppedWithTheirDescriptors) {
  StudyView view = wall();
  view.depth(cv::Rect(190, 90, 20, 20)) = 0;
  ImageFeatures features = features_at({{100, 100}, {200, 100}, {300, 100}});
  features.descriptors = (cv::Mat_<float>(3, 1) << 1, 2, 3);
  const ImageFeatures kept = with_depth(features, view);
  ASSERT_EQ(kept.keypoints.size(), 2u);
  EXPECT_EQ(kept.keypoints[1].pt.x, 300);
  EXPECT_EQ(cv::countNonZero(kept.descriptors != (cv::Mat_<float>(2, 1) << 1, 3)), 0);
}

std::optional<FeatureScore> scored(int visible, int repeated, int matches, int correct) {
  FeatureScore score;
  score.visible = visible;
  score.repeated = repeated;
  score.matches = matches;
  score.correct = correct;
  return score;
}

TEST(ScoreComparison, OfEqualDifferencesIsCertain) {
  std::vector<std::optional<FeatureScore>> a, b;
  for (int i = 0; i < 9; ++i) {
    a.push_back(i == 4 ? std::nullopt : scored(100, 30 + i, 50, 40));
    b.push_back(i == 4 ? std::nullopt : scored(100, 20 + i, 50, 20));
  }
  const ScoreComparison c = compare_scores(a, b, {});
  for (double value : {c.repeatability.value, c.repeatability.low, c.repeatability.high})
    EXPECT_NEAR(value, 0.1, 1e-12);
  for (double value : {c.correct.value, c.correct.low, c.correct.high}) EXPECT_NEAR(value, 2, 1e-12);
  EXPECT_NEAR(c.precision.value, 0.4, 1e-12);
}

// The standard error of a mean is known: sigma / sqrt(n), 1.96 of them to each side. Blocks of starts
// that score alike count as one.
TEST(ScoreComparison, IntervalsAreAsWideAsTheMeansScatter) {
  for (const int block : {1, 4}) {
    Random random(3);
    std::vector<std::optional<FeatureScore>> a, b;
    double sum = 0, sum2 = 0;
    constexpr int blocks = 100;
    for (int i = 0; i < blocks; ++i) {
      const int repeated = 500 + int(random.below(200));
      for (int k = 0; k < block; ++k) {
        a.push_back(scored(1000, repeated, 10, 5));
        b.push_back(scored(1000, 500, 10, 5));
      }
      const double d = (repeated - 500) / 1000.;
      sum += d;
      sum2 += d * d;
    }
    const double mean = sum / blocks, sigma = std::sqrt(sum2 / blocks - mean * mean);
    BootstrapSettings settings;
    settings.block = block;
    const Interval i = compare_scores(a, b, settings).repeatability;
    EXPECT_NEAR(i.value, mean, 1e-12);
    const double half_width = 1.96 * sigma / std::sqrt(blocks);
    // Blocks are drawn at any start: their means scatter a little less than those of the true blocks.
    EXPECT_NEAR((i.high - i.low) / (2 * half_width), block == 1 ? 1 : 0.83, 0.12) << "blocks of " << block;
    const Interval again = compare_scores(a, b, settings).repeatability;
    EXPECT_EQ(again.low, i.low);
    EXPECT_EQ(again.high, i.high);
  }
}

TEST(ScoreComparison, WithoutPairsIsNotANumberAndOfOtherPairsRefused) {
  EXPECT_TRUE(std::isnan(compare_scores({std::nullopt}, {std::nullopt}, {}).correct.low));
  EXPECT_THROW(compare_scores({std::nullopt}, {scored(1, 1, 1, 1)}, {}), std::invalid_argument);
  EXPECT_THROW(compare_scores({}, {std::nullopt}, {}), std::invalid_argument);
  EXPECT_THROW(compare_scores({}, {}, {2000, 0}), std::invalid_argument);
}

TEST(FeatureStudy, StartsAreSpreadAndLeaveRoom) {
  EXPECT_THAT(spread_starts(130, 30, 5), ElementsAre(9, 29, 49, 69, 89));
  EXPECT_THROW(spread_starts(30, 30, 5), std::invalid_argument);
}

TEST(FeatureStudy, RefusesSettingsThatMeanNothing) {
  FeatureStudySettings settings;
  EXPECT_NO_THROW(settings.check());
  settings.apart = {15, 5};
  EXPECT_THROW(settings.check(), std::invalid_argument);
  settings = {};
  settings.starts = 0;
  EXPECT_THROW(settings.check(), std::invalid_argument);
}

TEST(FeatureStudy, TwoPairsOfARecording) {
  LCMSLAM_SKIP_WITHOUT("tum_fr1_rpy");
  const auto source = open_dataset(recording_path("tum_fr1_rpy"));
  FeatureStudySettings settings;
  settings.apart = {5};
  settings.starts = 2;
  FeatureMethods methods = all_feature_methods(settings.keypoints);
  const FeatureStudyResult result = study_features(*source, methods, settings);

  ASSERT_EQ(result.left_out.front() + result.unreadable, 0);
  for (const MethodResult& method : result.methods) {
    SCOPED_TRACE(method.row.name);
    const DistanceScore& s = method.scores.front();
    EXPECT_EQ(s.pairs, 2);
    // Five frames apart every one of these methods finds and matches much; a wrong pose, depth or lens
    // model leaves next to nothing.
    EXPECT_GT(s.repeatability, 0.35);
    EXPECT_GT(s.precision, 0.7);
    EXPECT_GT(s.correct, 50);
    EXPECT_LE(s.keypoints, settings.keypoints);
  }
  const nlohmann::json json = feature_json(result, settings);
  EXPECT_EQ(json.at("methods").size(), result.methods.size());
  EXPECT_NEAR(json.at("methods").at(0).at("curve").at(0).at("precision").get<double>(),
              result.methods[0].scores[0].precision, 1e-12);
  // Ours, as many as dlib: the pairs' interval is around what the table shows.
  for (const MethodResult& method : result.methods) {
    if (method.against_dlib.empty()) continue;
    const Interval& i = method.against_dlib.front().repeatability;
    EXPECT_LE(i.low, i.value);
    EXPECT_GE(i.high, i.value);
  }
  const std::string csv = feature_csv(result), table = feature_table(result);
  EXPECT_EQ(std::size_t(std::count(csv.begin(), csv.end(), '\n')), 1 + result.methods.size());
  EXPECT_THAT(table, ::testing::HasSubstr("5 frames apart: 2 pairs, 0 left out"));
}

}  // namespace
}  // namespace lcmslam
