#pragma once
// How a camera turned between two images, by their pixels: where depth and colour are of two moments, points
// err along their rays, and an alignment of points would turn as the depth camera did.

#include <optional>

#include <lcmslam/features/feature.hpp>
#include <lcmslam/features/matching.hpp>
#include <lcmslam/geometry/random.hpp>

namespace lcmslam {

class CameraTurn {
 public:
  explicit CameraTurn(std::uint64_t seed = 1) : random_(seed) {}

  struct Step {
    Utime from, to;
    Eigen::Vector3d turn;  ///< rotation vector of R_from_to, rad, camera frame
  };
  /// From the frame before to this one; nothing for the first, and where too few features agree.
  std::optional<Step> add(const FeatureFrame& frame);

 private:
  Random random_;
  Matcher matcher_;
  std::optional<FeatureFrame> last_;
};

/// T_a_b that brings the points of either frame onto the pixels of the other, from a start near it; `matches`
/// agree.
Eigen::Isometry3d refine_by_pixels(const FeatureFrame& a, const FeatureFrame& b,
                                   const std::vector<Match>& matches, Eigen::Isometry3d T_a_b);

}  // namespace lcmslam
