#include <lcmslam/features/descriptor_search.hpp>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

namespace lcmslam {
namespace {

constexpr int tile = 128;  // descriptors compared at a time

void offer(Neighbours& neighbours, const Neighbour& candidate) {
  const auto before = [](const Neighbour& a, const Neighbour& b) {
    return a.distance2 < b.distance2 || (a.distance2 == b.distance2 && a.id < b.id);
  };
  std::size_t i = neighbours.size();
  while (i > 0 && before(candidate, neighbours[i - 1])) --i;
  if (i == neighbours.size() || (i > 0 && neighbours[i - 1].id == candidate.id)) return;
  std::copy_backward(neighbours.begin() + static_cast<std::ptrdiff_t>(i), neighbours.end() - 1,
                     neighbours.end());
  neighbours[i] = candidate;
}

void fetch(const void* begin, std::size_t bytes) {
#ifdef __GNUC__
  for (std::size_t i = 0; i < bytes; i += 64) __builtin_prefetch(static_cast<const char*>(begin) + i);
#else
  static_cast<void>(begin);
  static_cast<void>(bytes);
#endif
}

}  // namespace

DescriptorSearch::DescriptorSearch(const SearchSettings& settings, InstructionSet set)
    : settings_(settings), distances_(distance_function(set)) {
  if (!(settings.share > 0 && settings.share <= 1))
    throw std::invalid_argument("descriptor search: share is " + std::to_string(settings.share) +
                                ", must be in (0, 1]");
  if (settings.at_least < 1)
    throw std::invalid_argument("descriptor search: at_least is " + std::to_string(settings.at_least) +
                                ", must be 1 or more");
}

void DescriptorSearch::take(const std::vector<Feature>& queries, bool dark) {
  query_index_.clear();
  wide_.clear();
  for (std::size_t i = 0; i < queries.size(); ++i) {
    if ((queries[i].laplacian >= 0) != dark) continue;
    query_index_.push_back(static_cast<int>(i));
    wide_.emplace_back().assign(queries[i].descriptor);
  }
}

// For each query its nearest lists, until they hold enough. Sorting them would take longer than
// comparing their members: a histogram of the distances tells up to where to go (to the end of the
// bucket, so sometimes a list more than needed).
void DescriptorSearch::choose_lists(const DescriptorIndex::Lists& lists) {
  const std::size_t count = lists.lists.size();
  const int enough = std::max(settings_.at_least, static_cast<int>(std::ceil(settings_.share * lists.size)));
  probes_.clear();
  centre_distances_.resize(count);
  for (std::size_t first = 0; first < wide_.size(); first += 4) {
    const std::size_t lanes = std::min<std::size_t>(4, wide_.size() - first);
    const WideDescriptor* group[4];
    for (std::size_t lane = 0; lane < 4; ++lane) group[lane] = &wide_[first + std::min(lane, lanes - 1)];
    distances_(group, lists.centres.data(), lists.centre_norms2.data(), static_cast<int>(count),
               &centre_distances_[0].lanes);
    Int4 least = centre_distances_[0].lanes, most = least;
    for (std::size_t l = 0; l < count; ++l) {
      const Int4 d = centre_distances_[l].lanes;
      least = d < least ? d : least;
      most = d > most ? d : most;
    }
    for (std::size_t lane = 0; lane < lanes; ++lane) {
      constexpr int buckets = 256;
      int held[buckets] = {};
      int shift = 0;
      while ((most[lane] - least[lane]) >> shift >= buckets) ++shift;
      for (std::size_t l = 0; l < count; ++l)
        held[(centre_distances_[l].lanes[lane] - least[lane]) >> shift] +=
            static_cast<int>(lists.lists[l].ids.size());
      int bucket = 0;
      for (int total = held[0]; total < enough && bucket + 1 < buckets;) total += held[++bucket];
      const int limit = least[lane] + ((bucket + 1) << shift);
      for (std::size_t l = 0; l < count; ++l)
        if (centre_distances_[l].lanes[lane] < limit)
          probes_.push_back({static_cast<std::int32_t>(l), static_cast<std::int32_t>(first + lane)});
    }
  }
}

// List by list, so that each is fetched once for all that ask for it.
void DescriptorSearch::search_lists(const DescriptorIndex::Lists& lists) {
  list_begin_.assign(lists.lists.size() + 1, 0);
  for (const Probe& probe : probes_) ++list_begin_[static_cast<std::size_t>(probe.list) + 1];
  for (std::size_t l = 1; l < list_begin_.size(); ++l) list_begin_[l] += list_begin_[l - 1];
  probes_by_list_.resize(probes_.size());
  for (const Probe& probe : probes_) {
    std::int32_t& next = list_begin_[static_cast<std::size_t>(probe.list)];
    probes_by_list_[static_cast<std::size_t>(next++)] = probe;
  }
  for (std::size_t first = 0; first < probes_by_list_.size();) {
    const std::int32_t list = probes_by_list_[first].list;
    Group group;
    for (; first < probes_by_list_.size() && probes_by_list_[first].list == list && group.count < 4; ++first)
      group.queries[group.count++] = probes_by_list_[first].query;
    if (first < probes_by_list_.size()) {  // the next one is on its way meanwhile
      const DescriptorIndex::List& next = lists.lists[static_cast<std::size_t>(probes_by_list_[first].list)];
      fetch(next.descriptors.data(), next.descriptors.size() * sizeof(Descriptor));
      fetch(next.norms2.data(), next.norms2.size() * sizeof(std::int32_t));
      fetch(next.ids.data(), next.ids.size() * sizeof(int));
    }
    compare(group, lists.lists[static_cast<std::size_t>(list)]);
  }
}

void DescriptorSearch::compare(const Group& group, const DescriptorIndex::List& list) {
  const WideDescriptor* wide[4];
  Neighbours* found[4];
  Int4 worst;  // what does not beat it need not be offered
  for (int lane = 0; lane < 4; ++lane) {
    const auto query = static_cast<std::size_t>(group.queries[std::min(lane, group.count - 1)]);
    wide[lane] = &wide_[query];
    found[lane] = &neighbours_[static_cast<std::size_t>(query_index_[query])];
    worst[lane] = lane < group.count ? found[lane]->back().distance2 : -1;
  }
  Int4 distances[tile];
  for (std::size_t first = 0; first < list.ids.size(); first += tile) {
    const std::size_t count = std::min<std::size_t>(tile, list.ids.size() - first);
    distances_(wide, list.descriptors.data() + first, list.norms2.data() + first, static_cast<int>(count),
               distances);
    for (std::size_t t = 0; t < count; ++t) {
      if (!any(distances[t] <= worst)) continue;
      for (int lane = 0; lane < group.count; ++lane) {
        if (distances[t][lane] > worst[lane] || is_left_out(list.ids[first + t])) continue;
        offer(*found[lane], {list.ids[first + t], distances[t][lane]});
        worst[lane] = found[lane]->back().distance2;
      }
    }
  }
}

bool DescriptorSearch::is_left_out(int id) const {
  const auto i = static_cast<std::size_t>(id);
  return i < left_out_.size() && left_out_[i];
}

const std::vector<Neighbours>& DescriptorSearch::nearest_without(const std::vector<bool>& left_out,
                                                                 const std::vector<Feature>& queries,
                                                                 const DescriptorIndex& index) {
  left_out_ = left_out;
  nearest(queries, index);
  left_out_.clear();
  return neighbours_;
}

const std::vector<Neighbours>& DescriptorSearch::nearest(const std::vector<Feature>& queries,
                                                         const DescriptorIndex& index) {
  neighbours_.assign(queries.size(), {});
  for (const bool dark : {false, true}) {
    const DescriptorIndex::Lists& lists = index.lists(dark);
    if (lists.size == 0) continue;
    take(queries, dark);
    choose_lists(lists);
    search_lists(lists);
  }
  return neighbours_;
}

const std::vector<Neighbours>& DescriptorSearch::nearest(const std::vector<Feature>& queries,
                                                         const DescriptorIndex& index,
                                                         const std::vector<int>& ids) {
  neighbours_.assign(queries.size(), {});
  for (const bool dark : {false, true}) {
    clear_chosen();
    for (const int id : ids)
      if (index.is_dark(id) == dark) choose(id, index.descriptor(id));
    take(queries, dark);
    compare_all_with_chosen();
  }
  return neighbours_;
}

const std::vector<Match>& DescriptorSearch::match(const std::vector<Feature>& queries,
                                                  const DescriptorIndex& index, double ratio) {
  check_ratio(ratio);
  nearest(queries, index);
  return mutual(queries, index, ratio);
}

const std::vector<Match>& DescriptorSearch::match(const std::vector<Feature>& queries,
                                                  const DescriptorIndex& index, const std::vector<int>& ids,
                                                  double ratio) {
  check_ratio(ratio);
  nearest(queries, index, ids);
  return mutual(queries, index, ratio);
}

// Whoever passed the ratio test is compared the other way round: its landmark with all queries. Of
// equally near queries the first counts.
const std::vector<Match>& DescriptorSearch::mutual(const std::vector<Feature>& queries,
                                                   const DescriptorIndex& index, double ratio) {
  matches_.clear();
  for (std::size_t q = 0; q < queries.size(); ++q) {
    const Neighbours& n = neighbours_[q];
    if (n[0].id < 0 || (n[1].id >= 0 && !passes_ratio(n[0].distance2, n[1].distance2, ratio))) continue;
    matches_.push_back({static_cast<int>(q), n[0].id, n[0].distance2});
  }
  neighbours_.assign(matches_.size(), {});
  for (const bool dark : {false, true}) {
    clear_chosen();
    for (std::size_t q = 0; q < queries.size(); ++q)
      if ((queries[q].laplacian >= 0) == dark) choose(static_cast<int>(q), queries[q].descriptor);
    query_index_.clear();
    wide_.clear();
    for (std::size_t m = 0; m < matches_.size(); ++m) {
      if (index.is_dark(matches_[m].b) != dark) continue;
      query_index_.push_back(static_cast<int>(m));
      wide_.emplace_back().assign(index.descriptor(matches_[m].b));
    }
    compare_all_with_chosen();
  }
  std::size_t kept = 0;
  for (std::size_t m = 0; m < matches_.size(); ++m)
    if (neighbours_[m][0].id == matches_[m].a) matches_[kept++] = matches_[m];
  matches_.resize(kept);
  return matches_;
}

void DescriptorSearch::clear_chosen() {
  chosen_.descriptors.clear();
  chosen_.norms2.clear();
  chosen_.ids.clear();
}

void DescriptorSearch::choose(int id, const Descriptor& descriptor) {
  chosen_.descriptors.push_back(descriptor);
  chosen_.norms2.push_back(squared_norm(descriptor));
  chosen_.ids.push_back(id);
}

void DescriptorSearch::compare_all_with_chosen() {
  for (std::size_t first = 0; first < wide_.size(); first += 4) {
    Group group;
    for (std::size_t q = first; q < std::min(first + 4, wide_.size()); ++q)
      group.queries[group.count++] = static_cast<int>(q);
    compare(group, chosen_);
  }
}

}  // namespace lcmslam
