#include <lcmslam/evaluation/trajectory_plot.hpp>

#include <gmock/gmock.h>

#include <unistd.h>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <limits>
#include <opencv2/imgcodecs.hpp>

#include "tests/support/full_disk.hpp"
#include "tests/unit/evaluation/path_samples.hpp"

namespace lcmslam {
namespace {

const std::array<unsigned char, 3> red = {255, 0, 0}, blue = {0, 0, 255};

// Bounding box of the pixels of exactly this colour below the legend.
cv::Rect box_of(const cv::Mat& image, const std::array<unsigned char, 3>& colour, int legend = 60) {
  cv::Mat mask;
  const cv::Scalar bgr(colour[2], colour[1], colour[0]);
  cv::inRange(image, bgr, bgr, mask);
  mask.rowRange(0, legend).setTo(0);
  std::vector<cv::Point> pixels;
  cv::findNonZero(mask, pixels);
  if (pixels.empty()) return {};
  int left = image.cols, right = 0, top = image.rows, bottom = 0;
  for (const cv::Point& p : pixels) {
    left = std::min(left, p.x), right = std::max(right, p.x);
    top = std::min(top, p.y), bottom = std::max(bottom, p.y);
  }
  return {left, top, right - left + 1, bottom - top + 1};
}

TEST(TrajectoryPlot, HasOneScaleForBothAxesAndYUpwards) {
  PlottedPath square{"square", red, {{0, 0}, {4, 0}, {4, 4}, {0, 4}, {0, 0}}};
  PlottedPath above{"above", blue, {{1, 3}, {3, 3}}};
  const cv::Mat image = plot_paths({square, above}, {900, 600, "title"});
  ASSERT_EQ(image.size(), cv::Size(900, 600));
  ASSERT_EQ(image.type(), CV_8UC3);
  const cv::Rect outer = box_of(image, red), inner = box_of(image, blue);
  EXPECT_NEAR(outer.width, outer.height, 8);
  EXPECT_GT(outer.height, 350) << "fills the image";
  EXPECT_NEAR(inner.width, outer.width / 2, 14);
  EXPECT_LT(inner.y + inner.height / 2, outer.y + outer.height / 2) << "y = 3 is above the centre, y = 2";
}

TEST(TrajectoryPlot, DrawsWithoutPathsPointsOrExtent) {
  EXPECT_FALSE(plot_paths({}).empty());
  EXPECT_FALSE(plot_paths({{"empty", red, {}}}).empty());
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(plot_paths({{"nan", red, {{nan, 0}, {0, nan}}}}).empty());
  EXPECT_GT(box_of(plot_paths({{"point", red, {{7, 7}}}}), red).area(), 50);
  EXPECT_GT(box_of(plot_paths({{"far", red, {{1e7, 1e7}, {1e7 + 5, 1e7}}}}), red).area(), 50);
  EXPECT_THROW(plot_paths({}, {100, 100, ""}), std::invalid_argument);
}

TEST(TrajectoryPlot, TopViewTakesXAndY) {
  const Trajectory trajectory = testing::curved_path(20);
  const PlottedPath path = top_view("path", plot_colour(1), trajectory);
  ASSERT_EQ(path.points.size(), 20u);
  EXPECT_EQ(path.points[7], Eigen::Vector2d(trajectory[7].T_world_body.translation().head<2>()));
  EXPECT_NE(plot_colour(0), plot_colour(1));
}

// To look at: LCMSLAM_PLOT=/tmp/plot.png test_evaluation
TEST(TrajectoryPlot, IsTheSameEachTime) {
  Random random(2);
  const Trajectory truth = testing::curved_path(900);
  const auto draw = [&] {
    Random seed = random;
    return plot_paths({top_view("truth", plot_colour(0), truth),
                       top_view("wheels", plot_colour(1), testing::with_noise(truth, seed, 0.01, 0)),
                       top_view("fastslam", plot_colour(2), testing::moved(truth, planar_pose(0.1, 0, 0.1)))},
                      {960, 720, "kitchen, seed 1"});
  };
  const cv::Mat image = draw();
  EXPECT_EQ(cv::norm(image, draw(), cv::NORM_INF), 0);
  if (const char* file = std::getenv("LCMSLAM_PLOT")) cv::imwrite(file, image);
}

EvaluationPlot two_estimates() {
  EvaluationPlot plot;
  plot.paths = {{"truth", plot_colour(0), {{0, 0}, {4, 0}}},
                {"a<b> & c", red, {{0, 1}, {2, 1}}},
                {"other", blue, {{0, 2}, {2, 2}}}};
  plot.errors = {{"", red, {{0, 0.1}, {10, 0.1}}}, {"", blue, {{0, 0.4}, {5, 0.4}}}};
  return plot;
}

TEST(EvaluationPlot, ShowsErrorsBelowLargerOnesHigher) {
  const cv::Mat image = plot_evaluation(two_estimates(), {900, 600, "title"});
  ASSERT_EQ(image.size(), cv::Size(900, 900));
  const cv::Mat errors = image.rowRange(600, 900);
  const cv::Rect small = box_of(errors, red, 0), large = box_of(errors, blue, 0);
  EXPECT_GT(small.area(), 0);
  EXPECT_GT(small.y, large.y + large.height) << "0.4 m lies above 0.1 m";
  EXPECT_NEAR(large.width, small.width / 2, 3) << "5 s of 10 s";
  EXPECT_FALSE(plot_evaluation({}).empty());
}

/// Values of an attribute, in order.
std::vector<std::string> attributes(const std::string& svg, const std::string& name) {
  std::vector<std::string> values;
  for (std::size_t at = 0; (at = svg.find(" " + name + "=\"", at)) != std::string::npos;) {
    at += name.size() + 3;
    values.push_back(svg.substr(at, svg.find('"', at) - at));
  }
  return values;
}

// The same drawing on another surface: the polylines' points are where the pixels are.
TEST(EvaluationPlot, SvgHasTheSameCurves) {
  const std::string svg = plot_evaluation_svg(two_estimates(), {900, 600, "title"});
  EXPECT_EQ(svg.rfind("<svg ", 0), 0u);
  EXPECT_NE(svg.find("a&lt;b&gt; &amp; c"), std::string::npos) << "names are escaped";
  const auto lines = attributes(svg, "points");
  ASSERT_EQ(lines.size(), 5u) << "three paths, two errors";
  const auto ends = [](const std::string& points) {
    std::array<double, 4> v{};
    EXPECT_EQ(std::sscanf(points.c_str(), "%lf,%lf %lf,%lf", &v[0], &v[1], &v[2], &v[3]), 4);
    return v;
  };
  const cv::Rect drawn = box_of(plot_evaluation(two_estimates(), {900, 600, "title"}).rowRange(0, 600), red);
  const auto path = ends(lines[1]);
  EXPECT_NEAR(path[0], drawn.x + 5, 3) << "the disc at its start stands out by 5 pixels";
  EXPECT_NEAR(path[2], drawn.x + drawn.width - 6, 3);
  const auto error = ends(lines[3]);
  EXPECT_GT(error[1], ends(lines[4])[1]);
  EXPECT_EQ(error[1], error[3]) << "a constant error is level";
}

TEST(EvaluationPlot, IsWrittenByTheNamesEnd) {
  const auto folder = std::filesystem::temp_directory_path();
  const std::string name = "lcmslam-plot-" + std::to_string(getpid());
  const auto png = folder / (name + ".png"), svg = folder / (name + ".svg");
  write_plot(png, two_estimates());
  write_plot(svg, two_estimates());
  EXPECT_EQ(cv::norm(cv::imread(png.string()), plot_evaluation(two_estimates()), cv::NORM_INF), 0);
  EXPECT_EQ(std::filesystem::file_size(svg), plot_evaluation_svg(two_estimates()).size());
  for (const auto& file : {png, svg}) {
    const auto before = std::filesystem::file_size(file);
    const testing::FullDisk full(1000);
    EXPECT_THAT(
        [&] {
          write_plot(file, two_estimates(), {640, 480, "title"});
        },
        ::testing::ThrowsMessage<std::runtime_error>("cannot save " + file.string() + ": File too large"));
    EXPECT_EQ(std::filesystem::file_size(file), before) << "the old plot stays";
  }
  std::filesystem::remove(png);
  std::filesystem::remove(svg);
  EXPECT_THROW(write_plot(folder / "plot.gif", {}), std::invalid_argument);
  EXPECT_THROW(write_plot("/no/such/folder/plot.svg", {}), std::runtime_error);
  EXPECT_THROW(write_plot("/no/such/folder/plot.png", {}), std::runtime_error);
}

}  // namespace
}  // namespace lcmslam
