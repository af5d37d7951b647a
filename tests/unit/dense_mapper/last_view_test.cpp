#include <lcmslam/dense_mapper/last_view.hpp>

#include <gtest/gtest.h>

namespace lcmslam {
namespace {

ColourView view(const cv::Size& size, int type) {
  ColourView v;
  v.image = cv::Mat(size, type);
  cv::randu(v.image, cv::Scalar::all(0), cv::Scalar::all(255));
  v.camera.width = v.depth_camera.width = size.width;
  v.camera.height = v.depth_camera.height = size.height;
  v.camera.fx = v.camera.fy = v.depth_camera.fx = v.depth_camera.fy = 60;
  return v;
}

RegistrationSettings both_views() {
  RegistrationSettings s;
  s.frustum = s.colour_overlap = true;
  return s;
}

// A camera may be changed, or its images' size or channels, while the map goes on.
TEST(LastView, ImagesOfAnotherSizeOrTypeBeginAnew) {
  const Eigen::Isometry3d here = Eigen::Isometry3d::Identity();
  LastView last(true, true, {});
  EXPECT_FALSE(last.possible(both_views()).colour_overlap);
  const ColourView first = view({80, 60}, CV_8UC3);
  last.keep(first, here);
  last.compare(first, here);
  EXPECT_TRUE(last.possible(both_views()).colour_overlap);
  for (const ColourView& other : {view({60, 80}, CV_8UC3), view({60, 80}, CV_8UC1)}) {
    ASSERT_NO_THROW(last.compare(other, here));
    EXPECT_FALSE(last.possible(both_views()).colour_overlap);
    EXPECT_TRUE(last.possible(both_views()).frustum);  // compares no images
    last.keep(other, here);
    last.compare(other, here);
    EXPECT_TRUE(last.possible(both_views()).colour_overlap);
  }
  ColourView nothing = first;
  nothing.image.release();
  last.compare(nothing, here);
  EXPECT_FALSE(last.possible(both_views()).colour_overlap);
  last.keep(std::nullopt, here);
  last.compare(first, here);
  EXPECT_FALSE(last.possible(both_views()).colour_overlap);
  EXPECT_FALSE(last.possible(both_views()).frustum);
}

}  // namespace
}  // namespace lcmslam
