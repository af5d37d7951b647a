#pragma once
// What the last registered frame's cameras saw, for rejectors that compare the new frame with it: its frustum
// (thesis section 3.5) and which image segments both show (section 3.4.1).

#include <optional>

#include <lcmslam/registration/registration_settings.hpp>
#include <lcmslam/registration/rejection.hpp>
#include <lcmslam/registration/view_frustum.hpp>
#include <lcmslam/rgbd/colour_overlap.hpp>
#include <lcmslam/rgbd/colour_view.hpp>

namespace lcmslam {

class LastView {
 public:
  /// `frustum`, `overlap`: whether a pass of the registration asks for them.
  LastView(bool frustum, bool overlap, const ColourOverlapSettings& settings)
      : frustum_wanted_(frustum), overlap_wanted_(overlap), settings_(settings) {}

  /// Before a frame is registered. There may be no view, and its image may be empty; it must outlive the
  /// registration.
  void compare(const std::optional<ColourView>& now, const Eigen::Isometry3d& T_robot_camera);
  const SensorViews* views() const { return &views_; }
  /// The settings without the rejectors that have nothing to go by: there was no frame, or no image of this
  /// size and type.
  RegistrationSettings possible(RegistrationSettings settings) const;

  /// A registered frame becomes the last one.
  void keep(const std::optional<ColourView>& colour, const Eigen::Isometry3d& T_world_camera);
  /// The world moves.
  void move(const Eigen::Isometry3d& T_new_old) { T_world_camera_ = T_new_old * T_world_camera_; }

 private:
  bool frustum_wanted_, overlap_wanted_;
  ColourOverlapSettings settings_;
  std::optional<ColourView> last_;
  Eigen::Isometry3d T_world_camera_ = Eigen::Isometry3d::Identity();
  std::optional<ViewFrustum> frustum_;
  std::optional<ImageOverlap> overlap_;
  SensorViews views_;
};

/// The settings without any rejector that compares views.
RegistrationSettings without_views(RegistrationSettings settings);

}  // namespace lcmslam
