#pragma once
// Section `bridge`.

#include <string>
#include <vector>

#include <lcmslam/bridge/broker.hpp>
#include <lcmslam/bridge/channel_rule.hpp>
#include <lcmslam/bridge/outbox.hpp>
#include <lcmslam/bridge/topics.hpp>
#include <lcmslam/settings/settings.hpp>

namespace lcmslam {

struct TlsSettings {
  std::string certificates, certificate, key;

  void describe(SettingsVisitor& s);
};

struct BridgeSettings {
  std::string host = "localhost", user, password_file;
  TlsSettings tls;
  int port = 1883;
  double longest_pause = 30;
  bool insecure = false;
  std::string topic = "lcmslam", robot;
  bridge::Side side = bridge::Side::robot;
  /// Of small messages what stands first goes first; large ones share the link.
  std::vector<std::string> send = {"STATUS@1",    "FASTSLAM_POSE@5", "ICP_POSE@5", "FASTSLAM_LANDMARKS@1",
                                   "ICP_GRAPH@1", "ICP_KEYFRAME",    "CAMERA@0.5"};
  std::vector<std::string> receive;
  double bandwidth = 0, delay = 0.15, memory = 256, kept_for = 168, snapshot_period = 30;
  int piece = 8000, picture_width = 320, picture_quality = 50;

  void describe(SettingsVisitor& s);

  bridge::OutboxLimits limits() const;
  /// Throws std::invalid_argument for a password file that cannot be read or that others can.
  bridge::Broker broker() const;
  bridge::Topics topics() const;
};

}  // namespace lcmslam
