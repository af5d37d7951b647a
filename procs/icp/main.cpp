#include <lcmslam/runtime/process.hpp>
#include "procs/icp/icp_node.hpp"

int main(int argc, char** argv) {
  using namespace lcmslam;
  return run_process(argc, argv, "icp", "CAMERA + ODOMETRY -> ICP_*: dense coloured map by registration.",
                     [](const ConfigNode& config, Publisher& publisher) {
                       return std::make_unique<IcpNode>(config, publisher);
                     });
}
