#include <spdlog/spdlog.h>
#include <fstream>

#include <lcmslam/imaging/io/codec.hpp>
#include <lcmslam/imaging/io/encoded_frame.hpp>
#include <lcmslam/simulation/simulation.hpp>
#include "procs/camera/camera_log.hpp"
#include "procs/camera/camera_source.hpp"

namespace lcmslam {
namespace {

constexpr Utime encoder_period = 20'000;  // us

/// Interleaves encoder readings with the truth at their times, and frames, by time.
class SimulationSource : public CameraSource {
 public:
  explicit SimulationSource(const SimulationSourceSettings& settings)
      : settings_(settings.simulation),
        jpeg_quality_(settings.jpeg_quality),
        simulation_(settings_),
        frame_period_(simulation_.frame_period()),
        next_encoders_(simulation_.start()),
        next_truth_(simulation_.start()),
        next_frame_(simulation_.start() + frame_period_) {}

  const SimulationSettings& settings() const { return settings_; }
  int jpeg_quality() const { return jpeg_quality_; }
  const RgbdCalibration& calibration() const override { return simulation_.calibration(); }

  std::size_t frames() const override {
    return static_cast<std::size_t>((simulation_.end() - simulation_.start()) / frame_period_);
  }

  std::vector<std::string> notes() const override {
    char length[64];
    std::snprintf(length, sizeof length, "%.1f m, %.0f s", simulation_.path_length(),
                  1e-6 * static_cast<double>(simulation_.end() - simulation_.start()));
    return {"simulates " + settings_.scene.filename().string() + ": " + length + ", head " + settings_.head +
            ", base " + settings_.base + ", seed " + std::to_string(settings_.seed)};
  }

  std::optional<CameraEvent> next() override {
    const Utime now = std::min({next_encoders_, next_truth_, next_frame_});
    if (now > simulation_.end()) return std::nullopt;
    if (now == next_truth_) {
      next_truth_ += encoder_period;
      return GroundTruth{now, "robot", simulation_.T_world_robot(now)};
    }
    if (now == next_encoders_) {
      next_encoders_ += encoder_period;
      return simulation_.encoders(now);
    }
    next_frame_ += frame_period_;
    EncodedFrame frame = encode(simulation_.render(now), jpeg_quality_);
    frame.sensor = simulation_.calibration().sensor;
    return frame;
  }

 private:
  SimulationSettings settings_;
  int jpeg_quality_;
  Simulation simulation_;
  Utime frame_period_;
  Utime next_encoders_, next_truth_, next_frame_;
};

/// Names everything that the rendered log depends on; raise `revision` when sensors or renderer change.
std::filesystem::path cache_file(const SimulationSettings& s, int jpeg_quality) {
  std::string text;
  for (const std::filesystem::path& file : {s.scene, head_file(s)}) {
    std::ifstream in(file);
    text.append(std::istreambuf_iterator<char>(in), {});
  }
  if (s.unit > 0) text += "unit " + std::to_string(s.unit);
  constexpr int revision = 3;  // of time-of-flight cameras that fold
  char name[256];
  const std::filesystem::path head = head_file(s);
  const CameraFaults& f = s.faults;
  char faults[128] = "";
  if (f.rolling_shutter > 0 || f.exposure_adaptation > 0 || f.image_stamp_error != 0 ||
      f.depth_stamp_error != 0 || f.stamp_jitter > 0)
    std::snprintf(faults, sizeof faults, "-faults%g-%g-%g-%g-%g", f.rolling_shutter, f.exposure_adaptation,
                  f.image_stamp_error, f.depth_stamp_error, f.stamp_jitter);
  std::snprintf(name, sizeof name, "%s-%s%s-%s-seed%llu-%gs-%dlaps-%gHz-q%d-%016zx-r%d.lcmlog",
                s.scene.stem().c_str(), head.empty() ? s.head.c_str() : head.stem().c_str(), faults,
                s.base.c_str(), static_cast<unsigned long long>(s.seed), s.seconds, s.laps, s.frame_rate,
                jpeg_quality, std::hash<std::string>()(text), revision);
  return std::filesystem::absolute("out") / "cache" / name;
}

}  // namespace

std::unique_ptr<CameraSource> make_live_simulation(const SimulationSourceSettings& settings) {
  return std::make_unique<SimulationSource>(settings);
}

std::unique_ptr<CameraSource> make_simulation_source(const SimulationSourceSettings& settings) {
  auto simulation = std::make_unique<SimulationSource>(settings);
  if (settings.render != "cached") return simulation;
  const std::filesystem::path file = cache_file(simulation->settings(), simulation->jpeg_quality());
  if (!std::filesystem::exists(file)) {
    std::filesystem::create_directories(file.parent_path());
    spdlog::info("renders the run into {}", file.string());
    write_log(*simulation, file);
  }
  return open_log(file);
}

}  // namespace lcmslam
