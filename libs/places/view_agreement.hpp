#pragma once
// Does one see through what the map says is there?

#include <lcmslam/cloud/cloud.hpp>
#include <lcmslam/features/feature.hpp>

namespace lcmslam {

struct ViewAgreement {
  int compared = 0;         ///< cells of a coarse image that both have something in
  double agrees = 0;        ///< share of them in which both are as far
  double seen_through = 0;  ///< in which the map is nearer: what was looked through there
};

/// Both clouds in the camera's frame, m; `camera`: its image and intrinsics.
ViewAgreement compare_views(const Cloud& map, const Cloud& seen, const FeatureFrame& camera);

}  // namespace lcmslam
