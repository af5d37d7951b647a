#pragma once
// Least-squares rigid transforms between paired point sets: minimise sum w_i |T p_i - q_i|^2
// (thesis section 3.6). All estimators work on the same moments: with p' and q' centred on the
// weighted means c_S and c_T, H = sum w p' q'^T gives the rotation and t = c_T - R c_S (eq. 3.13).

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <lcmslam/geometry/transform.hpp>

namespace lcmslam {

enum class AlignmentStatus {
  ok,
  bad_input,   ///< sizes differ, a value is not finite or a weight is negative
  too_few,     ///< fewer than three pairs of positive weight
  coincident,  ///< all source or all target points are one point
  collinear    ///< all on one line: the rotation about it is free
};
std::string to_string(AlignmentStatus status);

struct RigidAlignment {
  AlignmentStatus status = AlignmentStatus::bad_input;
  Eigen::Isometry3d T_target_source = Eigen::Isometry3d::Identity();  ///< identity unless ok
  explicit operator bool() const { return status == AlignmentStatus::ok; }
};

/// What the pairs are reduced to.
struct PairMoments {
  double total = 0;  ///< sum of weights
  Eigen::Vector3d source_mean, target_mean;
  Eigen::Matrix3d cross;          ///< H = sum w p' q'^T
  Eigen::Matrix3d source_spread;  ///< sum w p' p'^T
};

/// Finds the rotation from the moments; the interface does what is common.
class RigidEstimator {
 public:
  virtual ~RigidEstimator() = default;
  /// Weights may be empty: all one. Never throws, never gives NaN.
  RigidAlignment estimate(const std::vector<Eigen::Vector3d>& source,
                          const std::vector<Eigen::Vector3d>& target,
                          const std::vector<double>& weights = {}) const;

 private:
  virtual Eigen::Matrix3d rotation(const PairMoments& moments) const = 0;
};

/// R = V diag(1, 1, det(V U^T)) U^T for H = U D V^T (eq. 3.12, corrected; Arun 1987, Umeyama 1991).
class SvdEstimator : public RigidEstimator {
 public:
  /// Without the correction R = V U^T as printed, which may be a reflection: for studies only.
  explicit SvdEstimator(bool correct_reflection = true) : correct_reflection_(correct_reflection) {}

 private:
  Eigen::Matrix3d rotation(const PairMoments& moments) const override;
  bool correct_reflection_;
};

/// Largest eigenvector of Horn's 4x4 matrix is the unit quaternion (w, x, y, z) (eq. 3.14,
/// corrected; Horn 1987).
class QuaternionEstimator : public RigidEstimator {
 public:
  enum class Form {
    corrected,
    as_printed  ///< eq. 3.14 with all signs plus: another rotation unless the moments are diagonal; for
                ///< studies
  };
  explicit QuaternionEstimator(Form form = Form::corrected) : form_(form) {}

 private:
  Eigen::Matrix3d rotation(const PairMoments& moments) const override;
  Form form_;
};

/// Solves q' - p' = omega x p' (eq. 3.18-3.26): one linear step whose error falls with the square of
/// the angle, meant for iteration.
class SmallAngleEstimator : public RigidEstimator {
 public:
  enum class Form {
    recomposed,  ///< the true rotation Rz(omega_z) Ry(omega_y) Rx(omega_x), eq. 3.17
    as_printed   ///< I + hat(omega), which is no rotation: for studies only
  };
  explicit SmallAngleEstimator(Form form = Form::recomposed) : form_(form) {}

 private:
  Eigen::Matrix3d rotation(const PairMoments& moments) const override;
  Form form_;
};

/// T_target_source by SVD with the determinant correction; nothing when the pairs do not fix a
/// rotation (fewer than three, coincident, or all on one line) or are bad input.
std::optional<Eigen::Isometry3d> align_svd(const std::vector<Eigen::Vector3d>& source,
                                           const std::vector<Eigen::Vector3d>& target,
                                           const std::vector<double>& weights = {});

}  // namespace lcmslam
