#include "camera/camera_source.hpp"

namespace lcmslam {

Utime event_utime(const CameraEvent& event) {
  return std::visit([](const auto& e) { return e.utime; }, event);
}

std::unique_ptr<CameraSource> make_camera_source(const ConfigNode& config) {
  const std::string source = config.choice("source", "simulation", {"simulation", "dataset"});
  // The other source's section may stand in the file: a run chooses between them.
  config.ignore(source == "simulation" ? "dataset" : "simulation");
  return source == "simulation" ? make_simulation_source(config.section("simulation"))
                                : make_dataset_source(config.section("dataset"));
}

}  // namespace lcmslam
