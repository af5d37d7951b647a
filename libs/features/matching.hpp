#pragma once
// Which feature of one image is which of another: mutual nearest neighbours of the byte descriptors,
// by brute force. Against a map that grows, descriptor_search.hpp; where a pose is predicted,
// guided_matching.hpp: all give the same kind of Match.

#include <vector>

#include <lcmslam/features/descriptor_distance.hpp>
#include <lcmslam/features/feature.hpp>
#include <lcmslam/settings/settings.hpp>

namespace lcmslam {

struct Match {
  int a = 0, b = 0;   ///< indices into the two sets
  int distance2 = 0;  ///< squared Euclidean distance of the bytes
};

struct MatchingSettings {
  double ratio = 0.8;
  bool same_laplacian = true;

  void describe(SettingsVisitor& s) {
    s.number(
        "ratio", ratio, "", {0.01, 1},
        "of the distances to the nearest and the second nearest descriptor (Lowe); 1: only the mutual test");
    s.flag("same_laplacian", same_laplacian,
           "blobs match only blobs of the same Laplacian sign (Bay et al. 2008, section 4.3)");
  }
};

/// Keeps its buffers: matching sets no larger than earlier ones allocates nothing. One instance a
/// thread. The matches stay valid until the next call.
class Matcher {
 public:
  /// All instruction sets give the same matches. Throws std::invalid_argument without that set.
  explicit Matcher(InstructionSet set = best_instruction_set()) : distances_(distance_function(set)) {}

  /// Matches ordered by a. a and b must be each other's nearest; of equally near ones the first counts.
  /// The ratio is taken among those that the Laplacian admits; with just one candidate it holds.
  /// Throws std::invalid_argument when the ratio is not in (0, 1].
  const std::vector<Match>& match(const std::vector<Feature>& a, const std::vector<Feature>& b,
                                  const MatchingSettings& settings = {});

  /// The same without signs.
  const std::vector<Match>& match(const std::vector<Descriptor>& a, const std::vector<Descriptor>& b,
                                  double ratio = 0.8);

 private:
  struct Queries {
    std::vector<int> index;  // into the caller's set
    std::vector<WideDescriptor> wide;
  };
  struct Targets {
    std::vector<int> index;
    std::vector<Descriptor> bytes;
    std::vector<std::int32_t> norms2;
  };
  struct Row {  // of four queries: their nearest targets
    Int4 nearest, second, target;
  };
  struct Column {  // of one target: its nearest query among those of each lane
    Int4 nearest, group;
  };

  void clear();
  void add_a(int index, const Descriptor& descriptor);
  void add_b(int index, const Descriptor& descriptor);
  void match_sets(double ratio);
  void fill_tables();
  int nearest_query(const Column& column) const;

  DistanceFunction distances_;
  Queries a_;
  Targets b_;
  std::vector<Row> rows_;
  std::vector<Column> columns_;
  std::vector<Match> matches_;
};

/// As Matcher::match, for callers who match now and then.
std::vector<Match> match(const std::vector<Feature>& a, const std::vector<Feature>& b,
                         const MatchingSettings& settings = {});

std::vector<Match> match(const std::vector<Descriptor>& a, const std::vector<Descriptor>& b,
                         double ratio = 0.8);

/// Squared Euclidean distance of two byte descriptors.
int squared_distance(const Descriptor& a, const Descriptor& b);

/// Throws std::invalid_argument unless it lies in (0, 1].
void check_ratio(double ratio);

/// Lowe's test on squared distances: nearest < ratio * second. 1 admits all.
inline bool passes_ratio(int nearest2, int second2, double ratio) {
  return ratio >= 1 || nearest2 < ratio * ratio * second2;
}

}  // namespace lcmslam
