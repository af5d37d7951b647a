#include <lcmslam/parallel/shared_processors.hpp>
#include <lcmslam/runtime/process.hpp>
#include "procs/fastslam/fastslam_node.hpp"

int main(int argc, char** argv) {
  using namespace lcmslam;
  share_processors();
  return run_process(argc, argv, "fastslam",
                     "FEATURES + ODOMETRY -> FASTSLAM_*: particle filter over SURF landmarks.",
                     [](const ConfigNode& config, Publisher& publisher) {
                       return std::make_unique<FastSlamNode>(config, publisher);
                     });
}
