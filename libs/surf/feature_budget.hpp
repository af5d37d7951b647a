#pragma once
// Keeps the strongest blobs without letting one textured corner take them all.

#include <vector>

#include <lcmslam/surf/extrema.hpp>

namespace lcmslam {

struct FeatureBudget {
  int max_features = 600;     ///< 0: no limit
  int columns = 8, rows = 6;  ///< cells over which the features are spread
  /// A cell may take this many times its equal share before the others have chosen; what then remains
  /// of the budget goes to the strongest left over. At least 1; large values mean no spreading.
  double cell_share = 1.5;
};

/// Keeps at most max_features blobs, strongest first; ties by position, so that the order is defined.
class BlobSelection {
 public:
  /// Reuses its memory from call to call.
  void select(std::vector<Blob>& blobs, const FeatureBudget& budget, int width, int height);

 private:
  std::vector<int> taken_;  ///< by cell
  std::vector<char> kept_;  ///< by blob
};

}  // namespace lcmslam
