#pragma once
// Matching with a predicted camera pose: each landmark is sought only where it should be seen. The larger
// the map, the more strangers look alike somewhere in it: here they compete only where they project to
// the same place, so the ratio test keeps its meaning and more matches pass it.
//
//   GuidedMatcher matcher;                               // one a thread
//   const GuidedResult& found = matcher.match(frame, predicted, landmarks, index);
//   if (!found.supported()) search the whole map (DescriptorSearch);
//
// A wrong prediction does not go unnoticed: matches that come about by chance are counted on the same
// features and landmarks, see GuidedResult.

#include <vector>

#include <lcmslam/features/descriptor_index.hpp>
#include <lcmslam/features/matching.hpp>
#include <lcmslam/features/projection.hpp>

namespace lcmslam {

struct GuidedSettings {
  /// A feature is a candidate for a landmark when innovation' S^-1 innovation is below this: chi-square
  /// with 2 DoF, 99 % of the right ones (Bar-Shalom, Li & Kirubarajan 2001, section 1.4.17) where a feature
  /// is as sharp as the frame's pixel_sigma. Large blobs are found less often, of 67 pixels every second
  /// where the pose is well known: gates as wide as their own pixel_sigma() cost more and made no map better.
  double chi_square = 9.210;
  /// Where the prediction knows little, gates cover the image and nothing is gained: landmarks whose gate
  /// reaches farther than this (pixels, half width or height) are left out and counted.
  double max_gate = 120;
  /// To the second nearest landmark among those whose gates hold the feature, as in MatchingSettings.
  /// A landmark whose place, by the covariances of both, may be the nearest one's is no rival: it is the
  /// same thing mapped twice. Likewise to the landmark's second nearest feature inside its gate.
  double ratio = 0.8;
  /// Between descriptors of unit norm. A lone candidate passes any ratio: this must refuse it.
  double max_distance = 0.45;
  /// m: nearer landmarks are the same thing, too, however sure both places are (a blob measured from two
  /// sides, a landmark of which an earlier one was lost for a while).
  double same_place = 0;
  /// Pixels: landmarks predicted up to so far outside the image may still show in it.
  double margin = 0;
};

struct GuidedResult {
  /// a: feature of the frame, b: landmark's id; mutual nearest among candidates. Ordered by a.
  std::vector<Match> matches;
  int in_view = 0;     ///< landmarks predicted inside the image
  int too_vague = 0;   ///< of these, left out by max_gate
  int candidates = 0;  ///< pairs of feature and landmark inside gates
  /// Matches when every landmark is sought in the gate of another, far down the list: what chance alone
  /// gives. Where the prediction is wrong, `matches` are no more than these.
  int by_chance = 0;
  /// Mean innovation' S^-1 innovation of the matches: about 2 when pose and covariance tell the truth
  /// (over many frames: one pose's error is common to all its matches), chi_square / 2 when the matches lie
  /// anywhere in their gates.
  double mean_squared_innovation = 0;

  /// More matches than chance explains: the difference of the two counts exceeds three of its standard
  /// deviations (counts as Poisson). At least ten matches.
  bool supported() const;
};

/// Keeps its buffers between calls.
class GuidedMatcher {
 public:
  /// Ids that are not in the index, settings out of range, a pose that is not finite or a frame without
  /// focal length or pixel_sigma throw std::invalid_argument. Landmarks behind the camera or not finite
  /// are not in view. Valid until the next call.
  const GuidedResult& match(const FeatureFrame& frame, const PredictedPose& pose,
                            const std::vector<MapPoint>& landmarks, const DescriptorIndex& index,
                            const GuidedSettings& settings = {});

 private:
  struct Gate {
    int id;
    bool dark;
    const Descriptor* descriptor;
    const MapPoint* landmark;
    Eigen::Vector2d centre;
    Eigen::Matrix2d information;     // S^-1
    double half_width, half_height;  // of the box around the ellipse
    std::int32_t norm2 = -1;         // of the descriptor, once it is needed

    double squared_innovation(double x, double y) const;
  };
  /// A feature, in the order of the grid's cells.
  struct Sought {
    float x, y;
    int feature;
    bool dark;
  };
  struct Pair {
    int feature, gate, distance2;
  };
  struct Nearest {
    int distance2, second2, partner;
  };

  void open_gates(const FeatureFrame& frame, const PredictedPose& pose,
                  const std::vector<MapPoint>& landmarks, const DescriptorIndex& index,
                  const GuidedSettings& settings);
  void fill_grid(const FeatureFrame& frame);
  void compare(std::size_t shift, const GuidedSettings& settings);
  void measure(std::size_t gate, int relevant);
  void find_nearest(std::size_t features, double same_place);
  bool is_match(std::size_t feature, const GuidedSettings& settings) const;
  int column(double x) const;
  int row(double y) const;

  GuidedResult result_;
  std::vector<Gate> gates_;
  int columns_ = 0, rows_ = 0;
  std::vector<int> cell_begin_;
  std::vector<Sought> sought_;
  std::vector<WideDescriptor> wide_;  // theirs
  DistanceFunction distances_ = distance_function();
  std::vector<std::size_t> inside_;  // of the gate at work, in sought_
  std::vector<Pair> pairs_;          // inside gates, similar enough to count
  std::vector<Nearest> of_feature_, of_gate_;
};

}  // namespace lcmslam
