#include "tools/study/feature_methods.hpp"

#include <algorithm>
#include <numeric>
#include <opencv2/features2d.hpp>
#include <tuple>

#include <lcmslam/surf/surf.hpp>

namespace lcmslam {
namespace {

/// Any cv::Feature2D.
class OpenCvMethod : public FeatureMethod {
 public:
  OpenCvMethod(std::string name, std::string family, cv::Ptr<cv::Feature2D> feature)
      : name_(std::move(name)), family_(std::move(family)), feature_(std::move(feature)) {}

  std::string name() const override { return name_; }
  std::string family() const override { return family_; }
  cv::NormTypes norm() const override { return static_cast<cv::NormTypes>(feature_->defaultNorm()); }
  ImageFeatures compute(const cv::Mat& grey) override {
    ImageFeatures found;
    feature_->detectAndCompute(grey, cv::noArray(), found.keypoints, found.descriptors);
    return found;
  }

 private:
  std::string name_, family_;
  cv::Ptr<cv::Feature2D> feature_;
};

std::unique_ptr<FeatureMethod> opencv_method(const std::string& name, int count,
                                             cv::Ptr<cv::Feature2D> feature) {
  return std::make_unique<OpenCvMethod>(name + " " + std::to_string(count), name, std::move(feature));
}

}  // namespace

ImageFeatures first_features(const ImageFeatures& features, std::size_t count) {
  if (features.keypoints.size() <= count) return features;
  return {{features.keypoints.begin(), features.keypoints.begin() + static_cast<std::ptrdiff_t>(count)},
          features.descriptors.rowRange(0, static_cast<int>(count))};
}

ImageFeatures strongest_first(const ImageFeatures& features) {
  std::vector<std::size_t> order(features.keypoints.size());
  std::iota(order.begin(), order.end(), 0);
  const auto key = [&](std::size_t i) {
    const cv::KeyPoint& k = features.keypoints[i];
    return std::make_tuple(-k.response, k.pt.y, k.pt.x, k.size, k.angle);
  };
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return key(a) < key(b); });
  ImageFeatures sorted;
  sorted.descriptors.create(features.descriptors.size(), features.descriptors.type());
  for (std::size_t i = 0; i < order.size(); ++i) {
    sorted.keypoints.push_back(features.keypoints[order[i]]);
    features.descriptors.row(static_cast<int>(order[i])).copyTo(sorted.descriptors.row(static_cast<int>(i)));
  }
  return sorted;
}

std::unique_ptr<FeatureMethod> lcmslam_surf_method(int count, bool extended) {
  SurfSettings settings;
  settings.hessian_threshold = 5;  // the number of keypoints decides, as for the others
  settings.budget.max_features = count;
  settings.budget.cell_share = 1e6;  // no spreading, as the others
  settings.extended = extended;
  const std::string family = "lcmslam SURF";
  return std::make_unique<OpenCvMethod>(family + (extended ? " 128-D " : " ") + std::to_string(count), family,
                                        Surf::create(settings));
}

std::unique_ptr<FeatureMethod> sift_method(int count) {
  return opencv_method("cv::SIFT", count, cv::SIFT::create(count));
}

std::unique_ptr<FeatureMethod> orb_method(int count) {
  return opencv_method("cv::ORB", count, cv::ORB::create(count));
}

FeatureMethods all_feature_methods(int count) {
  FeatureMethods methods;
  methods.push_back(lcmslam_surf_method(count));
  methods.push_back(lcmslam_surf_method(count / 2));
  methods.push_back(lcmslam_surf_method(count, true));
  if (auto method = dlib_surf_method(count)) methods.push_back(std::move(method));
  methods.push_back(sift_method(count));
  methods.push_back(orb_method(count));
  return methods;
}

}  // namespace lcmslam
