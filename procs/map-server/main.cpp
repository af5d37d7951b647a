#include <lcmslam/runtime/process.hpp>
#include "procs/map-server/page/page_node.hpp"

int main(int argc, char** argv) {
  using namespace lcmslam;
  return run_process(argc, argv, "map-server",
                     "Keeps both maps, answers MAP_REQUEST, saves them, shows the live page.",
                     [](const ConfigNode& config, Publisher& publisher) {
                       return std::make_unique<PageNode>(config, publisher);
                     });
}
