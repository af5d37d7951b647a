#include "surf/matching.hpp"

#include <algorithm>
#include <limits>
#include <stdexcept>
#include <string>

namespace lcmslam {
namespace {

constexpr int none = std::numeric_limits<int>::max();

// Descriptors of one Laplacian sign, as 16-bit numbers: |a - b|^2 = |a|^2 + |b|^2 - 2 a.b then needs
// one multiply-add instruction for eight components.
struct Group {
  std::vector<int> index;            // into the caller's set
  std::vector<std::int16_t> values;  // 64 each, bytes less 128
  std::vector<std::int32_t> norm2;

  void add(int i, const Descriptor& descriptor) {
    index.push_back(i);
    std::int32_t sum = 0;
    for (std::uint8_t byte : descriptor) {
      const int value = byte - 128;
      values.push_back(static_cast<std::int16_t>(value));
      sum += value * value;
    }
    norm2.push_back(sum);
  }
};

std::int32_t dot(const std::int16_t* a, const std::int16_t* b) {
  std::int32_t sum = 0;
  for (int k = 0; k < 64; ++k) sum += a[k] * b[k];
  return sum;
}

void match_group(const Group& a, const Group& b, double ratio, std::vector<Match>& matches) {
  const std::size_t count_a = a.index.size(), count_b = b.index.size();
  std::vector<int> row(count_b), best_of_b(count_b, none), nearest_to_b(count_b, -1);
  std::vector<int> best_of_a(count_a, none), second_of_a(count_a, none), nearest_to_a(count_a, -1);
  for (std::size_t i = 0; i < count_a; ++i) {
    for (std::size_t j = 0; j < count_b; ++j)
      row[j] = a.norm2[i] + b.norm2[j] - 2 * dot(a.values.data() + 64 * i, b.values.data() + 64 * j);
    for (std::size_t j = 0; j < count_b; ++j) {
      if (row[j] < best_of_a[i]) {
        second_of_a[i] = best_of_a[i];
        best_of_a[i] = row[j];
        nearest_to_a[i] = static_cast<int>(j);
      } else if (row[j] < second_of_a[i]) {
        second_of_a[i] = row[j];
      }
      if (row[j] < best_of_b[j]) {
        best_of_b[j] = row[j];
        nearest_to_b[j] = static_cast<int>(i);
      }
    }
  }
  for (std::size_t i = 0; i < count_a; ++i) {
    if (nearest_to_a[i] < 0) continue;
    const auto j = static_cast<std::size_t>(nearest_to_a[i]);
    if (nearest_to_b[j] != static_cast<int>(i)) continue;
    // Distances are compared, so the ratio of the squares is the square of the ratio.
    if (ratio < 1 && second_of_a[i] != none && !(best_of_a[i] < ratio * ratio * second_of_a[i])) continue;
    matches.push_back({a.index[i], b.index[j], best_of_a[i]});
  }
}

void check(double ratio) {
  if (!(ratio > 0 && ratio <= 1))
    throw std::invalid_argument("matching: ratio is " + std::to_string(ratio) + ", must be in (0, 1]");
}

Group group_of(const std::vector<Feature>& features, int sign, bool any_sign) {
  Group group;
  for (std::size_t i = 0; i < features.size(); ++i)
    if (any_sign || (features[i].laplacian < 0 ? -1 : 1) == sign)
      group.add(static_cast<int>(i), features[i].descriptor);
  return group;
}

Group group_of(const std::vector<Descriptor>& descriptors) {
  Group group;
  for (std::size_t i = 0; i < descriptors.size(); ++i) group.add(static_cast<int>(i), descriptors[i]);
  return group;
}

}  // namespace

std::vector<Match> match(const std::vector<Feature>& a, const std::vector<Feature>& b,
                         const MatchingSettings& settings) {
  check(settings.ratio);
  std::vector<Match> matches;
  if (settings.same_laplacian) {
    for (int sign : {-1, 1})
      match_group(group_of(a, sign, false), group_of(b, sign, false), settings.ratio, matches);
  } else {
    match_group(group_of(a, 0, true), group_of(b, 0, true), settings.ratio, matches);
  }
  std::sort(matches.begin(), matches.end(), [](const Match& x, const Match& y) { return x.a < y.a; });
  return matches;
}

std::vector<Match> match(const std::vector<Descriptor>& a, const std::vector<Descriptor>& b, double ratio) {
  check(ratio);
  std::vector<Match> matches;
  match_group(group_of(a), group_of(b), ratio, matches);
  return matches;
}

int squared_distance(const Descriptor& a, const Descriptor& b) {
  int sum = 0;
  for (std::size_t k = 0; k < a.size(); ++k) {
    const int difference = static_cast<int>(a[k]) - static_cast<int>(b[k]);
    sum += difference * difference;
  }
  return sum;
}

}  // namespace lcmslam
