// The real recordings.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>

#include <lcmslam/datasets/dataset.hpp>
#include <lcmslam/imaging/depth_registration.hpp>
#include <lcmslam/imaging/io/codec.hpp>
#include "tests/support/recordings.hpp"

namespace lcmslam {
namespace {

namespace fs = std::filesystem;
using testing::Contains;
using testing::HasSubstr;

#define OPEN_OR_SKIP(source, name) \
  LCMSLAM_SKIP_WITHOUT(name);      \
  const std::unique_ptr<RgbdSource> source = open_dataset(recording_path(name))

// Median |z - measured| in m when frame a's points are moved into frame b by the true poses: only right
// poses, intrinsics, depth scale and pairing of files make it small. `still`: the poses left out.
double reprojection_error(RgbdSource& source, std::size_t a, std::size_t b, bool still = false) {
  const auto first = source.frame(a);
  const auto second = source.frame(b);
  if (!first || !second) throw std::runtime_error("a frame cannot be read");
  const auto pose_a = pose_at(source.truth(), source.calibration().depth_time(first->depth.utime));
  const auto pose_b = pose_at(source.truth(), source.calibration().depth_time(second->depth.utime));
  if (!pose_a || !pose_b) throw std::runtime_error("a frame has no pose");
  const Eigen::Isometry3d T_b_a = still ? Eigen::Isometry3d::Identity() : pose_b->inverse() * *pose_a;
  const RgbdFrame frame = decode(*first);
  const cv::Mat depth = decode(*second).depth;
  const auto registered = register_depth(frame, source.calibration());
  std::vector<double> errors;
  for (int v = 0; v < registered.points.rows; v += 8) {
    for (int u = 0; u < registered.points.cols; u += 8) {
      const auto& p = registered.points.at<cv::Vec3f>(v, u);
      if (std::isnan(p[2])) continue;
      const Eigen::Vector3d moved = T_b_a * Eigen::Vector3d(p[0], p[1], p[2]);
      const auto pixel = source.calibration().depth.project(moved);
      if (!pixel || !source.calibration().depth.contains(*pixel)) continue;
      const auto measured = depth.at<std::uint16_t>(static_cast<int>(std::lround(pixel->y())),
                                                    static_cast<int>(std::lround(pixel->x())));
      if (measured > 0) errors.push_back(std::abs(0.001 * measured - moved.z()));
    }
  }
  if (errors.size() < 200) throw std::runtime_error("the frames do not overlap");
  std::nth_element(errors.begin(), errors.begin() + static_cast<long>(errors.size() / 2), errors.end());
  return errors[errors.size() / 2];
}

TEST(Recordings, TumFreiburg1Rpy) {
  OPEN_OR_SKIP(source, "tum_fr1_rpy");
  EXPECT_EQ(source->size(), 678u);
  EXPECT_EQ(source->truth().size(), 2742u);
  EXPECT_EQ(source->truth_frame(), "camera");
  EXPECT_EQ(source->entry(0).utime, 1305031229528748);
  EXPECT_EQ(source->entry(0).depth_utime, 1305031229528784);
  EXPECT_EQ(source->calibration().sensor, "tum_fr1");  // by the header of rgb.txt
  EXPECT_EQ(source->calibration().colour.fx, 517.3);
  EXPECT_THAT(source->notes(), Contains(HasSubstr("freiburg1")));
  EXPECT_TRUE(source->problems().empty());
  for (std::size_t i = 1; i < source->size(); ++i)
    ASSERT_LT(source->entry(i - 1).utime, source->entry(i).utime);

  // The camera's JPEG goes out byte for byte.
  const auto frame = source->frame(0);
  ASSERT_TRUE(frame.has_value());
  EXPECT_EQ(frame->colour.coding, ImageCoding::jpeg);
  EXPECT_EQ(frame->colour.bytes.size(),
            fs::file_size(recording_path("tum_fr1_rpy/rgb/1305031229.528748.jpg")));
  EXPECT_LT(reprojection_error(*source, 100, 115), 0.04);
  EXPECT_LT(reprojection_error(*source, 400, 410), 0.04);
}

TEST(Recordings, Livingroom1) {
  OPEN_OR_SKIP(source, "livingroom1");
  EXPECT_EQ(source->size(), 211u);
  EXPECT_EQ(source->truth().size(), 211u);
  EXPECT_EQ(source->calibration().sensor, "livingroom1");
  EXPECT_THAT(source->notes(), Contains(HasSubstr("30 Hz assumed")));
  EXPECT_TRUE(source->problems().empty());
  EXPECT_NEAR(static_cast<double>(source->entry(30).utime - source->entry(0).utime), 1e6, 1);
  EXPECT_LT(reprojection_error(*source, 0, 10), 0.004);
  EXPECT_LT(reprojection_error(*source, 200, 210), 0.004);
}

TEST(Recordings, Slambook2) {
  OPEN_OR_SKIP(source, "rgbd_slambook2");
  ASSERT_EQ(source->size(), 5u);
  EXPECT_EQ(source->truth().size(), 5u);
  EXPECT_EQ(source->calibration().colour.fx, 518);
  EXPECT_TRUE(source->problems().empty());
  for (std::size_t i = 0; i < 5; ++i) EXPECT_TRUE(source->frame(i).has_value()) << i;
  for (std::size_t i = 1; i < 4; ++i)  // the poses are approximate, but far better than none
    EXPECT_LT(reprojection_error(*source, i, i + 1), 0.3 * reprojection_error(*source, i, i + 1, true)) << i;
}

}  // namespace
}  // namespace lcmslam
