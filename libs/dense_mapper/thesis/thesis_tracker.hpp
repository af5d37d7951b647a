#pragma once
// The thesis's registrations of a frame against a growing target (chapter 3), as the mapper runs them in
// place of its own: plain ICP (algorithm 3.1), the proposed ICP (algorithm 3.2) and Frustum ICP
// (section 3.5). They take a prediction for a start and no more, and believe what converges. The target
// knows no graph: it stays as it is when the map is deformed.

#include <optional>

#include <lcmslam/dense_mapper/thesis/growing_cloud.hpp>
#include <lcmslam/dense_mapper/thesis/thesis_settings.hpp>
#include <lcmslam/dense_mapper/tracker.hpp>

namespace lcmslam {

/// The start that the settings name, or the variant's own.
StartKind start_kind(VariantKind variant, const ThesisSettings& settings);
/// Whether a registration is another one without its frame's SURF features: then frames wait for them.
bool needs_features(VariantKind variant, const ThesisSettings& settings);

class ThesisTracker : public Tracker {
 public:
  /// Throws std::invalid_argument for `modern`, which is none of them, and for settings out of range.
  ThesisTracker(VariantKind kind, const ThesisSettings& settings);

  Tracked track(const PreparedFrame& prepared, const Expectation& expected) override;
  /// The frame joins the target and becomes the last frame, whoever placed it.
  void accept(const PreparedFrame& prepared, const Eigen::Isometry3d& T_world_robot,
              bool registered) override;

  /// T_world_robot from a predicted one; a true rotation, whatever the estimator gives (a reflection counts
  /// as degenerate).
  RegistrationResult register_frame(const PreparedFrame& prepared,
                                    const Eigen::Isometry3d& T_predicted) const;

  const GrowingCloud& target() const { return target_; }

  /// The published map is the target (section 3.3).
  bool grows() const override { return true; }
  ColouredCloud joined() const override { return joined_; }

  std::size_t memory_bytes() const override {
    return target_.memory_bytes() + lcmslam::memory_bytes(joined_);
  }

 private:
  Eigen::Isometry3d start_of(const PreparedFrame& prepared, const Eigen::Isometry3d& T_predicted) const;
  RegistrationResult register_plain(const Cloud& cloud, const Eigen::Isometry3d& T_start) const;
  RegistrationResult register_in_view(const PreparedFrame& prepared, const Eigen::Isometry3d& T_start) const;
  RegistrationResult register_by_turns(const PreparedFrame& prepared, const Eigen::Isometry3d& T_start) const;
  Cloud seen_by_both(const PreparedFrame& prepared) const;
  FeaturePairs surf_pairs(const DenseFrame& frame) const;

  VariantKind kind_;
  ThesisSettings settings_;
  GrowingCloud target_;
  // The last registered frame.
  Eigen::Isometry3d T_world_robot_ = Eigen::Isometry3d::Identity();
  Eigen::Isometry3d T_world_camera_ = Eigen::Isometry3d::Identity();
  ColouredCloud joined_;  // what it added to the target
  std::optional<FeatureFrame> features_;
  std::optional<ColourView> colour_;
};

}  // namespace lcmslam
