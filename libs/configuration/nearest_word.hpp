#pragma once
// What somebody may have meant who typed a word that there is not.

#include <string>
#include <vector>

namespace lcmslam {

/// The candidate with the smallest edit distance (insertions, deletions, replacements and swaps of
/// neighbours) of at most `farthest`; the first of equals, empty when there is none. Those that begin with a
/// word of four letters, or else hold it, go before all that are more than one edit away.
std::string nearest_word(const std::string& word, const std::vector<std::string>& candidates,
                         std::size_t farthest = std::string::npos);

/// " (did you mean 'WORD'?)", capitals or not; empty when no candidate is near.
std::string did_you_mean(const std::string& word, const std::vector<std::string>& candidates);

}  // namespace lcmslam
