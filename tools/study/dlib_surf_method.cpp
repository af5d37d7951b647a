// The one file that includes dlib.
#if __has_include(<dlib/image_keypoint/surf.h>)
#define LCMSLAM_HAS_DLIB
#include <dlib/test_for_odr_violations.h>
// Debian's configuration asks for BLAS and LAPACK, which SURF never calls: without them nothing of dlib
// has to be linked.
#undef DLIB_USE_BLAS
#undef DLIB_USE_LAPACK
#include <dlib/image_keypoint/surf.h>
#include <dlib/opencv/cv_image.h>
#endif

#include "tools/study/feature_methods.hpp"

namespace lcmslam {

#ifdef LCMSLAM_HAS_DLIB
namespace {

class DlibSurf : public FeatureMethod {
 public:
  explicit DlibSurf(int count) : count_(count) {}

  std::string name() const override { return family() + " " + std::to_string(count_); }
  std::string family() const override { return "dlib SURF"; }
  cv::NormTypes norm() const override { return cv::NORM_L2; }

  ImageFeatures compute(const cv::Mat& grey) override {
    constexpr int length = 64;
    // Threshold 1 instead of 30: the number of keypoints decides.
    const auto points = dlib::get_surf_points(dlib::cv_image<unsigned char>(grey), count_, 1.);
    ImageFeatures found;
    found.descriptors.create(static_cast<int>(points.size()), length, CV_32F);
    for (std::size_t i = 0; i < points.size(); ++i) {
      const auto& p = points[i];
      const double degrees = p.angle * 180 / CV_PI;
      found.keypoints.emplace_back(static_cast<float>(p.p.center.x()), static_cast<float>(p.p.center.y()),
                                   static_cast<float>(p.p.scale * 9 / 1.2),
                                   static_cast<float>(degrees < 0 ? degrees + 360 : degrees),
                                   static_cast<float>(p.p.score), 0, p.p.laplacian > 0 ? 1 : -1);
      float* row = found.descriptors.ptr<float>(static_cast<int>(i));
      for (long k = 0; k < length; ++k) row[k] = static_cast<float>(p.des(k));
    }
    return found;
  }

 private:
  int count_;
};

}  // namespace

std::unique_ptr<FeatureMethod> dlib_surf_method(int count) {
  return std::make_unique<DlibSurf>(count);
}
#else
std::unique_ptr<FeatureMethod> dlib_surf_method(int) {
  return nullptr;
}
#endif

}  // namespace lcmslam
