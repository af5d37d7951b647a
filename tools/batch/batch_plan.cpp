#include "tools/batch/batch_plan.hpp"

#include <algorithm>
#include <stdexcept>

#include <lcmslam/configuration/read_settings.hpp>
#include <lcmslam/configuration/yaml_text.hpp>
#include <lcmslam/runtime/launch_settings.hpp>
#include <lcmslam/runtime/options.hpp>
#include "procs/odometry/odometry_settings.hpp"

namespace lcmslam {
namespace {

/// Settings of a preset for processes that do not run are passed over.
std::vector<std::string> processes_of(const ConfigNode& config) {
  auto names = read_settings<LaunchSettings>(config.section("launch")).processes;
  for (const char* live : {"camera", "bridge"})
    names.erase(std::remove(names.begin(), names.end(), live), names.end());
  for (const std::string& name : section_names())
    if (std::find(names.begin(), names.end(), name) == names.end()) config.ignore(name);
  return names;
}

/// Refuses, and settles what is left open.
class Planner {
 public:
  Planner(const ConfigNode& config, const std::string& log, const LogOffer& offer)
      : log_(log), offer_(offer) {
    plan_.config = config;
    plan_.processes = processes_of(config);
  }

  BatchPlan plan(bool calibrated) {
    check_frames();
    if (uses_images() && !calibrated && !offer_.calibrated)
      refuse(
          "has no CAMERA_CALIBRATION, so no frame can be mapped: add --calibration FILE, or write it into "
          "the log: lcmslam log calibrate");
    if (runs("odometry")) settle_odometry();
    return plan_;
  }

 private:
  [[noreturn]] void refuse(const std::string& problem) const {
    throw std::runtime_error(log_ + ": " + problem);
  }
  bool runs(const std::string& process) const {
    return std::find(plan_.processes.begin(), plan_.processes.end(), process) != plan_.processes.end();
  }
  bool uses_images() const { return runs("surf") || runs("icp"); }

  /// The only channel of a type; empty: there is none, or several.
  std::string only_channel_of(const std::string& type) const {
    const auto found = offer_.by_type.find(type);
    return found != offer_.by_type.end() && found->second.size() == 1 ? *found->second.begin() : "";
  }

  void check_frames() {
    const auto count = [&](const std::string& channel) {
      const auto found = offer_.messages.find(channel);
      return found == offer_.messages.end() ? 0 : found->second;
    };
    if (uses_images() && !offer_.has("CAMERA") && !only_channel_of("images_t").empty()) {
      plan_.camera = only_channel_of("images_t");
      plan_.notes.push_back("images: from " + plan_.camera + ", the log's only images_t");
    }
    plan_.frames = count(uses_images() ? plan_.camera : "FEATURES");
    if (plan_.frames > 0) return;
    const std::string wanted = uses_images() ? "CAMERA (images_t)" : "FEATURES (features_t)";
    refuse("has no " + wanted + " within the times asked for, so there is no frame to map; it has " +
           offer_.listed());
  }

  /// The channel in this log; empty: there is none. Where nobody named a source, another driver's pose may
  /// have any name, as long as it is the only one.
  std::string channel_of(OdometrySource source, const std::string& usual, bool open) const {
    const bool made_here = source == OdometrySource::visual && runs("surf");
    if (made_here || offer_.has(usual)) return usual;
    return open && source == OdometrySource::external ? only_channel_of("pose_t") : "";
  }

  void settle_odometry() {
    const auto settings = read_settings<OdometryNodeSettings>(plan_.config.section("odometry"));
    const bool open = settings.source == "auto";
    std::string lacking;
    for (const auto& [name, source] : odometry_sources) {
      if (!open && settings.source != name) continue;
      const std::string usual = odometry_channel(source, settings.external_channel);
      const std::string channel = channel_of(source, usual, open);
      if (!channel.empty()) return take(name, source, channel, lacking);
      lacking += (lacking.empty() ? "" : ", ") + usual;
    }
    const std::string cure = "; --set odometry.source=auto takes what is there";
    refuse("has no " + lacking + ", so there is no odometry" +
           (open ? "" : " of odometry.source=" + settings.source + cure) + "; it has " + offer_.listed());
  }

  void take(const std::string& name, OdometrySource source, const std::string& channel,
            const std::string& missing) {
    plan_.config.set("odometry.source", name);
    if (source == OdometrySource::external)
      plan_.config.set("odometry.external_channel", yaml_quoted(channel));
    const std::string why = missing.empty() ? "" : "; the log has no " + missing;
    plan_.notes.push_back("odometry: " + name + ", from " +
                          (source == OdometrySource::visual ? "the camera's features" : channel) + why);
  }

  const std::string& log_;
  const LogOffer& offer_;
  BatchPlan plan_;
};

}  // namespace

BatchPlan plan_batch(const ConfigNode& config, const std::string& log, const LogOffer& offer,
                     bool calibrated) {
  return Planner(config, log, offer).plan(calibrated);
}

}  // namespace lcmslam
