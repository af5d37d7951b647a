// Cameras from synthetic boards whose truth is known.

#include <lcmslam/calibration/calibration_pictures.hpp>
#include <lcmslam/calibration/camera_pair.hpp>
#include <lcmslam/calibration/lens.hpp>
#include <lcmslam/calibration/range_error.hpp>
#include <lcmslam/calibration/view_coverage.hpp>

#include <gmock/gmock.h>

#include "tests/support/board_shots.hpp"

namespace lcmslam {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

TEST(CameraCalibration, FindsAKnownCameraAndKnowsHowWell) {
  const Board board;
  const CameraModel truth = testing::drawn_colour_camera(1);
  const auto views = testing::colour_views(board, truth, 16, 1);
  const CameraCalibration found = calibrate_camera(views, board, {truth.width, truth.height});
  EXPECT_NEAR(found.camera.fx, truth.fx, 0.003 * truth.fx);
  EXPECT_NEAR(found.camera.fy, truth.fy, 0.003 * truth.fy);
  EXPECT_LT(found.rms, 0.15);
  // What it says of itself: no estimate is farther off than four of its standard deviations.
  const double errors[4] = {found.camera.fx - truth.fx, found.camera.fy - truth.fy,
                            found.camera.cx - truth.cx, found.camera.cy - truth.cy};
  for (int i = 0; i < 4; ++i) {
    EXPECT_GT(found.sigma(i), 0.01) << i;
    EXPECT_LT(found.sigma(i), 2.0) << i;
    EXPECT_LT(std::abs(errors[i]), 4 * found.sigma(i)) << i;
  }
  const ViewCoverage coverage = coverage_of(found, board);
  EXPECT_THAT(missing_views(found, coverage), IsEmpty());
  EXPECT_EQ(coverage_picture(found, board).cols, 640);
  EXPECT_EQ(residual_picture(found).cols, 640);
}

TEST(CameraCalibration, ACornerThatIsSomethingElseIsLeftOut) {
  const Board board;
  const CameraModel truth = testing::drawn_colour_camera(2);
  auto views = testing::exact_views(board, truth, 12, 2, 0.1);
  for (std::size_t i = 0; i < 4; ++i) views[i].pixels[7] += Eigen::Vector2d(9, -6);
  const CameraCalibration found = calibrate_camera(views, board, {truth.width, truth.height});
  EXPECT_GE(found.outliers, 4);
  EXPECT_LE(found.outliers, 40);
  EXPECT_NEAR(found.camera.fx, truth.fx, 0.003 * truth.fx);
}

TEST(ViewCoverage, SaysWhichViewsAreMissing) {
  const Board board;
  const CameraModel camera = testing::drawn_colour_camera(3);
  const auto judged = [&](const std::vector<BoardView>& views) {
    const CameraCalibration found = calibrate_camera(views, board, {camera.width, camera.height});
    return missing_views(found, coverage_of(found, board));
  };
  auto views = testing::exact_views(board, camera, 20, 3, 0.1);
  EXPECT_THAT(judged(views), IsEmpty());

  auto without_a_quarter = views;
  for (BoardView& view : without_a_quarter) {
    BoardView kept;
    for (std::size_t i = 0; i < view.ids.size(); ++i)
      if (view.pixels[i].x() < 319 || view.pixels[i].y() > 240)
        kept.ids.push_back(view.ids[i]), kept.pixels.push_back(view.pixels[i]);
    view = kept;
  }
  without_a_quarter.erase(std::remove_if(without_a_quarter.begin(), without_a_quarter.end(),
                                         [](const BoardView& v) { return v.ids.size() < 10; }),
                          without_a_quarter.end());
  EXPECT_THAT(judged(without_a_quarter), ElementsAre(HasSubstr("upper right quarter")));

  EXPECT_THAT(judged(testing::exact_views(board, camera, 20, 3, 0.1, 0.04)),
              ElementsAre(HasSubstr("all views face-on")));
  views.resize(5);
  EXPECT_THAT(judged(views), ::testing::Contains(HasSubstr("only 5 views")));
}

// Three sigmas of the focal length are to be 0.3 %, and whoever holds the board is told how to get there.
TEST(ViewCoverage, SaysWhichViewsMakeTheFocalLengthSurer) {
  const Board board = testing::large_board();
  const CameraModel camera = testing::drawn_tof_camera(3);
  const auto wanted = [&](int views, double noise, double tilt) {
    const CameraCalibration found = calibrate_camera(
        testing::exact_views(board, camera, views, 3, noise, tilt), board, {camera.width, camera.height});
    return wanted_views(found, coverage_of(found, board));
  };
  EXPECT_THAT(wanted(30, 0.01, 0.6), IsEmpty());
  EXPECT_THAT(wanted(30, 0.15, 0.6),
              ElementsAre(AllOf(HasSubstr("0.10 % is wanted"), HasSubstr("more views"))));
  EXPECT_THAT(wanted(30, 0.15, 0.25), ElementsAre(HasSubstr("tilt the board by 20 to 40 degrees, near")));
}

TEST(CameraCalibration, TwoViewsAreRefused) {
  const Board board;
  const CameraModel camera = testing::drawn_colour_camera(4);
  EXPECT_THROW(calibrate_camera(testing::exact_views(board, camera, 2, 1, 0.1), board, {640, 480}),
               std::invalid_argument);
}

TEST(Lens, IsTheCameraModel) {
  CameraModel camera = testing::drawn_colour_camera(5);
  for (const std::vector<double>& d : {std::vector<double>{},
                                       {-0.1, 0.05, 0.001, -0.002},
                                       {-0.1, 0.05, 0.001, -0.002, 0.03},
                                       {-0.1, 0.05, 0.001, -0.002, 0.03, 0.02, -0.01, 0.02}}) {
    camera.distortion = d;
    const double k[4] = {camera.fx, camera.fy, camera.cx, camera.cy};
    const Eigen::Vector3d p(0.3, -0.2, 1.1);
    EXPECT_LT((project_through_lens(k, d, p) - *camera.project(p)).norm(), 1e-9) << d.size();
  }
}

TEST(RangeError, OffsetAndWiggleComeOut) {
  Random random(6);
  DepthError truth{0.012, 0, 0.006, 1.9, 0.4};
  std::vector<RangeSample> samples;
  for (double r = 0.5; r < 3.2; r += 0.03)
    samples.push_back({r, truth.at(r) + 0.002 * r + random.normal(0, 0.001), 0.001});
  const RangeErrorFit fit = fit_range_error(samples);
  EXPECT_THAT(fit.notes, IsEmpty());
  EXPECT_EQ(fit.error.scale, 0);
  EXPECT_NEAR(fit.apparent_scale, 0.002, 0.001);
  double worst = 0;
  for (double r = 0.6; r < 3; r += 0.05) worst = std::max(worst, std::abs(fit.error.at(r) - truth.at(r)));
  EXPECT_LT(worst, 0.002);
  const auto rms_left = [&](double scale) {
    double squares = 0;
    for (const RangeSample& s : samples)
      squares += std::pow(s.error - fit.error.at(s.range) - scale * s.range, 2);
    return std::sqrt(squares / static_cast<double>(samples.size()));
  };
  EXPECT_LT(rms_left(fit.apparent_scale), 0.2 * fit.rms_before);
  EXPECT_NEAR(fit.rms_after, rms_left(0), 1e-9) << "what is written corrects no scale";
  EXPECT_NEAR(fit.error.wiggle, truth.wiggle, 4 * std::sqrt(fit.covariance(2, 2)));
}

TEST(RangeError, FromOneDistanceThereIsAnOffsetAndNothingMore) {
  Random random(7);
  std::vector<RangeSample> samples;
  for (double r = 1.0; r < 1.3; r += 0.02) samples.push_back({r, 0.015 + random.normal(0, 0.001), 0.001});
  const RangeErrorFit fit = fit_range_error(samples);
  EXPECT_NEAR(fit.error.offset, 0.015, 0.001);
  EXPECT_EQ(fit.error.wiggle, 0);
  EXPECT_THAT(fit.notes, ElementsAre(HasSubstr("hold the board from 0.5 to 3 m")));
}

TEST(RangeError, OfTooFewRangesSaysThatTheyMayBeFurtherOff) {
  EXPECT_THAT([] { fit_range_error({}); }, ::testing::ThrowsMessage<std::invalid_argument>(
                                               HasSubstr("in 0 ranges within 0.30 m of where it is")));
}

// However many ranges a tilted board has in one view: what errs is one distance.
TEST(RangeError, AViewTellsNoMoreThanItsBoardsDistance) {
  const testing::RgbdTruth truth = testing::drawn_head(2);
  const Board board = testing::large_board();
  Random random(4);
  constexpr double pose_sigma = 0.004;
  for (const double tilt : {0.0, 0.3, 0.7}) {
    const Eigen::Isometry3d T =
        testing::held_board(board, truth.calibration.depth, {88, 72}, 1.5, tilt, 0.1, 0);
    const auto samples = board_ranges(testing::board_depth(board, truth, T, random), truth.calibration.depth,
                                      board, T, pose_sigma);
    ASSERT_FALSE(samples.empty());
    double information = 0;
    for (const RangeSample& s : samples) information += 1 / (s.sigma * s.sigma);
    EXPECT_GE(1 / std::sqrt(information), pose_sigma) << samples.size() << " ranges";
    EXPECT_LT(1 / std::sqrt(information), 1.1 * pose_sigma) << samples.size() << " ranges";
  }
}

// Boards as far off as their distance's sigma says: what is told of the offset holds, and no wiggle comes of
// it.
TEST(RangeError, BoardsThatAreFartherThanTheyLookMakeNoWiggle) {
  const testing::RgbdTruth head = testing::drawn_head(2);
  testing::RgbdTruth truth = head;
  truth.calibration.depth_error = {0.01, 0, 0, 1, 0};
  const CameraModel& camera = truth.calibration.depth;
  const Board board = testing::large_board();
  constexpr int runs = 20, views = 20;
  int wiggles = 0;
  double squares = 0;
  for (int run = 0; run < runs; ++run) {
    Random random(static_cast<std::uint64_t>(run), 9);
    std::vector<RangeSample> samples;
    for (int i = 0; i < views; ++i) {
      const Eigen::Isometry3d T =
          testing::held_board(board, camera, {88, 72}, 0.8 + 2.0 * i / views, 0.5, 0.3, 0);
      const double sigma = board_distance_sigma(camera, board, T.translation().z());
      Eigen::Isometry3d seen = T;
      seen.translation() *= 1 + random.normal(0, sigma) / T.translation().z();
      const auto ranges =
          board_ranges(testing::board_depth(board, truth, T, random), camera, board, seen, sigma);
      samples.insert(samples.end(), ranges.begin(), ranges.end());
    }
    const RangeErrorFit fit = fit_range_error(samples);
    wiggles += fit.error.wiggle != 0 ? 1 : 0;
    squares += std::pow(fit.error.offset - 0.01, 2) / fit.covariance(0, 0);
  }
  EXPECT_LE(wiggles, 1);
  EXPECT_LT(std::sqrt(squares / runs), 1.5) << "standard deviations";
}

TEST(TofCalibration, IntrinsicsAndRangesOfADrawnCamera) {
  const testing::RgbdTruth truth = testing::drawn_head(2);
  const Board board = testing::large_board();
  const auto shots = testing::head_shots(board, truth, 24, 2);
  std::vector<BoardView> views;
  for (const PairView& pair : shots.pairs) views.push_back(pair.depth);
  const CameraModel& camera = truth.calibration.depth;
  const CameraCalibration found = calibrate_camera(views, board, {camera.width, camera.height});
  EXPECT_NEAR(found.camera.fx, camera.fx, 0.001 * camera.fx);
  EXPECT_LT(found.sigma(0), 0.001 * camera.fx) << "0.19 % when corners were found by gradients";
  std::vector<RangeSample> samples;
  for (std::size_t i = 0; i < shots.depths.size(); ++i) {
    const auto pose = board_pose(views[i], board, found.camera);
    ASSERT_TRUE(pose);
    const auto ranges = board_ranges(shots.depths[i], found.camera, board, *pose,
                                     board_distance_sigma(found.camera, board, pose->translation().z()));
    samples.insert(samples.end(), ranges.begin(), ranges.end());
  }
  RangeErrorFitSettings settings;
  settings.scale_sigma = found.sigma(0) / found.camera.fx;
  const RangeErrorFit fit = fit_range_error(samples, settings);
  const DepthError& error = truth.calibration.depth_error;
  for (double r = fit.nearest; r < fit.farthest; r += 0.1)
    EXPECT_NEAR(fit.error.at(r), error.at(r), 0.003) << r;
}

TEST(PairCalibration, FindsHowTwoCamerasSitOnEachOther) {
  const testing::RgbdTruth truth = testing::drawn_head(1);
  const Board board = testing::large_board();
  const auto shots = testing::head_shots(board, truth, 14, 1);
  ASSERT_GE(shots.pairs.size(), 10u);
  // The depth camera's focal length is 3 % off at first, which the pair finds out.
  CameraModel start = truth.calibration.depth;
  start.fx *= 1.03, start.fy *= 1.03;
  const PairCalibration found = calibrate_pair(shots.pairs, board, truth.calibration.colour, start);
  const Eigen::Isometry3d& T = truth.calibration.T_colour_depth;
  EXPECT_LT(distance_between(found.T_colour_depth, T), 0.002);
  EXPECT_LT(angle_between(found.T_colour_depth, T), 0.1 * M_PI / 180);
  EXPECT_NEAR(found.depth.fx, truth.calibration.depth.fx, 0.003 * truth.calibration.depth.fx);
  const Vector6d xi = se3_log(T.inverse() * found.T_colour_depth);
  for (int i = 0; i < 6; ++i) {
    EXPECT_LT(std::abs(xi[i]), 5 * std::sqrt(found.covariance(i, i))) << i;
    EXPECT_LT(std::sqrt(found.covariance(i, i)), 0.002) << i;  // m, rad
  }
}

}  // namespace
}  // namespace lcmslam
