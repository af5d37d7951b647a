#include <lcmslam/runtime/process.hpp>
#include "procs/odometry/odometry_node.hpp"

int main(int argc, char** argv) {
  using namespace lcmslam;
  return run_process(argc, argv, "odometry",
                     "ENCODERS, TWIST, FEATURES or another driver's pose -> ODOMETRY.",
                     [](const ConfigNode& config, Publisher& publisher) {
                       return std::make_unique<OdometryNode>(config, publisher);
                     });
}
