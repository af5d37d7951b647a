#pragma once
#include <string>
#include <vector>

#include <lcmslam/calibration/self/bundle_adjustment.hpp>

namespace lcmslam {

struct WantedAccuracy {
  double focal = 0.003;         ///< of the focal length, relative
  double translation = 0.002;   ///< m, of the depth camera's place
  double rotation = 0.0017453;  ///< rad, a tenth of a degree, of its direction
  double probability = 0.8;     ///< with which the errors are to be smaller
};

/// What a recording tells less well than is wanted, and how many keyframes, at most `most`, would tell it;
/// none: it tells enough. What keyframes add up to shrinks as their number grows; what no residual shows, and
/// the scale of the world in the distance of both cameras, stays.
std::vector<std::string> drive_advice(const HeadModel& model, const BundleResult& result,
                                      std::size_t keyframes, std::size_t most,
                                      const WantedAccuracy& wanted = {});

/// Why what was found is no calibration; none: it is one.
std::vector<std::string> self_doubts(const BundleResult& result, const BundleSettings& settings,
                                     std::size_t keyframes);

}  // namespace lcmslam
