#pragma once
// The nearest descriptors of a DescriptorIndex for all features of a frame at once.
//
//   DescriptorIndex index;                                   // of the map
//   for (const Landmark& l : ...) index.insert(l.id, l.descriptor, l.laplacian);
//   DescriptorSearch search;                                 // one a thread
//   for (const Match& m : search.match(frame.features, index)) use(frame.features[m.a], landmark m.b);
//
// The larger the map, the more often a stranger is as near as the right landmark, and Lowe's ratio test
// refuses what is right. So where it is known which landmarks can be in view, pass their ids: they alone
// are compared then, all of them.

#include <array>
#include <cstdint>
#include <limits>
#include <vector>

#include <lcmslam/features/descriptor_index.hpp>
#include <lcmslam/features/matching.hpp>

namespace lcmslam {

struct Neighbour {
  int id = -1;  ///< -1: there is none
  int distance2 = std::numeric_limits<int>::max();
};

/// Nearest first, of equally near ones the smaller id. The third serves where the second turns out to
/// be the same thing mapped twice.
using Neighbours = std::array<Neighbour, 3>;

struct SearchSettings {
  /// Of the descriptors of its sign a query is compared with at least this share, those of the nearest
  /// lists; 1 compares with all. 0.1 found nearest and second nearest of 98 % of real queries among
  /// 20,000 (bench_matching).
  double share = 0.1;
  int at_least = 500;  ///< descriptors, however small the share: small maps are searched wholly
};

/// Keeps its buffers between calls. Several may search one index at the same time, while nobody changes it.
class DescriptorSearch {
 public:
  /// Throws std::invalid_argument when the share is not in (0, 1], at_least is below 1, or the processor
  /// lacks the instructions.
  explicit DescriptorSearch(const SearchSettings& settings = {}, InstructionSet set = best_instruction_set());

  /// One entry a query, among the descriptors of its Laplacian's sign. Valid until the next call.
  const std::vector<Neighbours>& nearest(const std::vector<Feature>& queries, const DescriptorIndex& index);

  /// The same without the ids for which it says so; those beyond its end count.
  const std::vector<Neighbours>& nearest_without(const std::vector<bool>& left_out,
                                                 const std::vector<Feature>& queries,
                                                 const DescriptorIndex& index);

  /// The same, exact, among these ids. Ids that are not in the index throw std::invalid_argument; one
  /// that stands twice counts once.
  const std::vector<Neighbours>& nearest(const std::vector<Feature>& queries, const DescriptorIndex& index,
                                         const std::vector<int>& ids);

  /// Match::a numbers the queries, Match::b is the id: nearest, passing the ratio to the second nearest,
  /// and no other query nearer to that descriptor. Ordered by a. Valid until the next call.
  const std::vector<Match>& match(const std::vector<Feature>& queries, const DescriptorIndex& index,
                                  double ratio = 0.8);
  const std::vector<Match>& match(const std::vector<Feature>& queries, const DescriptorIndex& index,
                                  const std::vector<int>& ids, double ratio = 0.8);

 private:
  struct Probe {
    std::int32_t list, query;
  };
  struct Distances {
    Int4 lanes;
  };
  struct Group {  // up to four queries
    int queries[4];
    int count = 0;
  };

  void take(const std::vector<Feature>& queries, bool dark);
  void choose_lists(const DescriptorIndex::Lists& lists);
  void search_lists(const DescriptorIndex::Lists& lists);
  void compare(const Group& group, const DescriptorIndex::List& list);
  bool is_left_out(int id) const;
  void clear_chosen();
  void choose(int id, const Descriptor& descriptor);
  void compare_all_with_chosen();
  const std::vector<Match>& mutual(const std::vector<Feature>& queries, const DescriptorIndex& index,
                                   double ratio);

  SearchSettings settings_;
  DistanceFunction distances_;
  std::vector<int> query_index_;  // of the sign at work, into the caller's queries
  std::vector<WideDescriptor> wide_;
  std::vector<Distances> centre_distances_;
  std::vector<Probe> probes_, probes_by_list_;
  std::vector<std::int32_t> list_begin_;
  DescriptorIndex::List chosen_;  // those that all queries are compared with
  std::vector<bool> left_out_;    // by id
  std::vector<Neighbours> neighbours_;
  std::vector<Match> matches_;
};

}  // namespace lcmslam
