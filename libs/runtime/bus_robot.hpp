#pragma once
// Several robots on one bus: each one's channels begin with its name and a slash, dora/CAMERA. Where a
// message goes out (BusSender) the name is put in front, where messages come in (LcmBus::listen) others'
// channels are left out and the name is taken away: nodes and tools never see it.

#include <memory>
#include <string>

#include <lcmslam/runtime/bus_reader.hpp>

namespace lcmslam {

/// "dora/" of LCMSLAM_ROBOT; empty without. An environment variable for the same reason as
/// LCMSLAM_BUS_ALLOW. Throws std::invalid_argument for what is no name.
std::string robot_prefix();

/// Throws std::invalid_argument unless it is 1 to 32 letters, digits, dashes and underscores (channels have
/// 63 characters at most).
void check_robot_name(const std::string& name);

/// From now on this process and those that it starts speak as this robot; empty: nothing changes.
void set_robot(const std::string& name);

/// "CAMERA" of "dora/CAMERA"; what has no robot's name stays.
std::string without_robot(const std::string& channel);

/// Of the messages of `source`, which must be told channels with the prefix.
class RobotReader : public BusReader {
 public:
  RobotReader(std::unique_ptr<BusReader> source, std::string prefix)
      : source_(std::move(source)), prefix_(std::move(prefix)) {}

  bool read(BusMessage& message, std::chrono::milliseconds wait) override;
  Refusals refusals() const override { return source_->refusals(); }
  SocketState socket() const override { return source_->socket(); }

 private:
  std::unique_ptr<BusReader> source_;
  std::string prefix_;
};

}  // namespace lcmslam
