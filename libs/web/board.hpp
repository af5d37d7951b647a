#pragma once
// What clients are shown: items by channel and key, each only as it is now. Who is slow misses what was in
// between, never what is.

#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include <lcmslam/web/message.hpp>

namespace lcmslam {

/// How a link that cannot take everything is shared.
enum class Haste {
  live,     ///< small and soon worthless: goes before all else
  picture,  ///< one under way at a time
  bulk      ///< what the link has left
};

struct BoardItem {
  std::string channel, key;
  std::string header;  ///< a JSON object, without channel and key
  std::shared_ptr<const std::string> payload = nullptr;
  Haste haste = Haste::bulk;
  int urgency = 0;                                 ///< the lower goes first
  std::optional<std::array<float, 3>> place = {};  ///< of bulk: what is near goes first
};

/// Any thread may call it.
class Board {
 public:
  using Message = WebMessage;
  using Name = std::pair<std::string, std::string>;  ///< channel and key

  struct Entry {
    Name name;
    std::int64_t version = 0;  ///< counts the board's changes
    bool gone = false;         ///< then the message says so
    Message message;
    Haste haste = Haste::bulk;
    int urgency = 0;
    std::optional<std::array<float, 3>> place;
  };
  using EntryPointer = std::shared_ptr<const Entry>;

  /// Takes the place of the item of the same name; one that says the same changes nothing.
  void put(BoardItem item);
  void remove(const std::string& channel, const std::string& key);
  /// All of the channel.
  void remove(const std::string& channel);

  std::vector<std::string> keys(const std::string& channel) const;
  /// Of all items, the urgent ones first.
  std::vector<Message> messages() const;

  /// What has changed after that version, in this order; also what is gone, as far as that is among the last
  /// 20,000: who looks many times a second misses none.
  std::vector<EntryPointer> changed(std::int64_t version) const;
  std::int64_t version() const;

 private:
  void change(Entry entry);
  void forget_old();

  mutable std::mutex mutex_;
  std::int64_t version_ = 0;
  std::map<Name, EntryPointer> entries_;
  std::map<std::int64_t, EntryPointer> by_version_;
  std::set<std::int64_t> gone_;  // versions
};

}  // namespace lcmslam
