#pragma once
// A live process: options, configuration, bus, STATUS, COMMAND, clean stop.

#include <functional>
#include <memory>

#include <lcmslam/configuration/config.hpp>
#include <lcmslam/runtime/node.hpp>

namespace lcmslam {

using NodeFactory = std::function<std::unique_ptr<Node>(const ConfigNode&, Publisher&)>;

/// The whole of a process's main(). Exit codes: 0 stopped as asked and its node has not failed, 1 failed, 2
/// wrong options or configuration. The last line that it writes tells the cause.
int run_process(int argc, char** argv, const std::string& name, const std::string& description,
                const NodeFactory& make_node);

}  // namespace lcmslam
