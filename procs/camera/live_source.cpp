#include "procs/camera/live_source.hpp"

#include <spdlog/spdlog.h>

#include "procs/camera/encode_shot.hpp"

namespace lcmslam {
namespace {

constexpr std::size_t longest_queue = 3;       // shots: older ones are out of date
constexpr std::int64_t unpaired_trouble = 15;  // images in a row, of both cameras, without a pair

}  // namespace

LiveSource::LiveSource(const RgbdCalibration& calibration, std::vector<WatchedPart> parts, Utime tolerance,
                       const LiveSettings& settings)
    : calibration_(calibration),
      jpeg_quality_(settings.jpeg_quality),
      watch_(settings.watch),
      pairs_(tolerance, calibration.depth_offset()),
      last_depth_(std::chrono::steady_clock::now()) {
  for (WatchedPart& part : parts) {
    Camera& camera = cameras_.emplace_back();
    camera.name = part.name;
    camera.watch = std::make_unique<WatchedCamera>(std::move(part.open), part.expected, settings.watch);
  }
  for (std::size_t i = 0; i < cameras_.size(); ++i) cameras_[i].thread = std::thread([this, i] { run(i); });
}

LiveSource::~LiveSource() {
  stop();
  for (Camera& camera : cameras_) camera.thread.join();
}

void LiveSource::stop() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    stop_ = true;
  }
  changed_.notify_all();
}

void LiveSource::run(std::size_t camera) {
  WatchedCamera& watch = *cameras_[camera].watch;
  std::int64_t opened = 0, opening = 0, failed = 0;
  while (true) {
    auto step = watch.step();
    const CameraHealth health = watch.health();
    if (health.opened != opened) spdlog::info("{}", watch.description());
    if (health.opened != opened) failed = 0;
    if (!health.open && health.opening != opening) {
      const bool told = (failed & (failed + 1)) == 0;  // the 1st time, the 2nd, the 4th ...
      if (told) spdlog::warn("{}", health.trouble);
      ++failed;
      opening = health.opening;
    }
    opened = health.opened;
    if (step.frame) take(camera, std::move(*step.frame));
    std::unique_lock<std::mutex> lock(mutex_);
    if (changed_.wait_for(lock, step.wait, [&] { return stop_; })) return;
  }
}

void LiveSource::take(std::size_t camera, CameraShot frame) {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (cameras_.size() == 1)
    ready_.push_back(std::move(frame));
  else
    match(camera, std::move(frame));
  for (; ready_.size() > longest_queue; ++skipped_) ready_.pop_front();
  changed_.notify_all();
}

/// Features without depth still tell FastSLAM where the robot turns to, and ICP goes by its wheels meanwhile.
/// Depth without colour does not go alone: all that is mapped of it would be black.
void LiveSource::match(std::size_t camera, CameraShot frame) {
  if (camera == 1) {
    last_depth_ = std::chrono::steady_clock::now();
    has_depth_ = true;
  } else if (is_depth_away()) {
    frame.depth_utime = frame.utime - calibration_.depth_offset();
    ready_.push_back(std::move(frame));
    ++without_depth_;
    return;
  }
  camera == 0 ? pairs_.add_colour(std::move(frame)) : pairs_.add_depth(std::move(frame));
  ++unpaired_;
  while (auto pair = pairs_.next()) {
    ready_.push_back(std::move(*pair));
    unpaired_ = 0;
  }
}

/// One that opens slowly is waited for.
bool LiveSource::is_depth_away() const {
  const std::chrono::duration<double> since = std::chrono::steady_clock::now() - last_depth_;
  return since.count() > (has_depth_ ? watch_.late_after : watch_.reopen_after);
}

std::optional<CameraEvent> LiveSource::next() {
  std::unique_lock<std::mutex> lock(mutex_);
  changed_.wait(lock, [&] { return stop_ || !ready_.empty(); });
  if (stop_) return std::nullopt;
  CameraShot frame = std::move(ready_.front());
  ready_.pop_front();
  lock.unlock();
  return encode_shot(std::move(frame), calibration_, jpeg_quality_);
}

/// Both cameras give images, and none of them fit together.
std::string LiveSource::pair_trouble() const {
  const auto miss = pairs_.last_miss();
  if (unpaired_ < unpaired_trouble || !miss) return "";
  return "no colour image is near enough to a depth image: the last was " +
         std::to_string((*miss + 500) / 1000) + " ms from the nearest (pair.tolerance)";
}

SourceHealth LiveSource::health() const {
  SourceHealth all;
  for (const Camera& camera : cameras_) {
    const CameraHealth health = camera.watch->health();
    all.silent = all.silent || health.silent;
    const std::string prefix = camera.name.empty() ? "" : camera.name + "_";
    if (!health.trouble.empty()) {
      if (!all.trouble.empty()) all.trouble += "; ";
      all.trouble += (camera.name.empty() ? "" : camera.name + ": ") + health.trouble;
    }
    all.values.insert(all.values.end(), {{prefix + "images", static_cast<double>(health.images)},
                                         {prefix + "dropped", static_cast<double>(health.dropped)},
                                         {prefix + "refused", static_cast<double>(health.refused)},
                                         {prefix + "opened", static_cast<double>(health.opened)}});
  }
  const std::lock_guard<std::mutex> lock(mutex_);
  all.values.emplace_back("skipped", static_cast<double>(skipped_));
  if (cameras_.size() < 2) return all;
  const PairCounts counts = pairs_.counts();
  all.values.insert(all.values.end(), {{"pairs", static_cast<double>(counts.pairs)},
                                       {"unmatched_colour", static_cast<double>(counts.unmatched_colour)},
                                       {"unmatched_depth", static_cast<double>(counts.unmatched_depth)},
                                       {"without_depth", static_cast<double>(without_depth_)}});
  if (all.trouble.empty()) all.trouble = pair_trouble();
  return all;
}

}  // namespace lcmslam
