#pragma once
// Names on the broker: PREFIX/ROBOT/from/CHANNEL[/KEY...] goes from the robot to whoever listens,
// PREFIX/ROBOT/to/CHANNEL to the robot. A key tells what a message replaces: a keyframe, a whole map.

#include <string>
#include <string_view>

namespace lcmslam::bridge {

enum class Side { robot, operating };

class Topics {
 public:
  /// Throws std::invalid_argument for a prefix or a name that topics cannot hold.
  Topics(const std::string& prefix, const std::string& robot, Side side);

  /// `name`: CHANNEL or CHANNEL/KEY.
  std::string outgoing(const std::string& name) const { return out_ + name; }
  /// Filter for all that this side may be sent on a channel.
  std::string incoming(const std::string& channel) const { return in_ + channel + "/#"; }
  /// Channel of a topic of this side; empty for any other topic.
  std::string channel_of(std::string_view topic) const;
  /// Whether the bridge is there ("1") or not ("0").
  std::string presence() const { return base_ + "bridge/" + side_ + "/present"; }
  /// What the broker keeps of this bridge, see Outbox.
  std::string mark() const { return base_ + "bridge/" + side_ + "/kept"; }

 private:
  std::string base_, side_, out_, in_;
};

}  // namespace lcmslam::bridge
