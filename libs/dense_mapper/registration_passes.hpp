#pragma once
// A cloud's registration from one start: a coarse pass over few points from far, a fine one, and what their
// result is worth.

#include <lcmslam/dense_mapper/dense_mapper_settings.hpp>
#include <lcmslam/dense_mapper/last_view.hpp>
#include <lcmslam/dense_mapper/tracker.hpp>

namespace lcmslam {

class RegistrationPasses {
 public:
  /// Reads the settings coarse, fine and those of trust.
  explicit RegistrationPasses(const DenseMapperSettings& settings) : settings_(settings) {}

  struct Attempt {
    RegistrationResult registration;
    MappingStatus status = MappingStatus::lost;
    double quality = 0;  ///< 0..1: overlap times share of inliers
  };
  /// `prior` of T_world_robot. A start far from it is a recovery: what was expected is no knowledge then, and
  /// the result must be good. `last` serves the rejectors that compare views.
  Attempt run(const PreparedFrame& prepared, const Target& target, const Eigen::Isometry3d& T_start,
              const Prior& prior, const LastView& last) const;

 private:
  bool is_beyond(const Eigen::Isometry3d& T_world_robot, const Prior& prior) const;
  MappingStatus judge(const RegistrationResult& result, const Prior& prior) const;

  DenseMapperSettings settings_;
};

}  // namespace lcmslam
