#include <lcmslam/live_map/live_map.hpp>

#include <limits>

#include <lcmslam/settings/check.hpp>

namespace lcmslam {
namespace {

constexpr std::size_t most_between =
    10'000;  // that move with their keyframes; older ones stay where they are

LiveMapSettings checked(const LiveMapSettings& settings) {
  check(settings, "live map");
  return settings;
}

}  // namespace

LiveMap::LiveMap(const RgbdCalibration& calibration, const LiveMapSettings& settings)
    : calibration_(calibration),
      settings_(checked(settings)),
      filter_(calibration, settings.depth_filter),
      range_error_(calibration, settings.range_error),
      space_(calibration.depth, settings),
      planes_(calibration, settings),
      surface_(calibration, settings.surface),
      unwatched_(settings.surface_rest + 1) {}

void LiveMap::show(RgbdFrame frame, const FramePose& pose) {
  clean(frame);
  space_.show(frame.depth, pose.T_map_camera * pose.T_colour_depth_time * calibration_.T_colour_depth);
  frame_shown();
  const std::lock_guard<std::mutex> lock(mutex_);
  ++version_;
}

void LiveMap::add(RgbdFrame frame, const FramePose& pose) {
  check_frame(frame, calibration_);
  clean(frame);
  space_.show(frame.depth, pose.T_map_camera * pose.T_colour_depth_time * calibration_.T_colour_depth);
  frame_shown();
  if (last_keyframe_ < 0) return;  // it would stand where it is whatever the graph says
  const std::int64_t id = between_.empty() ? -1 : between_.begin()->first - 1;
  between_[id] = {last_keyframe_, keyframes_.at(last_keyframe_).T_map_camera.inverse() * pose.T_map_camera};
  if (between_.size() > most_between) between_.erase(std::prev(between_.end()));
  fuse(id, frame, pose);
}

void LiveMap::keep(int keyframe, RgbdFrame frame, const FramePose& pose) {
  if (has(keyframe)) return;
  check_frame(frame, calibration_);
  clean(frame);
  const Eigen::Isometry3d T_camera_depth = pose.T_colour_depth_time * calibration_.T_colour_depth;
  const Eigen::Isometry3d T_map_depth = pose.T_map_camera * T_camera_depth;
  space_.show(frame.depth, T_map_depth);
  space_.keep(keyframe, frame.depth, T_map_depth);
  planes_.keep(keyframe, frame.depth, T_map_depth);
  fuse(keyframe, frame, pose);
  kept(keyframe, pose.T_map_camera, T_camera_depth);
}

void LiveMap::adopt(int keyframe, RgbdFrame frame, const FramePose& pose) {
  const int last = last_keyframe_;
  keep(keyframe, std::move(frame), pose);
  last_keyframe_ = last;
  keyframes_.at(keyframe).is_adopted = true;
}

void LiveMap::adopt(int keyframe, const ColouredCloud& cloud, const Eigen::Isometry3d& T_map_camera) {
  const int last = last_keyframe_;
  keep(keyframe, cloud, T_map_camera);
  last_keyframe_ = last;
  keyframes_.at(keyframe).is_adopted = true;
}

void LiveMap::keep(int keyframe, const ColouredCloud& cloud, const Eigen::Isometry3d& T_map_camera) {
  if (has(keyframe)) return;
  const cv::Mat depth = depth_of_cloud(cloud, calibration_.depth);
  space_.show(depth, T_map_camera);
  space_.keep(keyframe, depth, T_map_camera);
  planes_.keep(keyframe, depth, T_map_camera);
  kept(keyframe, T_map_camera, Eigen::Isometry3d::Identity());
}

/// Takes away what no surface gave, and what the camera errs by as far as it is known by now.
void LiveMap::clean(RgbdFrame& frame) {
  filter_(frame.depth, frame.amplitude);
  range_error_.learn(frame.depth, frame.depth_utime);
  range_error_.correct(frame.depth);
}

void LiveMap::fuse(std::int64_t id, const RgbdFrame& frame, const FramePose& pose) {
  const std::lock_guard<std::mutex> lock(surface_mutex_);
  surface_.hand_in(id, frame, pose.T_map_camera, pose.T_colour_depth_time);
}

void LiveMap::kept(int keyframe, const Eigen::Isometry3d& T_map_camera,
                   const Eigen::Isometry3d& T_camera_depth) {
  last_keyframe_ = keyframe;
  const std::lock_guard<std::mutex> lock(mutex_);
  keyframes_[keyframe] = {T_map_camera, T_camera_depth, false};
  ++version_;
}

void LiveMap::correct(const std::map<int, Eigen::Isometry3d>& T_map_camera) {
  std::map<int, Eigen::Isometry3d> T_map_depth;
  for (const auto& [id, T] : T_map_camera)
    if (const auto known = keyframes_.find(id); known != keyframes_.end()) {
      known->second.T_map_camera = T;
      T_map_depth[id] = T * known->second.T_camera_depth;
    }
  space_.correct(T_map_depth);
  planes_.correct(T_map_depth);
  {
    const std::lock_guard<std::mutex> lock(surface_mutex_);
    for (const auto& [id, T] : T_map_camera) surface_.move(id, T);
    for (const auto& [id, between] : between_)
      if (const auto moved = T_map_camera.find(between.keyframe); moved != T_map_camera.end())
        surface_.move(id, moved->second * between.T_keyframe_camera);
  }
  const std::lock_guard<std::mutex> lock(mutex_);
  ++version_;
}

void LiveMap::follow(const std::map<int, Eigen::Isometry3d>& T_map_camera) {
  std::vector<int> gone;
  std::size_t stay = 0;
  for (const auto& [id, keyframe] : keyframes_) {
    if (keyframe.is_adopted) continue;
    if (T_map_camera.count(id) == 0)
      gone.push_back(id);
    else
      ++stay;
  }
  if (!gone.empty() && gone.size() <= stay) forget(gone);
  correct(T_map_camera);
}

/// Some of the map's own stay. The frames that hung on those that go hang on the nearest of these.
void LiveMap::forget(const std::vector<int>& keyframes) {
  space_.forget(keyframes);
  planes_.forget(keyframes);
  std::map<int, Keyframe> gone;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    for (const int id : keyframes) gone.insert(keyframes_.extract(id));
    ++version_;
  }
  {
    const std::lock_guard<std::mutex> lock(surface_mutex_);
    for (const int id : keyframes) surface_.forget(id);
  }
  std::map<int, int> heirs;
  for (const auto& [id, keyframe] : gone) heirs[id] = nearest(keyframe.T_map_camera);
  for (auto& [id, between] : between_)
    if (const auto heir = heirs.find(between.keyframe); heir != heirs.end())
      between = {heir->second, keyframes_.at(heir->second).T_map_camera.inverse() *
                                   gone.at(heir->first).T_map_camera * between.T_keyframe_camera};
  if (const auto heir = heirs.find(last_keyframe_); heir != heirs.end()) last_keyframe_ = heir->second;
}

/// Of the map's own keyframes.
int LiveMap::nearest(const Eigen::Isometry3d& T_map_camera) const {
  int nearest = -1;
  double least = std::numeric_limits<double>::infinity();
  for (const auto& [id, keyframe] : keyframes_) {
    const double away = distance_between(keyframe.T_map_camera, T_map_camera);
    if (keyframe.is_adopted || away >= least) continue;
    least = away;
    nearest = id;
  }
  return nearest;
}

bool LiveMap::improve() {
  const std::lock_guard<std::mutex> lock(surface_mutex_);
  const bool is_left = surface_.refuse(1) > 0;
  if (!is_left) fell_behind_ = false;
  return is_left;
}

LiveMap::Haste LiveMap::haste() const {
  if (unwatched_ > settings_.surface_rest) return Haste::none;
  return fell_behind_ ? Haste::much : Haste::some;
}

void LiveMap::frame_shown() {
  planes_.frame();
  if (unwatched_ <= settings_.surface_rest) ++unwatched_;
}

/// False: for a while nobody did.
bool LiveMap::watch_surface() const {
  const bool was_watched = unwatched_ <= settings_.surface_rest;
  if (!was_watched) fell_behind_ = true;
  unwatched_ = 0;
  return was_watched;
}

/// Frames go on in between.
void LiveMap::settle_surface() const {
  constexpr int at_once = 4;
  const auto is_left = [this] {
    const std::lock_guard<std::mutex> lock(surface_mutex_);
    return surface_.refuse(at_once) > 0;
  };
  while (is_left()) {
  }
  fell_behind_ = false;
}

void LiveMap::settle() {
  space_.settle();
  planes_.settle();
  settle_surface();
}

Mesh LiveMap::mesh() const {
  if (!watch_surface()) settle_surface();
  const std::lock_guard<std::mutex> lock(surface_mutex_);
  return surface_.mesh();
}

Mesh LiveMap::settled_mesh() const {
  settle_surface();
  const std::lock_guard<std::mutex> lock(surface_mutex_);
  return surface_.mesh();
}

ColouredCloud LiveMap::cloud(double resolution) const {
  std::vector<std::int64_t> ids;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    for (const auto& [id, keyframe] : keyframes_) ids.push_back(id);
  }
  const std::lock_guard<std::mutex> lock(surface_mutex_);
  return surface_.cloud(ids, resolution);
}

std::int64_t LiveMap::changed_mesh(std::int64_t changed, const SeeCube& see) const {
  watch_surface();  // who follows it need not wait
  std::vector<std::pair<MeshCube, Mesh>> cubes;
  {
    const std::lock_guard<std::mutex> lock(surface_mutex_);
    const SurfaceMesh& mesh = surface_.meshed();
    for (const MeshCube& cube : mesh.cubes(changed)) cubes.emplace_back(cube, mesh.joined(cube));
  }
  for (const auto& [cube, mesh] : cubes) {
    see(cube, mesh);
    changed = std::max(changed, cube.changed);
  }
  return changed;
}

bool LiveMap::has(int keyframe) const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return keyframes_.count(keyframe) > 0;
}

std::int64_t LiveMap::version() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return version_;
}

std::size_t LiveMap::memory_bytes() const {
  const std::lock_guard<std::mutex> lock(surface_mutex_);
  return space_.memory_bytes() + planes_.memory_bytes() + surface_.memory_bytes();
}

cv::Mat depth_of_cloud(const ColouredCloud& cloud, const CameraModel& camera) {
  constexpr double spacing =
      0.01;  // rad between a keyframe's points: about 12,000 in a view of 60 x 45 degrees
  cv::Mat_<std::uint16_t> depth(camera.height, camera.width, std::uint16_t{0});
  const int radius = std::max(1, static_cast<int>(std::ceil(0.5 * spacing * camera.fx)));
  for (const Eigen::Vector3f& point : cloud.points) {
    if (!(point.z() > 0.05F) || point.z() > 60) continue;
    const auto pixel = camera.project(point.cast<double>());
    if (!pixel) continue;
    const int u = static_cast<int>(std::lround(pixel->x())), v = static_cast<int>(std::lround(pixel->y()));
    const auto z = static_cast<std::uint16_t>(std::lround(1000 * point.z()));
    for (int y = std::max(0, v - radius); y <= std::min(camera.height - 1, v + radius); ++y)
      for (int x = std::max(0, u - radius); x <= std::min(camera.width - 1, u + radius); ++x)
        if (depth(y, x) == 0 || z < depth(y, x)) depth(y, x) = z;
  }
  return depth;
}

}  // namespace lcmslam
