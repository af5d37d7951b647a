#include <lcmslam/dense_mapper/last_view.hpp>

namespace lcmslam {
namespace {

// Another camera, or another size of its images, begins anew.
bool comparable(const cv::Mat& a, const cv::Mat& b) {
  return !a.empty() && a.size() == b.size() && a.type() == b.type();
}

}  // namespace

void LastView::compare(const std::optional<ColourView>& now, const Eigen::Isometry3d& T_robot_camera) {
  frustum_.reset();
  overlap_.reset();
  if (!last_) return;
  if (frustum_wanted_) {
    frustum_.emplace(last_->depth_camera);
    views_.frustum = &*frustum_;
    views_.T_camera_target = (T_world_camera_ * last_->T_camera_depth).inverse();
  }
  if (overlap_wanted_ && now && comparable(now->image, last_->image)) {
    overlap_ = colour_overlap(now->image, last_->image, settings_);
    views_.overlap = &*overlap_;
    views_.source_camera = &now->camera;
    views_.T_camera_source = T_robot_camera.inverse();
  }
}

RegistrationSettings LastView::possible(RegistrationSettings settings) const {
  settings.frustum = settings.frustum && frustum_;
  settings.colour_overlap = settings.colour_overlap && overlap_;
  return settings;
}

void LastView::keep(const std::optional<ColourView>& colour, const Eigen::Isometry3d& T_world_camera) {
  if (!frustum_wanted_ && !overlap_wanted_) return;
  last_ = colour;
  T_world_camera_ = T_world_camera;
}

RegistrationSettings without_views(RegistrationSettings settings) {
  settings.frustum = settings.colour_overlap = false;
  return settings;
}

}  // namespace lcmslam
