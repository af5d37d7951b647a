#include <lcmslam/runtime/process.hpp>
#include "procs/camera/camera_node.hpp"
#include "procs/camera/drivers/device_source.hpp"

int main(int argc, char** argv) {
  using namespace lcmslam;
  return run_process(argc, argv, "camera", "Publishes CAMERA and CAMERA_CALIBRATION from a source.",
                     [](const ConfigNode& config, Publisher& publisher) {
                       return std::make_unique<CameraNode>(config, publisher, make_source_or_device);
                     });
}
