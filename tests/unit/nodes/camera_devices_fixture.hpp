#pragma once
// The camera process with a head whose cameras are described beside it.

#include <gmock/gmock.h>

#include <thread>

#include <lcmslam/status_t.hpp>
#include "procs/camera/camera_node.hpp"
#include "procs/camera/drivers/device_source.hpp"
#include "tests/support/written_head.hpp"
#include "tests/unit/runtime/capturing_publisher.hpp"

namespace lcmslam::testing {

inline const cv::Size colour_size{160, 120}, depth_size{80, 60};

inline double reported(const NodeReport& report, const std::string& name) {
  for (const auto& [key, value] : report.values)
    if (key == name) return value;
  ADD_FAILURE() << "no value " << name;
  return -1;
}

class CameraDevices : public ::testing::Test {
 protected:
  CameraDevices() { write_head(folder / "head.yaml", colour_size, depth_size); }

  CameraNode& start(const std::string& config) {
    node.reset();
    node = std::make_unique<CameraNode>(ConfigNode::parse(config, (folder / "robot.yaml").string()),
                                        publisher, make_source_or_device);
    node->connect(inputs);
    return *node;
  }
  void run_to_the_end() {
    const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(20);
    while (node->report().state != status_t::FINISHED && std::chrono::steady_clock::now() < end)
      std::this_thread::sleep_for(std::min<Node::Duration>(*node->work(), std::chrono::milliseconds(5)));
    ASSERT_EQ(node->report().state, status_t::FINISHED) << node->report().detail;
  }
  std::string refusal(const std::string& config) {
    try {
      start(config);
    } catch (const std::exception& error) {
      return error.what();
    }
    return "";
  }

  TemporaryFolder folder;
  CapturingPublisher publisher;
  Inputs inputs;
  std::unique_ptr<CameraNode> node;
};

}  // namespace lcmslam::testing
