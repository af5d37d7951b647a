#pragma once
// The thesis's registrations of a frame against a growing target (chapter 3), as the mapper runs them in
// place of its own: plain ICP (algorithm 3.1), the proposed ICP (algorithm 3.2) and Frustum ICP
// (section 3.5).

#include <opencv2/core.hpp>
#include <optional>
#include <string>

#include <lcmslam/dense_mapper/thesis/alternating.hpp>
#include <lcmslam/dense_mapper/thesis/growing_cloud.hpp>
#include <lcmslam/rgbd/colour_overlap.hpp>
#include <lcmslam/settings/settings.hpp>

namespace lcmslam {

enum class VariantKind {
  modern,       ///< the mapper's own
  plain,        ///< 3.1 from the prediction
  alternating,  ///< 3.2 from the SURF correspondences with the last frame; from the prediction where there
                ///< are none
  frustum       ///< 3.1 from the prediction, with the points that the last frame's sensor could see
};
inline constexpr Choice<VariantKind> variant_names[] = {{"modern", VariantKind::modern},
                                                        {"plain", VariantKind::plain},
                                                        {"alternating", VariantKind::alternating},
                                                        {"frustum", VariantKind::frustum}};
inline std::string to_string(VariantKind kind) {
  return name_of(kind, variant_names);
}

struct ThesisSettings {
  AlternatingSettings icp;
  ColourOverlapSettings overlap;
  bool checked_features = true;
  double merge_distance = 0.02;

  void describe(SettingsVisitor& s) {
    icp.describe(s);
    s.section("overlap", overlap, "of the variant alternating: which part of the cloud the last frame shows");
    s.flag("checked_features", checked_features,
           "SURF correspondences pass RANSAC first; false: all, as in the thesis");
    s.number("merge_distance", merge_distance, "m", {0, 1000}, "nearer points of two clouds are one");
  }
};

/// What the colour camera saw, and where the depth camera beside it looked.
struct ColourView {
  cv::Mat image;
  CameraModel camera;
  CameraModel depth_camera;
  Eigen::Isometry3d T_camera_depth = Eigen::Isometry3d::Identity();
};

/// A frame as registration sees it.
struct ThesisFrame {
  const Cloud& cloud;  ///< robot frame
  const Eigen::Isometry3d& T_robot_camera;
  const FeatureFrame* features = nullptr;  ///< null where there are none
  const ColourView* colour = nullptr;
};

class ThesisVariant {
 public:
  /// Throws std::invalid_argument for `modern`, which is none of them, and for settings out of range.
  ThesisVariant(VariantKind kind, const ThesisSettings& settings);

  /// T_world_robot from a predicted one; a true rotation, whatever the estimator gives (a reflection counts
  /// as degenerate).
  RegistrationResult register_frame(const ThesisFrame& frame, const Eigen::Isometry3d& T_predicted) const;

  /// The frame, registered at T_world_robot, joins the target and becomes the last frame.
  void add(const ThesisFrame& frame, const Eigen::Isometry3d& T_world_robot);

  const GrowingCloud& target() const { return target_; }

 private:
  RegistrationResult register_plain(const Cloud& cloud, const Eigen::Isometry3d& T_start) const;
  RegistrationResult register_in_view(const ThesisFrame& frame, const Eigen::Isometry3d& T_start) const;
  RegistrationResult register_by_turns(const ThesisFrame& frame, const Eigen::Isometry3d& T_start) const;
  Cloud seen_by_both(const ThesisFrame& frame) const;
  FeaturePairs surf_pairs(const ThesisFrame& frame) const;

  VariantKind kind_;
  ThesisSettings settings_;
  GrowingCloud target_;
  // The last registered frame.
  Eigen::Isometry3d T_world_camera_ = Eigen::Isometry3d::Identity();
  std::optional<FeatureFrame> features_;
  std::optional<ColourView> colour_;
};

}  // namespace lcmslam
