#include <lcmslam/configuration/nearest_word.hpp>

#include <algorithm>
#include <cctype>
#include <utility>

namespace lcmslam {
namespace {

/// Optimal string alignment distance.
std::size_t edit_distance(const std::string& a, const std::string& b) {
  std::vector<std::vector<std::size_t>> d(a.size() + 1, std::vector<std::size_t>(b.size() + 1));
  for (std::size_t i = 0; i <= a.size(); ++i) d[i][0] = i;
  for (std::size_t j = 0; j <= b.size(); ++j) d[0][j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i)
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t replace = d[i - 1][j - 1] + (a[i - 1] == b[j - 1] ? 0 : 1);
      d[i][j] = std::min({d[i - 1][j] + 1, d[i][j - 1] + 1, replace});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
        d[i][j] = std::min(d[i][j], d[i - 2][j - 2] + 1);
    }
  return d[a.size()][b.size()];
}

/// What is meant before what: a slip of the finger, then a word that was begun or of which the middle was
/// remembered, then what looks alike.
enum class Likeness { slip, begun, part, similar };

Likeness likeness(const std::string& word, const std::string& candidate, std::size_t distance) {
  constexpr std::size_t shortest = 4;  // letters: fewer stand in many words
  if (distance <= 1) return Likeness::slip;
  const std::size_t at = word.size() < shortest ? std::string::npos : candidate.find(word);
  return at == 0 ? Likeness::begun : at != std::string::npos ? Likeness::part : Likeness::similar;
}

}  // namespace

std::string nearest_word(const std::string& word, const std::vector<std::string>& candidates,
                         std::size_t farthest) {
  const std::string key = word.substr(0, 200);  // quadratic: a key of a megabyte must not stall us
  std::string best;
  std::pair<Likeness, std::size_t> best_rank;
  for (const std::string& candidate : candidates) {
    const std::size_t distance = edit_distance(key, candidate);
    const std::pair rank{likeness(key, candidate, distance), distance};
    const bool holds_word = rank.first == Likeness::begun || rank.first == Likeness::part;
    if ((distance > farthest && !holds_word) || (!best.empty() && rank >= best_rank)) continue;
    best = candidate;
    best_rank = rank;
  }
  return best;
}

std::string did_you_mean(const std::string& word, const std::vector<std::string>& candidates) {
  const auto in_small = [](std::string text) {
    std::transform(text.begin(), text.end(), text.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    return text;
  };
  std::vector<std::string> small;
  small.reserve(candidates.size());
  for (const std::string& candidate : candidates) small.push_back(in_small(candidate));
  const std::string near = nearest_word(in_small(word), small, std::max<std::size_t>(1, word.size() / 2));
  const auto found = std::find(small.begin(), small.end(), near);
  if (near.empty() || found == small.end()) return "";
  return " (did you mean '" + candidates[static_cast<std::size_t>(found - small.begin())] + "'?)";
}

}  // namespace lcmslam
