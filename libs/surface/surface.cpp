#include <lcmslam/surface/surface.hpp>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>

#include <lcmslam/cloud/voxel_average.hpp>
#include <lcmslam/settings/check.hpp>
#include <lcmslam/surface/view_fusion.hpp>

namespace lcmslam {
namespace {

constexpr double fine_share = 0.8;        // of the memory; coarse blocks are few
constexpr std::size_t most_waiting = 30;  // half a megabyte each; who looks first waits for 0.15 s

std::size_t blocks_in(double megabytes) {
  return std::max<std::size_t>(static_cast<std::size_t>(megabytes * 1e6) / sizeof(VoxelBlock), 16);
}

/// In the depth camera's frame.
ColouredCloud coloured_points(const SurfaceView& view) {
  ColouredCloud cloud;
  for (int v = 0; v < view.points.rows; ++v)
    for (int u = 0; u < view.points.cols; ++u) {
      const SurfacePixel& pixel = view.pixels[view.at(v, u)];
      const auto& point = view.points.at<cv::Vec3f>(v, u);
      const auto& normal = view.normals.at<cv::Vec3f>(v, u);
      if ((pixel.look & SurfacePixel::coloured) == 0 || std::isnan(point[2])) continue;
      cloud.points.emplace_back(point[0], point[1], point[2]);
      cloud.normals.emplace_back(normal[0], normal[1], normal[2]);
      cloud.colours.emplace_back(pixel.colour[0], pixel.colour[1], pixel.colour[2]);
    }
  return cloud;
}

std::size_t bytes_of(const SurfaceImage& image) {
  std::size_t bytes = 0;
  for (const cv::Mat* part : {&image.depth, &image.amplitude, &image.colour, &image.seen})
    bytes += part->total() * part->elemSize();
  return bytes;
}

void require_finite(const Eigen::Isometry3d& T, const char* name) {
  if (!T.matrix().allFinite())
    throw std::invalid_argument(std::string("surface: ") + name + " must be finite");
}

SurfaceSettings checked(const SurfaceSettings& settings) {
  check(settings, "surface");
  return settings;
}

}  // namespace

Surface::Surface(const RgbdCalibration& calibration, const SurfaceSettings& settings)
    : settings_(checked(settings)),
      maker_(std::make_shared<SurfaceViewMaker>(calibration, settings_)),
      fine_(settings_.voxel_size, settings_.truncation),
      coarse_(settings_.coarse_voxel_size, settings_.truncation),
      mesh_(settings_) {}

void Surface::look_through(const RgbdCalibration& calibration) {
  maker_ = std::make_shared<SurfaceViewMaker>(calibration, settings_);
}

void Surface::hand_in(std::int64_t keyframe, const RgbdFrame& frame, const Eigen::Isometry3d& T_map_camera,
                      const Eigen::Isometry3d& T_colour_depth_time, bool of_before) {
  require_finite(T_map_camera, "T_map_camera");
  require_finite(T_colour_depth_time, "T_colour_depth_time");
  if (keyframes_.count(keyframe) > 0)
    throw std::invalid_argument("surface: keyframe " + std::to_string(keyframe) +
                                " is there already; move() tells a new pose");
  SurfaceImage image = maker_->image(frame, T_colour_depth_time);
  waiting_bytes_ += bytes_of(image);
  Keyframe& kept = keyframes_[keyframe];
  kept.arrival = {!of_before, ++arrived_};
  kept.maker = maker_;
  kept.waiting = std::move(image);
  kept.T_wanted = T_map_camera;
  arrivals_[kept.arrival] = keyframe;
  waiting_.push_back(keyframe);
  if (!of_before) camera_ = T_map_camera.translation();
  if (waiting_.size() > most_waiting) fuse_oldest();
}

void Surface::fuse(std::int64_t keyframe, const RgbdFrame& frame, const Eigen::Isometry3d& T_map_camera,
                   const Eigen::Isometry3d& T_colour_depth_time) {
  hand_in(keyframe, frame, T_map_camera, T_colour_depth_time);
  fuse_all();
}

void Surface::fuse_oldest() {
  Keyframe& kept = keyframes_.at(waiting_.front());
  waiting_.pop_front();
  const SurfaceImage image = *std::exchange(kept.waiting, std::nullopt);
  waiting_bytes_ -= bytes_of(image);
  put_in(kept.maker->view(image), kept.T_wanted * image.T_camera_depth);
  kept.view.emplace(image);
  kept.T_map_camera = kept.T_wanted;
  kept.fused = fusion_;
  kept_bytes_ += kept.view->memory_bytes();
  keep_bounds();
}

void Surface::fuse_all() {
  while (!waiting_.empty()) fuse_oldest();
}

void Surface::move(std::int64_t keyframe, const Eigen::Isometry3d& T_map_camera) {
  require_finite(T_map_camera, "T_map_camera");
  const auto found = keyframes_.find(keyframe);
  if (found != keyframes_.end() && (found->second.waiting || found->second.view))
    found->second.T_wanted = T_map_camera;
}

void Surface::forget(std::int64_t keyframe) {
  const auto found = keyframes_.find(keyframe);
  if (found == keyframes_.end()) return;
  if (found->second.waiting) {
    waiting_bytes_ -= bytes_of(*found->second.waiting);
    waiting_.erase(std::find(waiting_.begin(), waiting_.end(), keyframe));
  }
  arrivals_.erase(found->second.arrival);
  if (found->second.view) gone_.push_back(std::move(found->second));
  keyframes_.erase(found);
}

void Surface::take_out_gone() {
  const Keyframe& keyframe = gone_.back();
  const SurfaceImage image = keyframe.view->unpacked();
  take_out(keyframe.maker->view(image), keyframe.T_map_camera * image.T_camera_depth, keyframe.fused);
  ++fusion_;
  kept_bytes_ -= keyframe.view->memory_bytes();
  gone_.pop_back();
}

int Surface::refuse(int keyframes) {
  fuse_all();
  const bool any_gone = keyframes > 0 && !gone_.empty();
  for (; keyframes > 0 && !gone_.empty(); --keyframes) take_out_gone();
  std::vector<std::pair<double, std::int64_t>> moved;  // shift, keyframe
  for (const auto& [id, keyframe] : keyframes_)
    if (keyframe.view && shift(keyframe) >= 1) moved.emplace_back(-shift(keyframe), id);
  std::sort(moved.begin(), moved.end());
  const std::size_t now = std::min(moved.size(), static_cast<std::size_t>(std::max(keyframes, 0)));
  for (std::size_t i = 0; i < now; ++i) {
    Keyframe& keyframe = keyframes_.at(moved[i].second);
    const SurfaceImage image = keyframe.view->unpacked();
    const SurfaceView view = keyframe.maker->view(image);
    take_out(view, keyframe.T_map_camera * image.T_camera_depth, keyframe.fused);
    put_in(view, keyframe.T_wanted * image.T_camera_depth);
    keyframe.T_map_camera = keyframe.T_wanted;
    keyframe.fused = fusion_;
  }
  const std::size_t left = moved.size() - now + gone_.size();
  if ((now > 0 || any_gone) && left == 0)
    for (VoxelBlocks* blocks : {&fine_, &coarse_})
      blocks->remove([](const VoxelBlocks::Entry& entry) { return is_empty(*entry.block); });
  return static_cast<int>(left);
}

void Surface::put_in(const SurfaceView& view, const Eigen::Isometry3d& T_map_depth) {
  ++fusion_;
  fuse_view(view, T_map_depth, settings_, settings_.fine_range, fusion_, fine_);
  fuse_view(view, T_map_depth, settings_, settings_.max_range, fusion_, coarse_);
}

/// It counts as the next fusion.
void Surface::take_out(const SurfaceView& view, const Eigen::Isometry3d& T_map_depth, std::int64_t fused) {
  for (VoxelBlocks* blocks : {&fine_, &coarse_})
    take_out_view(view, T_map_depth, settings_, fused, fusion_ + 1, *blocks);
}

void Surface::keep_bounds() {
  const Eigen::Vector3f place = camera_.cast<float>();
  given_way_ += fine_.keep_near(place, blocks_in(fine_share * settings_.memory));
  given_way_ += coarse_.keep_near(place, blocks_in((1 - fine_share) * settings_.memory));
  const auto most = static_cast<std::size_t>(settings_.kept_memory * 1e6);
  while (kept_bytes_ > most && !gone_.empty()) take_out_gone();
  for (auto first = arrivals_.begin(); kept_bytes_ > most && first != arrivals_.end();) {
    const auto keyframe = keyframes_.find(first->second);
    if (keyframe->second.waiting) {
      ++first;
      continue;
    }
    kept_bytes_ -= keyframe->second.view->memory_bytes();
    keyframes_.erase(keyframe);
    first = arrivals_.erase(first);
  }
}

double Surface::shift(const Keyframe& keyframe) const {
  return std::max(distance_between(keyframe.T_map_camera, keyframe.T_wanted) / settings_.moved_distance,
                  angle_between(keyframe.T_map_camera, keyframe.T_wanted) / settings_.moved_angle);
}

ColouredCloud Surface::cloud(const std::vector<std::int64_t>& keyframes, double resolution) const {
  VoxelAverage average(resolution);
  for (const std::int64_t id : keyframes) {
    const auto found = keyframes_.find(id);
    if (found == keyframes_.end() || !(found->second.waiting || found->second.view)) continue;
    const SurfaceImage image =
        found->second.waiting ? *found->second.waiting : found->second.view->unpacked();
    average.add(coloured_points(found->second.maker->view(image)),
                found->second.T_wanted * image.T_camera_depth);
  }
  return average.result();
}

const SurfaceMesh& Surface::meshed() {
  fuse_all();
  mesh_.update(fine_, coarse_);
  return mesh_;
}

Mesh Surface::mesh() {
  return meshed().joined();
}

std::size_t Surface::memory_bytes() const {
  return fine_.memory_bytes() + coarse_.memory_bytes() + mesh_.memory_bytes() + kept_bytes_ + waiting_bytes_;
}

}  // namespace lcmslam
