#include <lcmslam/simulation/kept_views.hpp>

#include <gmock/gmock.h>

namespace lcmslam {
namespace {

CameraViews views(double value) {
  CameraViews views{cv::Mat(3, 4, CV_32FC(5)), cv::Mat(2, 2, CV_64FC2, cv::Scalar::all(-value / 3))};
  views.colour.reshape(1).setTo(value);
  return views;
}

bool same(const cv::Mat& a, const cv::Mat& b) {
  return a.type() == b.type() && a.size() == b.size() &&
         std::equal(a.datastart, a.dataend, b.datastart, b.dataend);
}

TEST(KeptViews, GiveBackTheSameBytes) {
  KeptViews kept(1'000'000);
  CameraViews found;
  EXPECT_FALSE(kept.find(7, found));
  for (int i = 1; i <= 3; ++i) kept.keep(i, views(i));
  kept.keep(2, views(20));  // is there already
  for (int i = 3; i >= 1; --i) {
    ASSERT_TRUE(kept.find(i, found)) << i;
    const CameraViews wanted = views(i);
    EXPECT_TRUE(same(found.colour, wanted.colour) && same(found.depth, wanted.depth)) << i;
  }
}

TEST(KeptViews, KeepNoMoreThanTheyMay) {
  const CameraViews one = views(1);
  const auto bytes = static_cast<std::int64_t>(one.colour.total() * one.colour.elemSize() +
                                               one.depth.total() * one.depth.elemSize());
  KeptViews kept(2 * bytes + bytes / 2);
  for (int i = 1; i <= 4; ++i) kept.keep(i, views(i));
  CameraViews found;
  EXPECT_TRUE(kept.find(1, found));
  EXPECT_TRUE(kept.find(2, found));
  EXPECT_FALSE(kept.find(3, found));
  EXPECT_FALSE(kept.find(4, found));
}

}  // namespace
}  // namespace lcmslam
