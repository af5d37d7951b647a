#pragma once
// Keeps the strongest blobs without letting one textured corner take them all.

#include <vector>

#include <lcmslam/settings/settings.hpp>
#include <lcmslam/surf/extrema.hpp>

namespace lcmslam {

struct FeatureBudget {
  int max_features = 600;
  int columns = 8, rows = 6;
  double cell_share = 1.5;

  void describe(SettingsVisitor& s) {
    s.number("max_features", max_features, "", {0, 1e6},
             "keypoints that are kept of an image, the strongest, spread over it; 0: all");
    s.number("cell_columns", columns, "", {1, 1000},
             "cells over which keypoints are spread, from left to right");
    s.number("cell_rows", rows, "", {1, 1000}, "cells over which keypoints are spread, from top to bottom");
    s.number("cell_share", cell_share, "", {1, 1e6},
             "of its equal share of keypoints that a cell may take before the others have chosen; large: no "
             "spreading");
  }
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
