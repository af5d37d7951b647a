#pragma once
// How often two clouds whose relative pose nobody knows are registered rightly, by the thesis's algorithm
// 3.2, by plain ICP and by the start of the modern mapper, over the distance between the two images.

#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "procs/camera/camera_source.hpp"
#include "tools/study/pair_view.hpp"

namespace lcmslam {

/// T_target_source by some method; nothing when it gives up.
struct PairMethod {
  std::string name;
  std::function<std::optional<Eigen::Isometry3d>(const PairView& source, const PairView& target)> solve;
};

/// Plain ICP, SURF alone, algorithm 3.2 with several ratios and both pairings, the modern start.
std::vector<PairMethod> pair_methods();

struct PairStudySettings {
  std::vector<int> apart = {10, 20, 30};  ///< frames between the two images of a pair
  int starts = 20;                        ///< first images, spread evenly over the recording
  double voxel_size = 0.04;               ///< m, of the clouds
  double max_translation = 0.05;          ///< m; a right result is within
  double max_rotation = 2;                ///< degrees
  double min_overlap = 0.3;  ///< of the source by the target at the true pose; fewer are left out
  double truth_offset = 0;   ///< s, added to images' stamps to give the truth's clock

  void check() const;  ///< throws std::invalid_argument naming the wrong value
};

/// A pair that came out wrong.
struct PairMiss {
  Utime source = 0, target = 0;  ///< us, of the colour images
  double translation = 0;        ///< m; NaN where the method gave up
  double rotation = 0;           ///< degrees
};

struct PairScore {
  std::string method;
  int apart = 0;
  int pairs = 0, solved = 0, right = 0;
  double median_translation = 0, median_rotation = 0;  ///< m and degrees, of the right ones
  double milliseconds = 0;                             ///< median processor time of one thread
  std::vector<PairMiss> misses;
};

struct PairStudyResult {
  std::vector<PairScore> scores;
  int little_overlap = 0, unreadable = 0;  ///< pairs left out
};

/// Throws std::invalid_argument when the source has no true poses or too few frames.
PairStudyResult study_pairs(CameraSource& source, const std::vector<PairMethod>& methods,
                            const PairStudySettings& settings);

std::string pair_table(const PairStudyResult& result);
nlohmann::json pair_json(const PairStudyResult& result, const PairStudySettings& settings);

}  // namespace lcmslam
