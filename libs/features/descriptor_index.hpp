#pragma once
// Descriptors of a growing map, kept so that a few of them need to be compared with a query: inverted
// lists (Sivic & Zisserman 2003; Jegou, Douze & Schmid 2011, without the compression) that grow with the
// map. A list that is full is split in two by 2-means, as a B-tree splits a node: each insertion costs at
// most one pass over the lists' centres and one split, so the map never stands still to be indexed
// anew. DescriptorSearch does the asking.
//
// FLANN's randomised trees are rebuilt when they have doubled (25 ms at 20,000 descriptors) and are some
// twenty times slower at the same share of right answers (bench_matching): on 64 bytes, reading what lies
// together beats following pointers. They serve for vectors of floats, for other norms, and for sets that
// are complete before they are asked.
//
// The same calls in the same order give the same index: no clock, no thread, no random number. What one
// index holds can be shared by many (the particles of a filter): it knows ids, no places.

#include <cstddef>
#include <cstdint>
#include <vector>

#include <lcmslam/features/descriptor_distance.hpp>

namespace lcmslam {

class DescriptorIndex {
 public:
  static constexpr int list_capacity = 64;  ///< larger lists: fewer centres, coarser choice

  /// Descriptors near one centre, in no order that matters.
  struct List {
    std::vector<Descriptor> descriptors;
    std::vector<std::int32_t> norms2;
    std::vector<int> ids;
  };

  /// The lists of one Laplacian sign. A centre is the mean of its list when it was split off.
  struct Lists {
    std::vector<Descriptor> centres;
    std::vector<std::int32_t> centre_norms2;
    std::vector<List> lists;
    int size = 0;  ///< descriptors in all lists
  };

  /// Ids are the caller's, 0 to 2^24 - 1; memory grows with the largest (slots that are used again, not
  /// ever new numbers). Only the sign of `laplacian` counts. Throws std::invalid_argument when the id is
  /// out of range or taken.
  void insert(int id, const Descriptor& descriptor, int laplacian);

  /// Replaces the descriptor; the sign stays. Throws std::invalid_argument when there is no such id.
  void update(int id, const Descriptor& descriptor);

  /// Throws std::invalid_argument when there is no such id.
  void remove(int id);

  bool contains(int id) const;
  int size() const { return by_sign_[0].size + by_sign_[1].size; }

  /// Throw std::invalid_argument when there is no such id.
  const Descriptor& descriptor(int id) const;
  bool is_dark(int id) const;  ///< Laplacian 0 or above

  const Lists& lists(bool dark) const { return by_sign_[dark ? 1 : 0]; }

  /// Of all that is held, with what is reserved for growth.
  std::size_t memory_bytes() const;

 private:
  struct Place {
    std::int32_t list = -1;  // -1: no such id
    std::int16_t position = 0;
    std::int16_t sign = 0;
  };

  const Place& place(int id) const;
  void insert_into(Lists& lists, int sign, int id, const Descriptor& descriptor);
  std::size_t nearest_centre(const Lists& lists, const Descriptor& descriptor);
  void append(Lists& lists, int sign, std::size_t list, int id, const Descriptor& descriptor);
  void split(Lists& lists, int sign, std::size_t list);
  void dissolve(Lists& lists, int sign, std::size_t list);
  void renumber(const Lists& lists, int sign, std::size_t list);

  Lists by_sign_[2];           // bright, dark
  std::vector<Place> places_;  // by id
  DistanceFunction distances_ = distance_function();
  LoneDistanceFunction lone_distances_ = lone_distance_function();
};

}  // namespace lcmslam
