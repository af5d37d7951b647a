#include "procs/camera/camera_source.hpp"

#include <map>

#include "procs/camera/camera_log.hpp"

namespace lcmslam {

Utime event_utime(const CameraEvent& event) {
  return std::visit([](const auto& e) { return e.utime; }, event);
}

std::unique_ptr<CameraSource> make_camera_source(const ConfigNode& config) {
  using Factory = std::unique_ptr<CameraSource> (*)(const ConfigNode&);
  const std::map<std::string, Factory> factories = {
      {"simulation", make_simulation_source}, {"dataset", make_dataset_source}, {"log", make_log_source}};
  const std::string source = config.choice("source", "simulation", {"simulation", "dataset", "log"});
  // The other sources' sections may stand in the file: a run chooses between them.
  for (const auto& [name, factory] : factories)
    if (name != source) config.ignore(name);
  return factories.at(source)(config.section(source));
}

std::unique_ptr<CameraSource> make_log_source(const ConfigNode& config) {
  return open_log(config.text("file"));
}

}  // namespace lcmslam
