#include <lcmslam/live_map/live_space.hpp>

namespace lcmslam {
namespace {

/// Of the field of view's corners beyond the largest depth.
constexpr double corners = 1.3;

}  // namespace

LiveSpace::LiveSpace(const CameraModel& depth_camera, const LiveMapSettings& settings)
    : camera_(depth_camera),
      cell_size_(settings.occupancy.cell_size),
      background_(settings.background),
      distance_every_(settings.distance_every),
      distance_(settings.distance),
      keyframes_(settings.occupancy),
      moved_(settings.moved_distance, settings.moved_angle),
      grid_(settings.occupancy),
      near_(settings.occupancy.cell_size, settings.distance, corners * settings.occupancy.max_range),
      newest_(settings.occupancy.cell_size) {}

void LiveSpace::show(const cv::Mat& depth, const Eigen::Isometry3d& T_map_depth) {
  take_over(false);
  moved_.frame();
  if (!carving_.valid() && moved_.due()) carve_anew();
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    carver_.carve(depth, camera_, T_map_depth, grid_);
    grid_.make_room(T_map_depth.translation().cast<float>());
    newest_.show(carver_.hits());
    if (++unmeasured_ >= distance_every_) measure();
  }
  follow(T_map_depth.translation());
}

void LiveSpace::keep(int keyframe, const cv::Mat& depth, const Eigen::Isometry3d& T_map_depth) {
  keyframes_.add(keyframe, depth, camera_, T_map_depth);
  kept_bytes_ = keyframes_.memory_bytes();
  moved_.add(keyframe, T_map_depth);
  if (carving_.valid()) meanwhile_.push_back({keyframe, depth.clone(), T_map_depth});
  const std::lock_guard<std::mutex> lock(mutex_);
  measure();
}

/// Distances follow what has changed.
void LiveSpace::measure() {
  near_.update(grid_.take_changes());
  unmeasured_ = 0;
}

/// The robot may come to where distances are not kept. Only this thread changes the grid, so it can be read
/// while others ask.
void LiveSpace::follow(const Eigen::Vector3d& place) {
  std::optional<NearDistances> moved = near_.moved(place, grid_);
  if (!moved) return;
  const std::lock_guard<std::mutex> lock(mutex_);
  near_ = std::move(*moved);
}

DistanceField LiveSpace::distances_in(const Eigen::AlignedBox3d& box) const {
  const auto occupied =
      ask([&](const View& view) { return occupied_around(box, distance_.truncation, view.occupied); });
  return field_of(occupied, cell_size_, distance_);
}

void LiveSpace::correct(const std::map<int, Eigen::Isometry3d>& T_map_depth) {
  moved_.correct(T_map_depth);
  take_over(false);
  if (!carving_.valid() && moved_.due()) carve_anew();
}

void LiveSpace::settle() {
  take_over(true);
  if (!moved_.moved()) return;
  carve_anew();
  take_over(true);
}

void LiveSpace::carve_anew() {
  carving_ = std::async(background_ ? std::launch::async : std::launch::deferred,
                        [keyframes = keyframes_, grid = copy(), moved = moved_.take()]() mutable {
                          OccupancyGrid carved = keyframes.carve_anew(moved, grid);
                          return Carved{std::move(keyframes), std::move(carved)};
                        });
  if (!background_) take_over(true);
}

void LiveSpace::take_over(bool wait) {
  if (!carving_.valid()) return;
  if (!wait && carving_.wait_for(std::chrono::seconds(0)) == std::future_status::timeout) return;
  Carved carved = carving_.get();
  keyframes_ = std::move(carved.keyframes);
  for (const Kept& kept : meanwhile_) {
    keyframes_.add(kept.keyframe, kept.depth, camera_, kept.T_map_depth);
    carver_.carve(kept.depth, camera_, kept.T_map_depth, carved.grid);
  }
  meanwhile_.clear();
  const std::lock_guard<std::mutex> lock(mutex_);
  grid_.adopt(std::move(carved.grid));
  measure();
}

std::size_t LiveSpace::memory_bytes() const {
  return ask([this](const View& view) {
    return kept_bytes_ + view.occupied.memory_bytes() + view.distances.memory_bytes() +
           view.newest.memory_bytes();
  });
}

}  // namespace lcmslam
