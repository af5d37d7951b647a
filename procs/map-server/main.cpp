#include <lcmslam/runtime/process.hpp>
#include "procs/map-server/map_server_node.hpp"

int main(int argc, char** argv) {
  using namespace lcmslam;
  return run_process(argc, argv, "map-server", "Keeps both maps, answers MAP_REQUEST, saves them.",
                     [](const ConfigNode& config, Publisher& publisher) {
                       return std::make_unique<MapServerNode>(config, publisher);
                     });
}
