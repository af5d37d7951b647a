#include <lcmslam/live_map/live_space.hpp>

#include <algorithm>

namespace lcmslam {
namespace {

/// Of the field of view's corners beyond the largest depth.
constexpr double corners = 1.3;

}  // namespace

LiveSpace::LiveSpace(const LiveMapSettings& settings)
    : cell_size_(settings.occupancy.cell_size),
      background_(settings.background),
      distance_every_(settings.distance_every),
      distance_rest_(settings.distance_rest),
      distance_(settings.distance),
      keyframes_(settings.occupancy),
      moved_(settings.moved_distance, settings.moved_angle),
      grid_(settings.occupancy),
      near_(settings.occupancy.cell_size, settings.distance, corners * settings.occupancy.max_range),
      newest_(settings.occupancy.cell_size) {}

void LiveSpace::begin_frame() {
  take_over(false);
  moved_.frame();
  if (!carving_.valid() && moved_.due()) carve_anew();
}

void LiveSpace::show(const cv::Mat& depth, const CameraModel& camera, const Eigen::Isometry3d& T_map_depth,
                     const std::optional<Place>& hangs_on) {
  begin_frame();
  std::vector<OccupancyChange> hits;
  bool is_asked = false;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    carver_.carve(depth, camera, T_map_depth, grid_);
    grid_.make_room(T_map_depth.translation().cast<float>());
    hits_ = hits = carver_.hits();
    place_ = T_map_depth.translation();
    if (++unmeasured_ >= distance_every_ && awake_) measure();
    if (++unasked_ > distance_rest_) awake_ = false;
    is_asked = awake_;
  }
  if (hangs_on) hang(hits, *hangs_on);
  if (is_asked) follow(T_map_depth.translation());
}

void LiveSpace::glance(const cv::Mat& depth, const CameraModel& camera,
                       const Eigen::Isometry3d& T_map_depth) {
  begin_frame();
  const std::lock_guard<std::mutex> lock(mutex_);
  carver_.see(depth, camera, T_map_depth, grid_);
  hits_ = carver_.hits();
  place_ = T_map_depth.translation();
}

void LiveSpace::show_before(const cv::Mat& depth, const CameraModel& camera,
                            const Eigen::Isometry3d& T_map_depth) {
  begin_frame();
  const std::lock_guard<std::mutex> lock(mutex_);
  carver_.carve(depth, camera, T_map_depth, grid_);
  grid_.make_room(place_.cast<float>());
  if (++unmeasured_ >= distance_every_ && awake_) measure();
}

/// What a frame hit moves with a keyframe.
void LiveSpace::hang(const std::vector<OccupancyChange>& hits, const Place& on) {
  keyframes_.follow(on.keyframe, on.T_map_depth, hits, grid_);
  kept_bytes_ = keyframes_.memory_bytes();
  if (!carving_.valid()) return;
  meanwhile_.emplace_back([hits, on](Carved& carved) {
    carved.keyframes.follow(on.keyframe, on.T_map_depth, hits, carved.grid);
    hit(hits, carved.grid);
  });
}

void LiveSpace::keep(int keyframe, const cv::Mat& depth, const CameraModel& camera,
                     const Eigen::Isometry3d& T_map_depth) {
  keyframes_.add(keyframe, depth, camera, T_map_depth);
  kept_bytes_ = keyframes_.memory_bytes();
  moved_.add(keyframe, T_map_depth);
  if (carving_.valid())
    meanwhile_.emplace_back([=, depth = depth.clone()](Carved& carved) {
      carved.keyframes.add(keyframe, depth, camera, T_map_depth);
      carver_.carve(depth, camera, T_map_depth, carved.grid);
    });
  const std::lock_guard<std::mutex> lock(mutex_);
  if (awake_) measure();
}

/// Distances follow what has changed.
void LiveSpace::measure() const {
  near_.update(grid_.take_changes());
  unmeasured_ = 0;
}

/// Somebody asks: what has changed while nobody did is made up for.
void LiveSpace::bring_up_to_date() const {
  if (hits_) newest_.show(*std::exchange(hits_, std::nullopt));
  unasked_ = 0;
  if (std::exchange(awake_, true)) return;
  measure();
  if (std::optional<NearDistances> moved = near_.moved(place_, grid_)) near_ = std::move(*moved);
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
  const auto occupied = ask_occupied(
      [&](const OccupancyGrid& grid) { return occupied_around(box, distance_.truncation, grid); });
  return field_of(occupied, cell_size_, distance_);
}

void LiveSpace::correct(const std::map<int, Eigen::Isometry3d>& T_map_depth) {
  moved_.correct(T_map_depth);
  take_over(false);
  if (!carving_.valid() && moved_.due()) carve_anew();
}

void LiveSpace::forget(const std::vector<int>& keyframes) {
  for (const int id : keyframes) {
    keyframes_.forget(id);
    moved_.give_up(id);
    if (carving_.valid()) meanwhile_.emplace_back([id](Carved& carved) { carved.keyframes.forget(id); });
  }
  kept_bytes_ = keyframes_.memory_bytes();
}

void LiveSpace::catch_up() {
  take_over(false);
  if (!carving_.valid() && moved_.moved()) carve_anew();
}

void LiveSpace::settle() {
  take_over(true);
  if (!moved_.moved()) return;
  carve_anew();
  take_over(true);
}

void LiveSpace::carve_anew() {
  carving_ = std::async(background_ ? std::launch::async : std::launch::deferred,
                        [keyframes = keyframes_, grid = copy(), moved = moved_.take(),
                         place = Eigen::Vector3f(place_.cast<float>())]() mutable {
                          OccupancyGrid carved = keyframes.carve_anew(moved, grid, place);
                          return Carved{std::move(keyframes), std::move(carved)};
                        });
  if (!background_) take_over(true);
}

void LiveSpace::take_over(bool wait) {
  if (!carving_.valid()) return;
  if (!wait && carving_.wait_for(std::chrono::seconds(0)) == std::future_status::timeout) return;
  Carved carved = carving_.get();
  for (const auto& change : std::exchange(meanwhile_, {})) change(carved);
  carved.grid.make_room(place_.cast<float>());
  keyframes_ = std::move(carved.keyframes);
  const std::lock_guard<std::mutex> lock(mutex_);
  grid_.adopt(std::move(carved.grid));
  if (awake_) measure();
}

std::size_t LiveSpace::memory_bytes() const {
  const std::unique_lock<std::mutex> lock(mutex_, std::try_to_lock);
  if (lock.owns_lock())
    space_bytes_ = grid_.memory_bytes() + near_.memory_bytes() + newest_.field().memory_bytes();
  return kept_bytes_ + space_bytes_;
}

}  // namespace lcmslam
