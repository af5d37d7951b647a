#pragma once
// Pairs that are wrong are left out before the solver sees them.

#include <memory>

#include <lcmslam/cloud/cloud.hpp>
#include <lcmslam/cloud/kd_tree.hpp>
#include <lcmslam/registration/image_overlap.hpp>
#include <lcmslam/registration/pair.hpp>
#include <lcmslam/registration/registration_settings.hpp>
#include <lcmslam/registration/view_frustum.hpp>

namespace lcmslam {

/// What both sensors saw, for the rejectors that ask. What is pointed to must outlive the registration.
struct SensorViews {
  // Frustum: of the target's last registered sensor.
  const ViewFrustum* frustum = nullptr;
  Eigen::Isometry3d T_camera_target = Eigen::Isometry3d::Identity();
  // Colour overlap: of the source's image with the target's, in the source's camera.
  const ImageOverlap* overlap = nullptr;
  const CameraModel* source_camera = nullptr;
  Eigen::Isometry3d T_camera_source = Eigen::Isometry3d::Identity();
};

class Rejector {
 public:
  virtual ~Rejector() = default;
  /// Erases pairs, keeping the order of the others. The pairs were moved by T_target_source.
  virtual void reject(std::vector<Pair>& pairs, const Eigen::Isometry3d& T_target_source) const = 0;
};

/// Normals that differ by more than an angle (Pulli 1999); unknown normals pass.
class NormalAngleRejector : public Rejector {
 public:
  explicit NormalAngleRejector(double max_angle);
  void reject(std::vector<Pair>& pairs, const Eigen::Isometry3d& T_target_source) const override;

 private:
  double min_cosine_;
};

/// Keeps the nearest fraction (Chetverikov 2002, trimmed ICP).
class TrimmedRejector : public Rejector {
 public:
  explicit TrimmedRejector(double kept_fraction) : kept_fraction_(kept_fraction) {}
  void reject(std::vector<Pair>& pairs, const Eigen::Isometry3d& T_target_source) const override;

 private:
  double kept_fraction_;
};

/// Without the target's normal there is no plane; plane-to-plane needs the source's too.
class MissingNormalRejector : public Rejector {
 public:
  explicit MissingNormalRejector(bool both = false) : both_(both) {}
  void reject(std::vector<Pair>& pairs, const Eigen::Isometry3d& T_target_source) const override;

 private:
  bool both_;
};

/// Keeps pairs whose target point has no nearer source point (Pajdla and Van Gool 1995).
class MutualRejector : public Rejector {
 public:
  explicit MutualRejector(const Cloud& source) : tree_(source.points) {}
  void reject(std::vector<Pair>& pairs, const Eigen::Isometry3d& T_target_source) const override;

 private:
  KdTree tree_;
};

/// Partners where the target ends: what lies beyond was not seen, so that they pull (Turk and Levoy 1994).
class BoundaryRejector : public Rejector {
 public:
  void reject(std::vector<Pair>& pairs, const Eigen::Isometry3d& T_target_source) const override;
};

/// Source points outside the view of the target's sensor (thesis section 3.5), judged anew as they move.
class FrustumRejector : public Rejector {
 public:
  FrustumRejector(const ViewFrustum& frustum, const Eigen::Isometry3d& T_camera_target)
      : frustum_(frustum), T_camera_target_(T_camera_target.cast<float>()) {}
  void reject(std::vector<Pair>& pairs, const Eigen::Isometry3d& T_target_source) const override;

 private:
  const ViewFrustum& frustum_;
  Eigen::Isometry3f T_camera_target_;
};

/// Source points whose image segment the target's image does not show (thesis section 3.4.1).
class ColourOverlapRejector : public Rejector {
 public:
  ColourOverlapRejector(const Cloud& source, const SensorViews& views);
  void reject(std::vector<Pair>& pairs, const Eigen::Isometry3d& T_target_source) const override;

 private:
  std::vector<bool> outside_;  // of each source point
};

/// The chain that the settings ask for. Throws std::invalid_argument when they ask for a view that is not
/// given.
std::vector<std::unique_ptr<Rejector>> make_rejectors(const RegistrationSettings& settings,
                                                      const Cloud& source,
                                                      const SensorViews* views = nullptr);

}  // namespace lcmslam
