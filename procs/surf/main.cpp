#include <lcmslam/parallel/shared_processors.hpp>
#include <lcmslam/runtime/process.hpp>
#include "procs/surf/surf_node.hpp"

int main(int argc, char** argv) {
  using namespace lcmslam;
  share_processors();
  return run_process(argc, argv, "surf", "CAMERA -> FEATURES: SURF with 3-D points.",
                     [](const ConfigNode& config, Publisher& publisher) {
                       return std::make_unique<SurfNode>(config, publisher);
                     });
}
