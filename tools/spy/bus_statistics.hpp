#pragma once
// What spy counts. Times are passed in (s, of any clock that never steps back).

#include <map>
#include <set>

#include <lcmslam/messages/message_value.hpp>
#include <lcmslam/messages/origin.hpp>
#include <lcmslam/messages/parts.hpp>
#include <lcmslam/runtime/sender_counts.hpp>
#include "tools/spy/arrival_rate.hpp"

namespace lcmslam {

/// One line of the table.
struct ChannelReport {
  std::string channel;
  std::string type;  ///< of the last message; "?? 20ba4f05e8f5e33a" when unknown, "-" before the first
  std::size_t types = 0;
  std::int64_t count = 0;
  ArrivalRate::Rate rate;
  std::size_t largest = 0;  ///< bytes
  std::size_t senders = 0;
  std::int64_t lost = 0, duplicates = 0, reordered = 0;  ///< by seq, summed over the senders
  std::int64_t decode_errors = 0;
  std::string last_error;
  double age = 0;  ///< s since the last message or piece
  /// Pieces on <CHANNEL>_PART: how many came, were missing by their numbering, and messages given up.
  std::int64_t pieces = 0, lost_pieces = 0, incomplete = 0;
};

class BusStatistics {
 public:
  /// Rates are those of the last `window` seconds.
  explicit BusStatistics(double window = 5) : window_(window) {}

  void add(const std::string& channel, const std::uint8_t* data, std::size_t size, double time);

  /// By name.
  std::vector<ChannelReport> channels(double now) const;

  /// Messages of channels that came when there were already too many.
  std::int64_t left_out() const { return left_out_; }

 private:
  struct Channel {
    explicit Channel(double window) : rate(window) {}
    ChannelReport report;
    ArrivalRate rate;
    SenderCounts senders, piece_senders;
    std::set<std::uint64_t> fingerprints;
    std::int64_t unread = 0;  // messages that did not decode since the last that did
    double last_time = 0;
    PartAssembler assembler;
  };

  Channel* find(const std::string& name);
  void count(Channel& channel, const std::uint8_t* data, std::size_t size, double time);
  void look_at(Channel& channel, const std::uint8_t* data, std::size_t size);
  void count_piece(Channel& channel, const part_t& part, double time);
  /// `known_missing`: messages whose number could not be read.
  static void follow(SenderCounts& senders, const Origin& origin, Utime utime, std::int64_t known_missing);
  static void fail(Channel& channel, const std::string& error);

  double window_;
  std::map<std::string, Channel> channels_;
  std::int64_t left_out_ = 0;
};

/// LCM's type hash at the head of a message; throws DecodeError when it is too short for one.
std::uint64_t message_fingerprint(const std::uint8_t* data, std::size_t size);

}  // namespace lcmslam
