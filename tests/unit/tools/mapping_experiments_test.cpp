// The study's experiments on mapping: what they are made of, and that two of them say what is true.

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <set>
#include <stdexcept>

#include <lcmslam/geometry/random.hpp>
#include "tools/study/report/image_changes.hpp"
#include "tools/study/report/judgements.hpp"
#include "tools/study/report/mapping_parts.hpp"
#include "tools/study/report/mapping_run.hpp"
#include "tools/study/report/result_parts.hpp"

namespace lcmslam {
namespace {

Experiment experiment_named(const std::string& name) {
  for (Experiment& experiment : mapping_experiments())
    if (experiment.name == name) return experiment;
  throw std::invalid_argument("no experiment " + name);
}

StudyContext quick_context(std::vector<int> seeds) {
  StudyContext context;
  context.quick = true;
  context.seeds = std::move(seeds);
  context.work = std::filesystem::temp_directory_path() / "lcmslam_mapping_experiments";
  return context;
}

/// What the report would store, without what may differ.
nlohmann::json told(const ExperimentResult& result) {
  nlohmann::json json = {{"finding", result.finding}, {"settings", result.settings}};
  for (const ResultTable& table : result.tables) json["tables"].push_back(table.rows);
  for (const Chart& chart : result.charts)
    for (const ChartSeries& series : chart.series) json["charts"].push_back({series.x, series.y});
  return json;
}

TEST(MappingExperiments, HaveNamesOfTheirOwn) {
  std::set<std::string> names;
  for (const Experiment& experiment : mapping_experiments()) {
    EXPECT_TRUE(names.insert(experiment.name).second) << experiment.name;
    EXPECT_FALSE(experiment.title.empty());
  }
  EXPECT_GE(names.size(), 10U);
}

// Figures 2.1 and 2.2. A landmark at (2, 0.6) m before the robot: its sigma across grows by the heading's.
TEST(MappingExperiments, SampledPosesHaveTheNoisesCovariance) {
  const Experiment experiment = experiment_named("sampled-poses");
  constexpr int seeds = 40;
  constexpr double way = 0.05 * 0.05, turn = 0.01 * 0.01, px = 2, py = 0.6;  // thesis_preset()
  Eigen::Matrix2d sums[2] = {Eigen::Matrix2d::Zero(), Eigen::Matrix2d::Zero()};
  double samples = 0;
  for (int seed = 1; seed <= seeds; ++seed) {
    const ExperimentResult result = experiment.run(quick_context({seed}));
    ASSERT_EQ(result.charts.size(), 2U);
    for (std::size_t chart = 0; chart < 2; ++chart) {
      const ChartSeries& points = result.charts[chart].series.front();
      ASSERT_EQ(points.x.size(), 100U);
      Eigen::Vector2d mean = Eigen::Vector2d::Zero();
      for (std::size_t i = 0; i < points.x.size(); ++i)
        mean += Eigen::Vector2d(points.x[i], points.y[i]) / 100;
      for (std::size_t i = 0; i < points.x.size(); ++i) {
        const Eigen::Vector2d d = Eigen::Vector2d(points.x[i], points.y[i]) - mean;
        sums[chart] += d * d.transpose();
      }
    }
    samples += 99;
  }
  Eigen::Matrix2d theory[2];
  theory[0] << way, 0, 0, way;
  theory[1] << way + turn * py * py, -turn * px * py, -turn * px * py, way + turn * px * px;
  for (const int i : {0, 1}) {
    // The standard deviation of a variance of n samples is sqrt(2 / n) of it.
    const Eigen::Matrix2d S = sums[i] / samples;
    const double four_sigmas = 4 * std::sqrt(2 / samples);
    EXPECT_NEAR(S(0, 0) / theory[i](0, 0), 1, four_sigmas) << i;
    EXPECT_NEAR(S(1, 1) / theory[i](1, 1), 1, four_sigmas) << i;
    EXPECT_NEAR(S(0, 1) / theory[i](0, 0), theory[i](0, 1) / theory[i](0, 0), four_sigmas) << i;
  }
}

TEST(MappingExperiments, SampledPosesAgreeWithTheoryOverManySeeds) {
  std::vector<int> seeds;
  for (int seed = 101; seed <= 140; ++seed) seeds.push_back(seed);
  const ExperimentResult result = experiment_named("sampled-poses").run(quick_context(seeds));
  EXPECT_EQ(result.agreement, Agreement::agrees);
  int inside = 0;
  for (const auto& row : result.tables.at(0).rows) inside += row.back() == "yes" ? 1 : 0;
  EXPECT_GE(inside, 68) << "of 80, 76 are expected";
}

// Figure 2.10, twice from the rendering on: nothing may depend on threads or time.
TEST(MappingExperiments, NoiseOnThePathIsTakenAwayAndTheResultIsTheSameAgain) {
  const ExperimentResult result = experiment_named("path-noise").run(quick_context({1}));
  std::map<std::string, std::vector<double>> before, after;
  for (const auto& row : result.tables.at(0).rows) {
    const std::string name = row[0].get<std::string>() + " " + row[1].get<std::string>();
    before[name].push_back(row[3].get<double>());
    after[name].push_back(row[4].get<double>());
  }
  ASSERT_EQ(before.size(), 4U);
  for (const char* mode : {"white", "random_walk"}) {
    const std::string modern = mode + std::string(" modern"), thesis = mode + std::string(" thesis");
    EXPECT_EQ(before[modern], before[thesis]) << "both presets are given the same noise";
    for (std::size_t i = 0; i < after[modern].size(); ++i) {
      EXPECT_GT(before[modern][i], 1.5) << "cm: a sigma of 2 cm a draw";
      EXPECT_LT(after[modern][i], 0.3 * before[modern][i]);
    }
    EXPECT_NE(before[modern][0], before[modern][1]) << "seeds differ";
  }
  EXPECT_EQ(told(result), told(experiment_named("path-noise").run(quick_context({1}))));
}

// A straight path leaves its roll open to a fit of positions, and a map beside it would turn about it.
TEST(MappingRun, FitTakesTheRotationFromThePoses) {
  const Eigen::Isometry3d T = Eigen::Translation3d(1, -2, 0.5) * planar_pose(0, 0, 0.7) *
                              Eigen::AngleAxisd(0.2, Eigen::Vector3d::UnitX());
  Trajectory truth, path;
  for (int i = 0; i < 20; ++i) {
    const Eigen::Isometry3d pose = planar_pose(0.1 * i, 0, 0);
    path.push_back({100'000 * i, pose});
    truth.push_back({100'000 * i, T * pose});
  }
  EXPECT_TRUE(fit_to_truth(truth, path).isApprox(T, 1e-9));
  EXPECT_LT(path_error(truth, path), 1e-9);
  EXPECT_TRUE(std::isnan(path_error(truth, Trajectory(path.begin(), path.begin() + 8)))) << "less than half";
}

TEST(MappingRun, CoverageCountsWhatHasAPointNear) {
  SeenSurface seen;
  std::vector<Eigen::Vector3d> points;
  for (int i = 0; i < 10; ++i) seen.cells.emplace_back(0.5 * i + 0.05, 0.05, 0.05);
  for (int i = 0; i < 4; ++i) points.emplace_back(0.5 * i + 0.05, 0.05, 0.14);  // 9 cm off
  points.emplace_back(2.05, 0.05, 0.16);                                        // 11 cm off
  EXPECT_DOUBLE_EQ(coverage(seen, Eigen::Isometry3d::Identity(), points), 0.4);
}

TEST(ResultParts, EllipseHoldsItsShare) {
  Eigen::Matrix2d P;
  P << 4, 1.5, 1.5, 1;
  const Eigen::Matrix2d root = P.llt().matrixL();
  const ChartSeries outline = ellipse_series("", {1, 2}, P, 0.9);
  const Eigen::Vector2d corner(outline.x[10] - 1, outline.y[10] - 2);
  const double bound = corner.dot(P.inverse() * corner);
  Random random(3);
  int inside = 0;
  constexpr int all = 4000;
  for (int i = 0; i < all; ++i) {
    const Eigen::Vector2d d = root * Eigen::Vector2d(random.normal(), random.normal());
    inside += d.dot(P.inverse() * d) < bound ? 1 : 0;
  }
  EXPECT_NEAR(static_cast<double>(inside) / all, 0.9, 0.02);
}

TEST(ResultParts, SpreadLeavesOutWhatWasNotMeasured) {
  const Spread spread = spread_of({3, std::nan(""), 1, 2});
  EXPECT_EQ(spread.median, 2);
  EXPECT_EQ(spread.low, 1);
  EXPECT_EQ(spread.high, 3);
  EXPECT_EQ(in_words(spread, 100, "cm", 0), "200 cm (100 to 300, in 3 of 4)");
  EXPECT_EQ(in_words(spread_of({3, 1, 2}), 100, "cm", 0), "200 cm (100 to 300)");
  EXPECT_EQ(in_words(spread_of({2, std::nan("")}), 1, "m", 0), "2 m (in 1 of 2)");
  EXPECT_EQ(in_words(spread_of({std::nan("")}), 1, "m"), "not measured");
  EXPECT_TRUE(number(std::nan("")).is_null());
}

TEST(ResultParts, WhoIsLostIsWorseThanAll) {
  EXPECT_EQ(median_or_lost({3, std::nan(""), 1}), 3);
  EXPECT_TRUE(std::isinf(median_or_lost({std::nan(""), std::nan(""), 1})));
  EXPECT_TRUE(std::isinf(median_or_lost({})));
}

// One seed has two cases, and one in twenty is outside of its band by chance.
TEST(MappingExperiments, ACaseOutsideItsBandIsNoDifferenceByItself) {
  int outside = 0;
  for (int seed = 1; seed <= 60; ++seed) {
    const ExperimentResult result = experiment_named("sampled-poses").run(quick_context({seed}));
    for (const auto& row : result.tables.at(0).rows) outside += row.back() == "no" ? 1 : 0;
    EXPECT_EQ(result.agreement, Agreement::agrees) << "seed " << seed << ": " << result.finding;
  }
  EXPECT_GT(outside, 0);
  EXPECT_FALSE(follows_chi_square(1.5 * 198, 198));
  EXPECT_FALSE(follows_chi_square(0.5 * 198, 198));
}

TEST(Judgements, AlternationIsWhatTakesTurns) {
  const Judgement surf = judge_alternation({{1, 0, 5, 0}, {1, 1, 4, 0}, {0, 1, 9, 0.5}}, 10);
  EXPECT_EQ(surf.agreement, Agreement::differs) << "SURF alone takes no turns";
  EXPECT_NE(surf.finding.find("SURF alone is right most often, in 9 of 10 pairs"), std::string::npos);
  EXPECT_NE(surf.finding.find("no oscillation"), std::string::npos);
  EXPECT_EQ(judge_alternation({{1, 0, 5, 0}, {1, 1, 9, 0}, {0, 1, 9, 0}}, 10).agreement,
            Agreement::agrees_in_part);
  const Judgement turns = judge_alternation({{1, 0, 5, 0}, {5, 1, 9, 0.25}, {1, 1, 9, 0}, {0, 1, 3, 0}}, 10);
  EXPECT_EQ(turns.agreement, Agreement::agrees);
  EXPECT_NE(turns.finding.find("5:1 and 1:1 are right most often"), std::string::npos) << turns.finding;
  EXPECT_NE(turns.finding.find("in 25 % at 5:1 of the rounds"), std::string::npos) << turns.finding;
}

TEST(Judgements, WhoIsLostInAWeakCaseErrsByNoNumber) {
  const double lost = std::nan("");
  const WeakErrors dark{"dark", {0.3, 0.3, 0.3}, {0.1, 0.1, 0.1}};
  const Judgement icp = judge_weak_cases({{"corridor", {0.1, 0.1, 0.1}, {lost, lost, 0.1}}}, dark);
  EXPECT_EQ(icp.agreement, Agreement::agrees);
  EXPECT_NE(icp.finding.find("the thesis's ICP is lost and its FastSLAM is not"), std::string::npos)
      << icp.finding;
  // FastSLAM itself is lost: that is no case in which it is the better one, and it is said.
  const Judgement both = judge_weak_cases({{"corridor", {lost, lost, 0.1}, {lost, 0.2, 0.2}}}, dark);
  EXPECT_EQ(both.agreement, Agreement::agrees_in_part);
  EXPECT_NE(both.finding.find("is lost itself: corridor"), std::string::npos) << both.finding;
}

TEST(Judgements, WhoIsLostWithAPersonSuffersMost) {
  const double lost = std::nan("");
  const std::string worst = worst_with_person(
      {{"A", {0.1, 0.1}, {0.9, 0.9}}, {"B", {0.1, 0.1}, {lost, lost}}, {"C", {lost}, {lost}}});
  EXPECT_EQ(worst, "B suffers most, it is lost; C is lost without her, too");
  EXPECT_EQ(worst_with_person({{"A", {0.1}, {0.2}}}), "A suffers most, 2.0 times its error alone");
  EXPECT_EQ(worst_with_person({{"C", {lost}, {0.2}}}).find("nan"), std::string::npos);
}

RgbdFrame plain_frame(const RgbdCalibration& c) {
  RgbdFrame frame;
  frame.colour = cv::Mat(c.colour.height, c.colour.width, CV_8UC3, cv::Scalar(100, 120, 140));
  frame.depth = cv::Mat(c.depth.height, c.depth.width, CV_16UC1, cv::Scalar(4000));
  return frame;
}

// She stands 2 m ahead of the robot in its middle after a quarter of a crossing to and fro.
TEST(ImageChanges, APersonStandsBeforeWhatWasThere) {
  Drive drive;
  RgbdCalibration& c = drive.calibration;
  c.colour.width = c.depth.width = 160;
  c.colour.height = c.depth.height = 120;
  c.colour.fx = c.colour.fy = c.depth.fx = c.depth.fy = 140;
  c.colour.cx = c.depth.cx = 80;
  c.colour.cy = c.depth.cy = 60;
  c.T_robot_camera = Eigen::Translation3d(0, 0, 1) * optical_axes();
  RgbdFrame frame = plain_frame(c);
  with_person(drive)(frame, 0, 1.5);
  EXPECT_NEAR(frame.depth.at<std::uint16_t>(60, 80), 1750, 2) << "mm: her front is 25 cm before her middle";
  EXPECT_EQ(frame.depth.at<std::uint16_t>(60, 10), 4000);
  EXPECT_NE(frame.colour.at<cv::Vec3b>(60, 80), cv::Vec3b(100, 120, 140));
  EXPECT_EQ(frame.colour.at<cv::Vec3b>(60, 10), cv::Vec3b(100, 120, 140));
  frame = plain_frame(c);
  frame.depth.setTo(1000);
  with_person(drive)(frame, 0, 1.5);
  EXPECT_EQ(frame.depth.at<std::uint16_t>(60, 80), 1000) << "something stands before her";
}

TEST(ImageChanges, LightSwingsAndDims) {
  RgbdCalibration calibration;
  calibration.colour.width = calibration.colour.height = 8;
  calibration.depth = calibration.colour;
  RgbdFrame frame = plain_frame(calibration);
  const cv::Mat before = frame.colour.clone();
  flickering(1)(frame, 0, 0.75);  // a quarter of its period: a stop brighter
  EXPECT_EQ(frame.colour.at<cv::Vec3b>(0, 0), cv::Vec3b(200, 240, 255));
  frame.colour = before.clone();
  dimmed(0.1)(frame, 0, 0);
  EXPECT_EQ(frame.colour.at<cv::Vec3b>(0, 0), cv::Vec3b(10, 12, 14));
}

TEST(Drives, LoseWheelsAndImagesAsAsked) {
  Drive drive;
  drive.frames.resize(6);
  for (int i = 0; i < 6; ++i) {
    drive.frames[static_cast<std::size_t>(i)].seq = i;
    const Utime now = 1'000'000 + 1'000'000 * i;
    drive.messages.push_back({"ENCODERS", {}, now});
    drive.messages.push_back({"CAMERA", {}, now});
    drive.messages.push_back({"FEATURES", {}, now});
  }
  const Drive third = every_nth(drive, 3);
  ASSERT_EQ(third.frames.size(), 2U);
  EXPECT_EQ(third.frames[1].seq, 3);
  EXPECT_EQ(third.messages.size(), 6U + 2 + 2);
  const Drive silent = without_wheels(drive, 1, 3);
  EXPECT_EQ(silent.messages.size(), 16U);
  for (const BatchMessage& m : silent.messages)
    EXPECT_TRUE(m.channel != "ENCODERS" || m.utime < 2'000'000 || m.utime >= 4'000'000);
}

}  // namespace
}  // namespace lcmslam
