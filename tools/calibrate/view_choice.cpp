#include "tools/calibrate/view_choice.hpp"

#include <algorithm>

namespace lcmslam {

double ViewChoice::distance(const BoardView& a, const BoardView& b) {
  double sum = 0;
  int common = 0;
  for (std::size_t i = 0; i < a.ids.size(); ++i) {
    const auto other = std::find(b.ids.begin(), b.ids.end(), a.ids[i]);
    if (other == b.ids.end()) continue;
    sum += (a.pixels[i] - b.pixels[static_cast<std::size_t>(other - b.ids.begin())]).norm();
    ++common;
  }
  return common > 0 ? sum / common : 1e9;
}

bool ViewChoice::takes(const BoardView& view, int image_width) {
  if (!sequence_) return true;
  constexpr double still = 0.006, elsewhere = 0.05;  // of the image's width
  const bool is_still = distance(view, previous_) < still * image_width;
  previous_ = view;
  const bool is_new = std::none_of(taken_.begin(), taken_.end(), [&](const BoardView& other) {
    return distance(view, other) < elsewhere * image_width;
  });
  if (!is_still || !is_new) return false;
  taken_.push_back(view);
  return true;
}

}  // namespace lcmslam
