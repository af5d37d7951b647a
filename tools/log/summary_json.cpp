#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <lcmslam/messages/schema.hpp>
#include "tools/log/log_summary.hpp"

namespace lcmslam {
namespace {

using Json = nlohmann::ordered_json;

Json channel_json(const std::string& name, const ChannelSummary& channel) {
  Json types = Json::array();
  for (const auto& [fingerprint, n] : channel.types) {
    const MessageType* type = MessageType::find(fingerprint);
    types.push_back({{"fingerprint", fmt::format("{:016x}", fingerprint)},
                     {"name", type != nullptr ? Json(type->name) : Json()},
                     {"messages", n}});
  }
  Json senders = Json::array();
  for (const auto& [sender, count] : channel.senders.table())
    senders.push_back({{"sender", sender},
                       {"messages", count.received},
                       {"lost", count.lost},
                       {"duplicates", count.duplicates},
                       {"reordered", count.reordered}});
  return {{"channel", name},
          {"messages", channel.count},
          {"bytes", channel.bytes},
          {"largest", channel.largest},
          {"rate", channel.rate},
          {"largest_gap", 1e-6 * static_cast<double>(channel.largest_gap)},
          {"jumps_back", channel.jumps_back},
          {"types", types},
          {"messages_of_other_types", channel.other_types},
          {"messages_without_type", channel.untyped},
          {"senders", senders}};
}

}  // namespace

std::string summary_json(const LogSummary& summary) {
  Json json{{"file", summary.file}, {"bytes", summary.size}, {"events", summary.events}};
  json["jumps_back"] = summary.jumps_back;
  for (const char* list : {"sessions", "channels", "in_pieces", "damages"}) json[list] = Json::array();
  for (const SessionSummary& s : summary.sessions)
    json["sessions"].push_back(
        {{"offset", s.offset}, {"events", s.events}, {"first_utime", s.first}, {"last_utime", s.last}});
  for (const auto& [name, channel] : summary.channels)
    json["channels"].push_back(channel_json(name, channel));
  for (const auto& [name, c] : summary.in_pieces)
    json["in_pieces"].push_back(
        {{"channel", name}, {"pieces", c.pieces}, {"whole", c.whole}, {"incomplete", c.incomplete}});
  for (const LogDamage& d : summary.damages)
    json["damages"].push_back({{"begin", d.begin}, {"end", d.end}, {"reason", d.reason}, {"lost", d.lost}});
  // Channel names are any bytes: those that are no UTF-8 are replaced.
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace lcmslam
