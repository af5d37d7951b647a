#include <lcmslam/web/client_queue.hpp>

#include <algorithm>
#include <limits>

namespace lcmslam {
namespace {

constexpr double bulk_delay = 0.25;      // s that bulk may wait in line before it arrives
constexpr double bulk_line = 0.1;        // s, as far as the rate tells: so it does not come in bursts
constexpr double live_delay = 0.8;       // s of anything
constexpr double part_time = 0.05;       // s that a part keeps the link
constexpr double smallest_part = 8'000;  // bytes
constexpr int last = 1000;               // urgency

}  // namespace

const std::set<std::string>& ClientQueue::optional_channels() {
  static const std::set<std::string> channels = {"points",    "mesh", "landmarks", "image",
                                                 "particles", "grid", "planes",    "objects"};
  return channels;
}

void ClientQueue::eye(const std::array<float, 3>& place) {
  if (place == eye_) return;
  eye_ = place;
  std::map<Rank, Board::EntryPointer> waiting;
  for (auto& entry : waiting_) {
    const Rank rank = this->rank(*entry.second);
    places_[entry.second->name] = rank;
    waiting[rank] = std::move(entry.second);
  }
  waiting_ = std::move(waiting);
}

void ClientQueue::want(const std::set<std::string>& channels) {
  unwanted_.clear();
  for (const std::string& channel : optional_channels())
    if (channels.count(channel) == 0) unwanted_.insert(channel);
  waiting_.clear();
  places_.clear();
  for (auto name = first_.begin(); name != first_.end();)
    name = is_wanted(name->first) ? std::next(name) : first_.erase(name);
  for (auto begun = begun_.begin(); begun != begun_.end();)
    begun = is_wanted(begun->second.entry->name.first) ? std::next(begun) : begun_.erase(begun);
  seen_ = 0;  // what was left out may be wanted now
}

ClientQueue::Rank ClientQueue::rank(const Board::Entry& entry) const {
  if (entry.gone) return {Haste::live, last, 0.0F, entry.version};
  float distance = 0;
  if (entry.place)
    for (std::size_t i = 0; i < 3; ++i)
      distance += ((*entry.place)[i] - eye_[i]) * ((*entry.place)[i] - eye_[i]);
  return {entry.haste, entry.urgency, distance, entry.version};
}

/// Takes over what has changed on the board.
void ClientQueue::look() {
  if (seen_ == board_.version()) return;
  for (const Board::EntryPointer& entry : board_.changed(seen_)) {
    enqueue(entry);
    seen_ = std::max(seen_, entry->version);
  }
  if (has_looked_) return;
  has_looked_ = true;
  for (const auto& place : places_) first_.insert(place.first);
}

void ClientQueue::enqueue(const Board::EntryPointer& entry) {
  if (entry->gone) first_.erase(entry->name);
  const auto place = places_.find(entry->name);
  if (place != places_.end()) {
    waiting_.erase(place->second);
    places_.erase(place);
  }
  const auto begun = begun_.find(entry->haste);
  if (begun != begun_.end() && begun->second.entry->name == entry->name) {
    if (begun->second.entry->version == entry->version) return;
    if (entry->gone) begun_.erase(begun);  // what only changed is sent to its end: else it might never be
  }
  const auto sent = sent_.find(entry->name);
  if (sent != sent_.end() && sent->second.version >= entry->version) return;
  if (entry->gone ? sent == sent_.end() : !is_wanted(entry->name.first)) return;
  const Rank rank = this->rank(*entry);
  places_[entry->name] = rank;
  waiting_[rank] = entry;
}

bool ClientQueue::may_go(Haste haste, double now) {
  const auto under_way = static_cast<double>(link_.under_way());
  if (haste == Haste::live) return under_way < link_.window(live_delay);
  if (link_.is_probing(now)) return false;
  if (haste == Haste::picture && begun_.count(haste) == 0 && picture_end_ > sent_bytes_ - link_.under_way())
    return false;
  return under_way < link_.window(bulk_delay) && link_.line(now) < bulk_line;
}

/// Whether it went out just now, as it was: what changes faster than the link takes it (the graph of a large
/// map) leaves as many bytes to the rest as it has.
bool ClientQueue::rests(const Board::Entry& entry) const {
  const auto sent = sent_.find(entry.name);
  return !entry.gone && entry.haste == Haste::bulk && sent != sent_.end() &&
         bulk_bytes_ - sent->second.end < entry.message->size();
}

Board::EntryPointer ClientQueue::take_first(Haste haste) {
  const auto first = waiting_.lower_bound({haste, std::numeric_limits<int>::min(), 0.0F, 0});
  const auto is_there = [&](auto place) {
    return place != waiting_.end() && std::get<Haste>(place->first) == haste;
  };
  if (!is_there(first)) return nullptr;
  auto chosen = first;
  while (is_there(chosen) && rests(*chosen->second)) ++chosen;
  if (!is_there(chosen)) chosen = first;
  const Board::EntryPointer entry = chosen->second;
  places_.erase(entry->name);
  waiting_.erase(chosen);
  return entry;
}

/// The next message of that haste, or the next part of the one that is begun.
Board::Message ClientQueue::advance(Haste haste, double now) {
  const auto known = begun_.find(haste);
  Begun begun = known != begun_.end() ? known->second : Begun{take_first(haste)};
  if (!begun.entry) return nullptr;
  const Board::Entry& entry = *begun.entry;
  Board::Message message = entry.message;
  const std::size_t whole = message->size();
  const auto part = static_cast<std::size_t>(std::max(smallest_part, part_time * link_.rate()));
  if (parts_ && haste != Haste::live && (begun.at > 0 || whole > part)) {
    message = encode_part(haste == Haste::picture ? "picture" : "bulk", *message, begun.at, part);
    begun.at += part;
  } else {
    begun.at = whole;
  }
  count(*message, now);
  if (haste == Haste::bulk) bulk_bytes_ += message->size();
  if (haste == Haste::picture) picture_end_ = sent_bytes_;
  if (begun.at < whole) {
    begun_[haste] = begun;
    return message;
  }
  begun_.erase(haste);
  first_.erase(entry.name);
  if (entry.gone)
    sent_.erase(entry.name);
  else
    sent_[entry.name] = {entry.version, bulk_bytes_};
  return message;
}

void ClientQueue::count(const std::string& message, double now) {
  link_.sent(message.size(), now);
  sent_bytes_ += message.size();
}

Board::Message ClientQueue::whole(double now) {
  if (is_told_whole_ || !has_looked_ || !first_.empty()) return nullptr;
  is_told_whole_ = true;
  Board::Message message = encode_message("whole", "", "{}", "");
  count(*message, now);
  return message;
}

Board::Message ClientQueue::next(double now) {
  look();
  for (const Haste haste : {Haste::live, Haste::picture, Haste::bulk})
    if (may_go(haste, now))
      if (Board::Message message = advance(haste, now)) return message;
  return nullptr;
}

}  // namespace lcmslam
