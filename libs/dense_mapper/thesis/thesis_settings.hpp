#pragma once
// Which registration places the frames, and the settings of the thesis's.

#include <string>

#include <lcmslam/dense_mapper/thesis/alternating.hpp>
#include <lcmslam/rgbd/colour_overlap.hpp>

namespace lcmslam {

enum class VariantKind {
  modern,       ///< the mapper's own
  plain,        ///< 3.1 from the prediction
  alternating,  ///< 3.2 from the SURF correspondences with the last frame; from the prediction where there
                ///< are none
  frustum       ///< 3.1 from the prediction, with the points that the last frame's sensor could see
};
std::string to_string(VariantKind kind);

struct ThesisSettings {
  AlternatingSettings icp;        ///< `icp.registration` is one iteration of every variant
  ColourOverlapSettings overlap;  ///< of alternating
  bool checked_features = true;   ///< SURF correspondences pass RANSAC first; false: all, as in the thesis
  double merge_distance = 0.02;   ///< m; nearer points of two clouds are one
};

}  // namespace lcmslam
