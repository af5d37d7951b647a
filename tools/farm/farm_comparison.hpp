#pragma once
// Two farms over the same logs: what became better and worse, and whether that is more than chance among
// logs.

#include <string>
#include <vector>

#include "tools/farm/farm_results.hpp"

namespace lcmslam {

/// The errors of one log, after over before.
struct LogChange {
  std::string name;
  double before, after;  ///< m, ATE
  double ratio() const { return after / before; }
};

struct PathChange {
  std::string path;             ///< "icp", "fastslam"
  std::vector<LogChange> logs;  ///< of both farms, the largest change for the worse first
  /// Geometric mean of the ratios, and its 95 % interval among logs: Student's t of their logarithms, which
  /// of as few as six logs holds 1 in 95 % where nothing has changed (a bootstrap in 85 %). NaN without a
  /// log, the interval of one log, too.
  double ratio, low, high;
  /// Logs whose error is known of one farm alone, as where nothing was mapped: in no ratio.
  std::vector<std::string> only_before, only_after;
  /// Logs of which the mapper began a new map in either farm, which leaves its error that of a part: in no
  /// ratio.
  std::vector<std::string> restarted;

  /// "better", "worse", or "no difference shown" where the interval holds 1 or logs are too few for one: of
  /// five that all became better chance makes one time in sixteen as much.
  std::string verdict() const;
};

struct FarmComparison {
  std::vector<PathChange> paths;
  std::vector<std::string> broken;  ///< passed before and not now
  std::vector<std::string> mended;
  std::vector<std::string> missing, added;  ///< logs of one farm alone
};

FarmComparison compare_farms(const std::vector<FarmResult>& before, const std::vector<FarmResult>& after);

}  // namespace lcmslam
