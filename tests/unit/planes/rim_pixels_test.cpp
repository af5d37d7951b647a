#include <lcmslam/planes/rim_pixels.hpp>

#include <gtest/gtest.h>

#include <lcmslam/geometry/random.hpp>
#include <lcmslam/parallel/instruction_set.hpp>

namespace lcmslam {
namespace {

constexpr int side = 9;  // its 81 pixels do not fill the last lanes
constexpr float gate = 3;

RgbdCalibration camera() {
  RgbdCalibration camera;
  camera.colour = {27, 18, 30, 30, 13, 8.5, {}};
  camera.depth_registered = true;
  camera.depth_noise = {0.004, 0, 0, 0.001};
  return camera;
}

/// Two walls that meet in an edge towards the camera, one that hardly differs from the first, with noise and
/// holes.
const std::vector<NearPlane> planes = {
    {0.6f, 0, -0.8f, 1.0f, 1}, {-0.6f, 0, -0.8f, 1.0f, 2}, {0.6f, 0, -0.8f, 1.004f, 3}};
const std::int32_t bulges[4][4] = {{0, 0, 0, 0}, {0, 0, 1, 0}, {0, 1, 0, 1}, {0, 0, 1, 0}};

cv::Mat noisy_edge() {
  Random random(5);
  cv::Mat depth(18, 27, CV_16UC1);
  for (int v = 0; v < depth.rows; ++v)
    for (int u = 0; u < depth.cols; ++u) {
      const double z = 1 / (0.8 + 0.6 * std::abs(u - 13.0) / 30) + 0.004 * random.normal();
      depth.at<std::uint16_t>(v, u) =
          random.uniform() < 0.1 ? std::uint16_t{0} : static_cast<std::uint16_t>(std::lround(1000 * z));
    }
  return depth;
}

float along(const NearPlane& plane, const Eigen::Vector3f& point) {
  return -plane.offset / (plane.x * point.x() + plane.y * point.y() + plane.z * point.z());
}

/// One pixel after the other.
int chosen(const CellMoments& cells, std::uint16_t depth, const Eigen::Vector3f& point) {
  int own = 0;
  for (const NearPlane& plane : planes) {
    const float off = plane.x * point.x() + plane.y * point.y() + plane.z * point.z() + plane.offset;
    if (depth == 0 || std::abs(off) >= gate * cells.sigmas()[depth]) continue;
    if (own == 0) {
      own = plane.label;
      continue;
    }
    const float here = along(plane, point), there = along(planes[static_cast<std::size_t>(own - 1)], point);
    const int bulge = bulges[plane.label][own];
    if (bulge == 0 ? std::abs(here - 1) < std::abs(there - 1) : bulge > 0 ? here > there : here < there)
      own = plane.label;
  }
  return own;
}

class RimPixelsTest : public ::testing::TestWithParam<InstructionSet> {
 protected:
  RimPixelsTest() : former_(limit_instruction_set(GetParam())) {}
  ~RimPixelsTest() override { limit_instruction_set(former_); }
  Eigen::Vector3f point(int v, int u) const {
    return cells_.point(v, u, 0.001f * static_cast<float>(depth_.at<std::uint16_t>(v, u)));
  }
  cv::Mat labelled() {
    cv::Mat labels(depth_.size(), CV_8UC1, cv::Scalar(0));
    RimPixels pixels(cells_, 0.03);
    for (int row = 0; row < 2; ++row)
      for (int column = 0; column < 3; ++column) {
        pixels.load(depth_, column, row);
        for (const NearPlane& plane : planes) pixels.offer(plane, bulges[plane.label], gate);
        pixels.write(labels, column, row);
      }
    return labels;
  }

  InstructionSet former_;
  CellMoments cells_{camera(), side};
  cv::Mat depth_ = noisy_edge();
};

TEST_P(RimPixelsTest, EachPixelIsThePlanesThatItsRayMeets) {
  const cv::Mat labels = labelled();
  int all[4] = {};
  int other = 0;  // where sums in another order decide
  for (int v = 0; v < depth_.rows; ++v)
    for (int u = 0; u < depth_.cols; ++u) {
      const int label = labels.at<std::uint8_t>(v, u);
      ++all[label];
      other += label != chosen(cells_, depth_.at<std::uint16_t>(v, u), point(v, u)) ? 1 : 0;
    }
  EXPECT_LE(other, 2);
  for (const int count : all) EXPECT_GT(count, 20);
}

TEST_P(RimPixelsTest, MomentsAreOfThePixelsThatLieInThePlane) {
  const cv::Mat labels = labelled();
  RimPixels pixels(cells_, 0.03);
  for (int column = 0; column < 3; ++column) {
    pixels.load(depth_, column, 1);
    for (const NearPlane& plane : planes) {
      const PlaneMoments found = pixels.moments_of(plane, labels, column, 1, 1);
      PlaneMoments exact;
      for (int v = side; v < 2 * side; ++v)
        for (int u = column * side; u < (column + 1) * side; ++u) {
          const Eigen::Vector3f p = point(v, u);
          const float off = plane.x * p.x() + plane.y * p.y() + plane.z * p.z() + plane.offset;
          if (labels.at<std::uint8_t>(v, u) == plane.label &&
              std::abs(off) <= cells_.sigmas()[depth_.at<std::uint16_t>(v, u)])
            exact.add(p.cast<double>());
        }
      EXPECT_EQ(found.points, exact.points);
      EXPECT_EQ(found.weight, exact.weight);
      EXPECT_LT((found.sum - exact.sum).norm(), 1e-5 * (1 + exact.sum.norm()));
      EXPECT_LT((found.squares - exact.squares).norm(), 1e-5 * (1 + exact.squares.norm()));
    }
  }
}

TEST_P(RimPixelsTest, AllInstructionSetsGiveTheSameBits) {
  const cv::Mat labels = labelled();
  limit_instruction_set(InstructionSet::portable);
  EXPECT_EQ(cv::countNonZero(labels != labelled()), 0);
}

INSTANTIATE_TEST_SUITE_P(Each, RimPixelsTest,
                         ::testing::Values(InstructionSet::portable, InstructionSet::avx2));

TEST(WithoutSmoothed, LeavesOutWhatHasAnotherPlaneInItsRowOrColumn) {
  Random random(3);
  cv::Mat labels(23, 31, CV_8UC1);
  for (int v = 0; v < labels.rows; ++v)
    for (int u = 0; u < labels.cols; ++u)  // 255 is a plane too
      labels.at<std::uint8_t>(v, u) = static_cast<std::uint8_t>(random.uniform() < 0.4    ? 0
                                                                : random.uniform() < 0.05 ? 255
                                                                : u < 12                  ? 4
                                                                                          : 7);
  const cv::Mat left = without_smoothed(labels, 2);
  int left_out = 0;
  for (int v = 0; v < labels.rows; ++v)
    for (int u = 0; u < labels.cols; ++u) {
      const int own = labels.at<std::uint8_t>(v, u);
      bool bent = false;
      for (int k = -2; k <= 2; ++k)
        for (const cv::Point at : {cv::Point(u + k, v), cv::Point(u, v + k)}) {
          if (!cv::Rect(0, 0, labels.cols, labels.rows).contains(at)) continue;
          const int other = labels.at<std::uint8_t>(at);
          bent = bent || (other != 0 && other != own);
        }
      EXPECT_EQ(left.at<std::uint8_t>(v, u), bent ? 0 : own) << v << ", " << u;
      left_out += bent && own != 0 ? 1 : 0;
    }
  EXPECT_GT(left_out, 50);
}

}  // namespace
}  // namespace lcmslam
