#include <lcmslam/map_query/newest_frame.hpp>

namespace lcmslam {

void NewestFrame::show(const std::vector<OccupancyChange>& hits) {
  BlockTable<const OccupancyChange*> before, now;
  for (const OccupancyChange& change : shown_) before.make(change.block) = &change;
  std::vector<OccupancyChange> changes;
  for (const OccupancyChange& hit : hits) {
    now.make(hit.block) = &hit;
    const auto* same = before.find(hit.block);
    if (same == nullptr || (*same)->occupied != hit.occupied) changes.push_back(hit);
  }
  for (const OccupancyChange& change : shown_)
    if (now.find(change.block) == nullptr) changes.push_back({change.block, {}});
  field_.update(changes);
  shown_ = hits;
}

}  // namespace lcmslam
