#include <lcmslam/live_map/live_map.hpp>

#include <algorithm>
#include <limits>

#include <lcmslam/settings/check.hpp>

namespace lcmslam {
namespace {

constexpr std::size_t most_cameras = 8;  // of which it is known what they err by
constexpr std::size_t most_between =
    10'000;                            // that move with their keyframes; older ones stay where they are
constexpr double metres_a_radian = 1;  // for how near two views are

LiveMapSettings checked(const LiveMapSettings& settings) {
  check(settings, "live map");
  return settings;
}

}  // namespace

LiveMap::Camera::Camera(Calibration of, const LiveMapSettings& settings)
    : calibration(std::move(of)),
      filter(*calibration, settings.depth_filter),
      range_error(*calibration, settings.range_error) {}

LiveMap::LiveMap(const RgbdCalibration& calibration, const LiveMapSettings& settings)
    : LiveMap(std::make_shared<RgbdCalibration>(calibration), settings) {}

LiveMap::LiveMap(Calibration calibration, const LiveMapSettings& settings)
    : settings_(checked(settings)),
      space_(settings),
      planes_(*calibration, settings),
      surface_(*calibration, settings.surface),
      unwatched_(settings.surface_rest + 1) {
  cameras_.emplace_front(std::move(calibration), settings);
}

void LiveMap::look_through(const Calibration& calibration) {
  const auto is_it = [&](const Camera& camera) { return camera.calibration == calibration; };
  const auto known = std::find_if(cameras_.begin(), cameras_.end(), is_it);
  if (known == cameras_.begin()) return;
  planes_.look_through(*calibration);
  {
    const std::lock_guard<std::mutex> lock(surface_mutex_);
    surface_.look_through(*calibration);
  }
  if (known != cameras_.end())
    cameras_.splice(cameras_.begin(), cameras_, known);
  else
    cameras_.emplace_front(calibration, settings_);
  if (cameras_.size() > most_cameras) cameras_.pop_back();
}

void LiveMap::show(RgbdFrame frame, const FramePose& pose) {
  clean(frame);
  space_.show(frame.depth, calibration().depth,
              pose.T_map_camera * pose.T_colour_depth_time * calibration().T_colour_depth,
              place_of_nearest(pose.T_map_camera));
  frame_shown();
  changed();
}

void LiveMap::glance(RgbdFrame frame, const FramePose& pose) {
  clean(frame);
  space_.glance(frame.depth, calibration().depth,
                pose.T_map_camera * pose.T_colour_depth_time * calibration().T_colour_depth);
  frame_shown();
  changed();
}

void LiveMap::add(RgbdFrame frame, const FramePose& pose) {
  check_frame(frame, calibration());
  clean(frame);
  space_.show(frame.depth, calibration().depth,
              pose.T_map_camera * pose.T_colour_depth_time * calibration().T_colour_depth,
              place_of_nearest(pose.T_map_camera));
  frame_shown();
  changed();
  const int keyframe = nearest(pose.T_map_camera);
  if (keyframe < 0) return;  // it would stand where it is whatever the graph says
  const std::int64_t id = between_.empty() ? -1 : between_.begin()->first - 1;
  between_[id] = {keyframe, keyframes_.at(keyframe).T_map_camera.inverse() * pose.T_map_camera};
  if (between_.size() > most_between) between_.erase(std::prev(between_.end()));
  fuse(id, frame, pose, When::now);
}

/// Of the keyframe that a frame hangs on.
std::optional<LiveSpace::Place> LiveMap::place_of_nearest(const Eigen::Isometry3d& T_map_camera) const {
  const int id = nearest(T_map_camera);
  if (id < 0) return std::nullopt;
  const Keyframe& keyframe = keyframes_.at(id);
  return LiveSpace::Place{id, keyframe.T_map_camera * keyframe.T_camera_depth};
}

void LiveMap::keep(int keyframe, RgbdFrame frame, const FramePose& pose, When when) {
  if (has(keyframe)) return;
  make_room();
  check_frame(frame, calibration());
  clean(frame);
  const Eigen::Isometry3d T_camera_depth = pose.T_colour_depth_time * calibration().T_colour_depth;
  const Eigen::Isometry3d T_map_depth = pose.T_map_camera * T_camera_depth;
  show_depth(frame.depth, T_map_depth, when);
  space_.keep(keyframe, frame.depth, calibration().depth, T_map_depth);
  planes_.keep(keyframe, frame.depth, T_map_depth);
  fuse(keyframe, frame, pose, when);
  kept(keyframe, pose.T_map_camera, T_camera_depth);
}

void LiveMap::adopt(int keyframe, RgbdFrame frame, const FramePose& pose) {
  if (has(keyframe) || !make_room()) return;
  keep(keyframe, std::move(frame), pose, When::before);
  keyframes_.at(keyframe).is_adopted = true;
}

void LiveMap::adopt(int keyframe, const ColouredCloud& cloud, const Eigen::Isometry3d& T_map_camera) {
  if (has(keyframe) || !make_room()) return;
  keep(keyframe, cloud, T_map_camera, When::before);
  keyframes_.at(keyframe).is_adopted = true;
}

void LiveMap::show_depth(const cv::Mat& depth, const Eigen::Isometry3d& T_map_depth, When when) {
  if (when == When::now)
    space_.show(depth, calibration().depth, T_map_depth);
  else
    space_.show_before(depth, calibration().depth, T_map_depth);
}

void LiveMap::keep(int keyframe, const ColouredCloud& cloud, const Eigen::Isometry3d& T_map_camera,
                   When when) {
  if (has(keyframe)) return;
  make_room();
  const cv::Mat depth = depth_of_cloud(cloud, calibration().depth);
  show_depth(depth, T_map_camera, when);
  space_.keep(keyframe, depth, calibration().depth, T_map_camera);
  planes_.keep(keyframe, depth, T_map_camera);
  kept(keyframe, T_map_camera, Eigen::Isometry3d::Identity());
}

/// Takes away what no surface gave, and what the camera errs by as far as it is known by now.
void LiveMap::clean(RgbdFrame& frame) {
  Camera& camera = cameras_.front();
  camera.filter(frame.depth, frame.amplitude);
  camera.range_error.learn(frame.depth, frame.depth_utime);
  camera.range_error.correct(frame.depth);
}

void LiveMap::fuse(std::int64_t id, const RgbdFrame& frame, const FramePose& pose, When when) {
  const std::lock_guard<std::mutex> lock(surface_mutex_);
  surface_.hand_in(id, frame, pose.T_map_camera, pose.T_colour_depth_time, when == When::before);
}

void LiveMap::kept(int keyframe, const Eigen::Isometry3d& T_map_camera,
                   const Eigen::Isometry3d& T_camera_depth) {
  const std::lock_guard<std::mutex> lock(mutex_);
  keyframes_[keyframe] = {T_map_camera, T_camera_depth, false};
  ++version_;
}

void LiveMap::correct(std::map<int, Eigen::Isometry3d> T_map_camera) {
  for (const auto& [id, T] : T_map_camera) given_up_.erase(id);
  const auto move = [&](const Hanging& hanging, const auto& to) {
    if (const auto moved = T_map_camera.find(hanging.keyframe); moved != T_map_camera.end())
      to(moved->second * hanging.T_keyframe_camera);
  };
  for (const auto& [id, hanging] : given_up_)
    move(hanging, [&, id = static_cast<int>(id)](const auto& T) { T_map_camera[id] = T; });
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
    for (const auto& [id, hanging] : between_)
      move(hanging, [&, id = id](const auto& T) { surface_.move(id, T); });
  }
  changed();
}

void LiveMap::follow(const std::map<int, Eigen::Isometry3d>& T_map_camera) {
  std::vector<int> gone;
  std::size_t stay = 0;
  for (const auto& [id, keyframe] : keyframes_) {
    if (keyframe.is_adopted || given_up_.count(id) > 0) continue;
    if (T_map_camera.count(id) == 0)
      gone.push_back(id);
    else
      ++stay;
  }
  if (!gone.empty() && gone.size() <= stay) hang_up(gone);
  correct(T_map_camera);
}

/// Some of the map's own stay. What hung on those that go hangs as they do.
void LiveMap::hang_up(const std::vector<int>& given_up) {
  const auto hang = [this](Hanging& hanging) {
    if (given_up_.count(hanging.keyframe) == 0) return;
    const Eigen::Isometry3d T_map_camera =
        keyframes_.at(hanging.keyframe).T_map_camera * hanging.T_keyframe_camera;
    hanging.keyframe = nearest(T_map_camera);
    hanging.T_keyframe_camera = keyframes_.at(hanging.keyframe).T_map_camera.inverse() * T_map_camera;
  };
  for (const int id : given_up) given_up_[id] = {id, Eigen::Isometry3d::Identity()};
  for (auto& [id, hanging] : given_up_) hang(hanging);
  for (auto& [id, hanging] : between_) hang(hanging);
}

/// For one more keyframe. A tenth at a time: the layers are made anew without them. False: all are the map's
/// own, and of them the oldest make room in each layer.
bool LiveMap::make_room() {
  const auto most = static_cast<std::size_t>(settings_.occupancy.max_keyframes);
  if (keyframes_.size() < most) return true;
  std::vector<int> oldest;
  for (const auto& [id, hanging] : given_up_)
    if (oldest.size() <= most / 10) oldest.push_back(static_cast<int>(id));
  for (const auto& [id, keyframe] : keyframes_)
    if (keyframe.is_adopted && oldest.size() <= most / 10) oldest.push_back(id);
  if (!oldest.empty()) forget(oldest);
  return keyframes_.size() < most;
}

/// That were given up or adopted: nothing hangs on them.
void LiveMap::forget(const std::vector<int>& keyframes) {
  space_.forget(keyframes);
  planes_.forget(keyframes);
  {
    const std::lock_guard<std::mutex> lock(surface_mutex_);
    for (const int id : keyframes) surface_.forget(id);
  }
  const std::lock_guard<std::mutex> lock(mutex_);
  for (const int id : keyframes) {
    given_up_.erase(id);
    keyframes_.erase(id);
  }
  ++version_;
}

/// Of the keyframes that the graph has.
/// Of the map's own: it sees much of the same, and is moved by the graph as that is. -1: there is none.
int LiveMap::nearest(const Eigen::Isometry3d& T_map_camera) const {
  int nearest = -1;
  double least = std::numeric_limits<double>::infinity();
  for (const auto& [id, keyframe] : keyframes_) {
    if (keyframe.is_adopted || given_up_.count(id) > 0) continue;
    const double away = distance_between(keyframe.T_map_camera, T_map_camera) +
                        metres_a_radian * angle_between(keyframe.T_map_camera, T_map_camera);
    if (away >= least) continue;
    least = away;
    nearest = id;
  }
  return nearest;
}

bool LiveMap::improve() {
  changed();
  const std::lock_guard<std::mutex> lock(surface_mutex_);
  const bool is_left = surface_.refuse(1) > 0;
  if (!is_left) fell_behind_ = false;
  return is_left;
}

bool LiveMap::catch_up() {
  if (!space_.is_behind() && !planes_.is_behind()) return false;
  space_.catch_up();
  planes_.catch_up();
  changed();
  return space_.is_behind() || planes_.is_behind();
}

void LiveMap::changed() {
  const std::lock_guard<std::mutex> lock(mutex_);
  ++version_;
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
  const std::unique_lock<std::mutex> lock(surface_mutex_, std::try_to_lock);
  if (lock.owns_lock()) surface_bytes_ = surface_.memory_bytes();
  return space_.memory_bytes() + planes_.memory_bytes() + surface_bytes_;
}

bool LiveMap::surface_gave_way() const {
  const std::lock_guard<std::mutex> lock(surface_mutex_);
  return surface_.given_way() > 0;
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
