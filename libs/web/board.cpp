#include <lcmslam/web/board.hpp>

#include <algorithm>

namespace lcmslam {
namespace {

constexpr std::size_t most_gone = 20'000;

}  // namespace

void Board::put(BoardItem item) {
  Entry entry;
  entry.message = encode_message(item.channel, item.key, item.header,
                                 item.payload ? std::string_view(*item.payload) : std::string_view());
  entry.name = {std::move(item.channel), std::move(item.key)};
  entry.haste = item.haste;
  entry.urgency = item.urgency;
  entry.place = item.place;
  const std::lock_guard<std::mutex> lock(mutex_);
  const auto known = entries_.find(entry.name);
  if (known != entries_.end() && *known->second->message == *entry.message) return;
  change(std::move(entry));
}

void Board::remove(const std::string& channel, const std::string& key) {
  const std::lock_guard<std::mutex> lock(mutex_);
  const auto known = entries_.find({channel, key});
  if (known == entries_.end() || known->second->gone) return;
  Entry entry = *known->second;
  entry.gone = true;
  entry.message = encode_message(channel, key, R"({"gone":true})", "");
  change(std::move(entry));
}

void Board::remove(const std::string& channel) {
  for (const std::string& key : keys(channel)) remove(channel, key);
}

void Board::change(Entry entry) {
  entry.version = ++version_;
  EntryPointer& place = entries_[entry.name];
  if (place) {
    gone_.erase(place->version);
    by_version_.erase(place->version);
  }
  if (entry.gone) gone_.insert(version_);
  place = std::make_shared<const Entry>(std::move(entry));
  by_version_[version_] = place;
  forget_old();
}

void Board::forget_old() {
  while (gone_.size() > most_gone) {
    const auto oldest = by_version_.find(*gone_.begin());
    entries_.erase(oldest->second->name);
    by_version_.erase(oldest);
    gone_.erase(gone_.begin());
  }
}

std::vector<std::string> Board::keys(const std::string& channel) const {
  const std::lock_guard<std::mutex> lock(mutex_);
  std::vector<std::string> keys;
  for (auto entry = entries_.lower_bound({channel, ""});
       entry != entries_.end() && entry->first.first == channel; ++entry)
    if (!entry->second->gone) keys.push_back(entry->first.second);
  return keys;
}

std::vector<Board::Message> Board::messages() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  std::vector<EntryPointer> entries;
  for (const auto& entry : entries_)
    if (!entry.second->gone) entries.push_back(entry.second);
  std::stable_sort(entries.begin(), entries.end(),
                   [](const auto& a, const auto& b) { return a->urgency < b->urgency; });
  std::vector<Message> messages;
  messages.reserve(entries.size());
  for (const EntryPointer& entry : entries) messages.push_back(entry->message);
  return messages;
}

std::vector<Board::EntryPointer> Board::changed(std::int64_t version) const {
  const std::lock_guard<std::mutex> lock(mutex_);
  std::vector<EntryPointer> changed;
  for (auto entry = by_version_.upper_bound(version); entry != by_version_.end(); ++entry)
    changed.push_back(entry->second);
  return changed;
}

std::int64_t Board::version() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return version_;
}

}  // namespace lcmslam
