#include <lcmslam/features/matching.hpp>

#include <algorithm>
#include <limits>
#include <stdexcept>
#include <string>

namespace lcmslam {
namespace {

constexpr int none = std::numeric_limits<int>::max();
constexpr int tile = 128;  // targets that stay in the first-level cache while all queries pass

Int4 four(int value) {
  return Int4{value, value, value, value};
}

}  // namespace

void Matcher::clear() {
  a_.index.clear();
  a_.wide.clear();
  b_.index.clear();
  b_.bytes.clear();
  b_.norms2.clear();
}

void Matcher::add_a(int index, const Descriptor& descriptor) {
  a_.index.push_back(index);
  a_.wide.emplace_back().assign(descriptor);
}

void Matcher::add_b(int index, const Descriptor& descriptor) {
  b_.index.push_back(index);
  b_.bytes.push_back(descriptor);
  b_.norms2.push_back(squared_norm(descriptor));
}

// Every distance once: it serves its row (four queries of a) and its column (target of b).
void Matcher::fill_tables() {
  const std::size_t queries = a_.wide.size(), groups = (queries + 3) / 4, targets = b_.bytes.size();
  rows_.assign(groups, {four(none), four(none), four(-1)});
  columns_.assign(targets, {four(none), four(0)});
  Int4 distances[tile];
  for (std::size_t first = 0; first < targets; first += tile) {
    const std::size_t count = std::min<std::size_t>(tile, targets - first);
    for (std::size_t g = 0; g < groups; ++g) {
      // The last query stands in for those missing in the last group: never before itself.
      const WideDescriptor* group[4];
      for (std::size_t lane = 0; lane < 4; ++lane)
        group[lane] = &a_.wide[std::min(4 * g + lane, queries - 1)];
      distances_(group, b_.bytes.data() + first, b_.norms2.data() + first, static_cast<int>(count),
                 distances);
      Row row = rows_[g];
      for (std::size_t t = 0; t < count; ++t) {
        const Int4 d = distances[t];
        const Int4 nearer = d < row.nearest;
        const Int4 loser = nearer ? row.nearest : d;
        row.second = loser < row.second ? loser : row.second;
        row.nearest = nearer ? d : row.nearest;
        row.target = nearer ? four(static_cast<int>(first + t)) : row.target;
        Column& column = columns_[first + t];
        const Int4 nearer_query = d < column.nearest;
        column.nearest = nearer_query ? d : column.nearest;
        column.group = nearer_query ? four(static_cast<int>(g)) : column.group;
      }
      rows_[g] = row;
    }
  }
}

// Of equally near queries the first.
int Matcher::nearest_query(const Column& column) const {
  int distance = none, query = none;
  for (int lane = 0; lane < 4; ++lane) {
    const int candidate = 4 * column.group[lane] + lane;
    if (column.nearest[lane] < distance || (column.nearest[lane] == distance && candidate < query)) {
      distance = column.nearest[lane];
      query = candidate;
    }
  }
  return query;
}

void Matcher::match_sets(double ratio) {
  if (a_.index.empty() || b_.index.empty()) return;
  fill_tables();
  for (std::size_t i = 0; i < a_.index.size(); ++i) {
    const Row& row = rows_[i / 4];
    const auto lane = i % 4;
    const auto j = static_cast<std::size_t>(row.target[lane]);
    if (nearest_query(columns_[j]) != static_cast<int>(i)) continue;
    if (row.second[lane] != none && !passes_ratio(row.nearest[lane], row.second[lane], ratio)) continue;
    matches_.push_back({a_.index[i], b_.index[j], row.nearest[lane]});
  }
}

const std::vector<Match>& Matcher::match(const std::vector<Feature>& a, const std::vector<Feature>& b,
                                         const MatchingSettings& settings) {
  check_ratio(settings.ratio);
  matches_.clear();
  for (const bool dark : {false, true}) {
    const auto admitted = [&](const Feature& f) {
      return !settings.same_laplacian || (f.laplacian >= 0) == dark;
    };
    clear();
    for (std::size_t i = 0; i < a.size(); ++i)
      if (admitted(a[i])) add_a(static_cast<int>(i), a[i].descriptor);
    for (std::size_t j = 0; j < b.size(); ++j)
      if (admitted(b[j])) add_b(static_cast<int>(j), b[j].descriptor);
    match_sets(settings.ratio);
    if (!settings.same_laplacian) break;
  }
  std::sort(matches_.begin(), matches_.end(), [](const Match& x, const Match& y) { return x.a < y.a; });
  return matches_;
}

const std::vector<Match>& Matcher::match(const std::vector<Descriptor>& a, const std::vector<Descriptor>& b,
                                         double ratio) {
  check_ratio(ratio);
  matches_.clear();
  clear();
  for (std::size_t i = 0; i < a.size(); ++i) add_a(static_cast<int>(i), a[i]);
  for (std::size_t j = 0; j < b.size(); ++j) add_b(static_cast<int>(j), b[j]);
  match_sets(ratio);
  return matches_;
}

std::vector<Match> match(const std::vector<Feature>& a, const std::vector<Feature>& b,
                         const MatchingSettings& settings) {
  return Matcher().match(a, b, settings);
}

std::vector<Match> match(const std::vector<Descriptor>& a, const std::vector<Descriptor>& b, double ratio) {
  return Matcher().match(a, b, ratio);
}

int squared_distance(const Descriptor& a, const Descriptor& b) {
  int sum = 0;
  for (std::size_t k = 0; k < a.size(); ++k) {
    const int difference = static_cast<int>(a[k]) - static_cast<int>(b[k]);
    sum += difference * difference;
  }
  return sum;
}

void check_ratio(double ratio) {
  if (!(ratio > 0 && ratio <= 1))
    throw std::invalid_argument("matching: ratio is " + std::to_string(ratio) + ", must be in (0, 1]");
}

}  // namespace lcmslam
