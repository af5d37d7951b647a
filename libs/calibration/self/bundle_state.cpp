#include <lcmslam/calibration/self/bundle_state.hpp>

#include <algorithm>

#include <lcmslam/calibration/self/residuals.hpp>
#include <lcmslam/calibration/self/velocity_scale.hpp>

namespace lcmslam {

BundleState::BundleState(HeadModel& head, SceneObservations& observed)
    : model(head), scene(observed), curve(head.start.depth_max) {
  for (const ObservedKeyframe& keyframe : scene.keyframes) {
    starts.push_back(keyframe.T_world_camera.inverse());
    told_twists_.push_back(keyframe.twist);
    poses.push_back({});
  }
  const auto& d = model.start.colour.distortion;
  if (d.size() == 8) std::copy(d.begin() + 5, d.end(), rational);
}

Eigen::Vector3d BundleState::seen_by_colour(std::size_t keyframe, std::size_t landmark,
                                            double seconds) const {
  const double none[6] = {};
  return residuals::in_camera(starts[keyframe], scene.keyframes[keyframe].twist, none,
                              scene.landmarks[landmark].point.data(), seconds);
}

void BundleState::take_over() {
  for (std::size_t k = 0; k < poses.size(); ++k) {
    Eigen::Isometry3d moved = Eigen::Isometry3d::Identity();
    moved.linear() = so3_exp(Eigen::Vector3d(poses[k].data()));
    moved.translation() = Eigen::Vector3d(poses[k].data() + 3);
    starts[k] = moved * starts[k];
    scene.keyframes[k].T_world_camera = starts[k].inverse();
    poses[k] = {};
  }
  const VelocityScale scale = velocity_scale(scene.keyframes);
  for (std::size_t k = 0; k < told_twists_.size(); ++k)
    scene.keyframes[k].twist << scale.translation * told_twists_[k].head<3>(),
        scale.rotation * told_twists_[k].tail<3>();
}

}  // namespace lcmslam
