#include <lcmslam/runtime/process.hpp>
#include "procs/bridge/bridge_node.hpp"
#include "procs/bridge/mqtt/mqtt_link.hpp"

int main(int argc, char** argv) {
  using namespace lcmslam;
  return run_process(argc, argv, "bridge", "Chosen channels to an MQTT broker and from it.",
                     [](const ConfigNode& config, Publisher& publisher) {
                       return std::make_unique<BridgeNode>(config, publisher, [](const BridgeEnds& ends) {
                         return std::make_unique<MqttLink>(ends);
                       });
                     });
}
