#include <lcmslam/calibration/self/bundle_state.hpp>

#include <algorithm>

#include <lcmslam/calibration/self/residuals.hpp>
#include <lcmslam/calibration/self/velocity_scale.hpp>

namespace lcmslam {

static_assert(std::tuple_size_v<decltype(BundleState::moved)::value_type> == residuals::keyframe_size);

BundleState::BundleState(HeadModel& head, SceneObservations& observed)
    : model(head), scene(observed), curve(head.start.depth_max) {
  for (const ObservedKeyframe& keyframe : scene.keyframes) {
    starts.push_back(keyframe.T_world_camera.inverse());
    first_twists_.push_back(keyframe.twist);
    moved.push_back({});
  }
  told_twists = first_twists_;
  const auto& d = model.start.colour.distortion;
  if (d.size() == 8) std::copy(d.begin() + 5, d.end(), rational);
}

Eigen::Vector3d BundleState::seen_by_colour(std::size_t keyframe, std::size_t landmark,
                                            double seconds) const {
  const double none[residuals::keyframe_size] = {};
  return residuals::in_camera(starts[keyframe], scene.keyframes[keyframe].twist, none,
                              scene.landmarks[landmark].point.data(), seconds);
}

void BundleState::take_over() {
  std::vector<Eigen::Vector3d> faster;  // turn rates, than was told
  for (std::size_t k = 0; k < moved.size(); ++k) {
    Eigen::Isometry3d step = Eigen::Isometry3d::Identity();
    step.linear() = so3_exp(Eigen::Vector3d(moved[k].data()));
    step.translation() = Eigen::Vector3d(moved[k].data() + 3);
    starts[k] = step * starts[k];
    scene.keyframes[k].T_world_camera = starts[k].inverse();
    faster.emplace_back((scene.keyframes[k].twist - told_twists[k]).tail<3>() +
                        Eigen::Vector3d(moved[k].data() + residuals::turn_rate_at));
    moved[k] = {};
  }
  const VelocityScale scale = velocity_scale(scene.keyframes);
  for (std::size_t k = 0; k < told_twists.size(); ++k) {
    told_twists[k] << scale.translation * first_twists_[k].head<3>(),
        scale.rotation * first_twists_[k].tail<3>();
    scene.keyframes[k].twist = told_twists[k];
    scene.keyframes[k].twist.tail<3>() += faster[k];
  }
}

}  // namespace lcmslam
