#include "procs/bridge/bridge_settings.hpp"

#include <unistd.h>
#include <stdexcept>

#include <lcmslam/runtime/bus_robot.hpp>

namespace lcmslam {
namespace {

constexpr Choice<bridge::Side> sides[] = {{"robot", bridge::Side::robot},
                                          {"operator", bridge::Side::operating}};

std::string host_name() {
  char name[256] = "";
  gethostname(name, sizeof name - 1);
  return name;
}

/// What is wrong with rules; empty: nothing.
std::string fault(const std::vector<std::string>& rules) {
  try {
    bridge::parse_rules(rules);
    return {};
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
}

/// What came in on such a channel would go out again, and come back from the other end's bridge likewise.
std::string both_ways(const std::vector<std::string>& send, const std::vector<std::string>& receive) {
  for (const bridge::ChannelRule& in : bridge::parse_rules(receive))
    for (const bridge::ChannelRule& out : bridge::parse_rules(send))
      if (in.channel == out.channel)
        return "must not have " + in.channel + ", which send has too: it would go round and round";
  return {};
}

}  // namespace

void TlsSettings::describe(SettingsVisitor& s) {
  s.text("certificates", certificates,
         "file or folder of the certificates that are trusted, e.g. /etc/ssl/certs; empty: not encrypted");
  s.text("certificate", certificate, "file of this bridge's own certificate; empty: none");
  s.text("key", key, "file of its key");
}

void BridgeSettings::describe(SettingsVisitor& s) {
  s.text("host", host, "where the MQTT 5 broker runs");
  s.number("port", port, "", {1, 65535}, "of the broker: 1883, with TLS 8883 as a rule");
  s.section("tls", tls, "encryption");
  s.text("user", user, "name at the broker; empty: none");
  s.text("password_file", password_file,
         "file whose first line is the password, its owner's alone (chmod 600)");
  s.flag("insecure", insecure, "speak to a broker on another machine even without TLS or without a name");
  s.number("longest_pause", longest_pause, "s", {0.1, 3600},
           "between two attempts to connect; the first come soon");
  s.text("topic", topic, "in front of all topics: TOPIC/ROBOT/from/CHANNEL and TOPIC/ROBOT/to/CHANNEL");
  s.text("robot", robot, "name in the topics; empty: launch.robot, else this machine's name");
  s.choice("side", side, sides, "robot: sends its channels and takes orders; operator: the other end");
  s.texts("send", send,
          "channels that go to the broker, of small messages the most urgent first, and large ones share the "
          "link; CHANNEL@RATE: the newest, so many a second at most");
  s.texts("receive", receive,
          "channels that are taken from the broker, e.g. [COMMAND, MAP_REQUEST]; all others are refused");
  s.number("bandwidth", bandwidth, "bit/s", {0, 1e10},
           "that sending takes at most; 0: what the link carries");
  s.number("delay", delay, "s", {0.05, 10}, "that what is under way may queue on the link");
  s.number("memory", memory, "MB", {1, 100'000}, "of the map that is held for a broker that was away");
  s.number("kept_for", kept_for, "h", {0.01, 1e6}, "that the broker keeps the map of a robot that is silent");
  s.number("snapshot_period", snapshot_period, "s", {1, 86'400},
           "between two whole landmark maps and graphs for those who come late; longer when they are large");
  s.number("piece", piece, "B", {1000, 1'000'000},
           "larger messages of the map go in pieces, so that none waits long");
  s.number("picture_width", picture_width, "pixel", {16, 10'000}, "of the pictures of CAMERA, at most");
  s.number("picture_quality", picture_quality, "", {1, 100}, "of their JPEG");
  s.require(fault(send).empty(), "send", fault(send).c_str());
  s.require(fault(receive).empty(), "receive", fault(receive).c_str());
  if (!fault(send).empty() || !fault(receive).empty()) return;
  const std::string circle = both_ways(send, receive);
  s.require(circle.empty(), "receive", circle.c_str());
}

bridge::OutboxLimits BridgeSettings::limits() const {
  bridge::OutboxLimits limits;
  limits.delay = delay;
  limits.bandwidth = bandwidth / 8;
  limits.memory = static_cast<std::size_t>(memory * 1e6);
  limits.kept_for = kept_for * 3600;
  return limits;
}

bridge::Broker BridgeSettings::broker() const {
  bridge::Broker broker;
  broker.host = host;
  broker.port = port;
  broker.certificates = tls.certificates;
  broker.certificate = tls.certificate;
  broker.key = tls.key;
  broker.user = user;
  if (!password_file.empty()) broker.password = bridge::read_password(password_file);
  broker.longest_pause = longest_pause;
  if (const std::string why = bridge::objection(broker); !why.empty() && !insecure)
    throw std::invalid_argument("bridge: " + why);
  return broker;
}

bridge::Topics BridgeSettings::topics() const {
  std::string name = robot.empty() ? robot_prefix() : robot + "/";
  if (name.empty()) name = host_name() + "/";
  name.pop_back();
  return {topic, name, side};
}

}  // namespace lcmslam
