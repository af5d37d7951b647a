#include <lcmslam/bridge/outbox.hpp>

#include <algorithm>

namespace lcmslam::bridge {
namespace {

constexpr std::size_t most_senders = 64;   // of a channel
constexpr std::size_t most_in_a_row = 64;  // of a sender on a channel without a rate
constexpr std::size_t overhead = 64;       // bytes that a message takes beside its own
constexpr std::size_t small = 1'500;       // bytes: a pose, which makes no queue

std::chrono::steady_clock::duration seconds(double s) {
  return std::chrono::duration_cast<std::chrono::steady_clock::duration>(std::chrono::duration<double>(s));
}

}  // namespace

Outbox::Outbox(const std::vector<ChannelRule>& rules, const OutboxLimits& limits)
    : limits_(limits),
      window_(limits.delay),
      bucket_(limits.bandwidth, std::max(8'000.0, limits.bandwidth / 4)) {
  for (const ChannelRule& rule : rules) {
    index_[rule.channel] = channels_.size();
    channels_.push_back({rule, {}, {}, 0, {}});
  }
}

void Outbox::put(const std::string& channel, std::int64_t sender, Bytes bytes, Time now) {
  const std::lock_guard<std::mutex> lock(mutex_);
  const auto found = index_.find(channel);
  if (found == index_.end()) return;
  Channel& to = channels_[found->second];
  Slot& slot = slot_of(to, sender, now);
  slot.beside = slot.beside && bytes.size() + overhead <= small;
  slot.waiting.push_back({channel, std::make_shared<const Bytes>(std::move(bytes)), now});
  if (slot.waiting.size() > (to.rule.rate > 0 ? 1 : most_in_a_row)) {
    slot.waiting.pop_front();
    ++counts_.replaced;
  }
}

void Outbox::put(const std::string& channel, std::int64_t sender, std::vector<Piece> pieces, Time now) {
  const std::lock_guard<std::mutex> lock(mutex_);
  const auto found = index_.find(channel);
  if (found == index_.end()) return;
  Slot& slot = slot_of(channels_[found->second], sender, now);
  slot.beside = false;
  slot.waiting.clear();
  for (Piece& piece : pieces)
    slot.waiting.push_back({piece.name, std::make_shared<const Bytes>(std::move(piece.bytes)), now});
}

/// In the place of a process that is no more, where there are many.
Outbox::Slot& Outbox::slot_of(Channel& channel, std::int64_t sender, Time now) {
  auto& slots = channel.slots;
  if (slots.count(sender) == 0 && slots.size() >= most_senders)
    slots.erase(std::min_element(slots.begin(), slots.end(),
                                 [](const auto& a, const auto& b) { return a.second.last < b.second.last; }));
  const auto [place, fresh] = slots.try_emplace(sender);
  Slot& slot = place->second;
  if (fresh) slot.beside = channel.rule.rate > 0;
  slot.last = now;
  return slot;
}

void Outbox::keep(const std::string& channel, const std::string& group, std::vector<Piece> pieces,
                  std::int64_t version) {
  const std::lock_guard<std::mutex> lock(mutex_);
  const auto found = index_.find(channel);
  if (found == index_.end()) return;
  const std::string whole_group = channel + "/" + group;
  std::set<std::string> former = groups_[whole_group];
  for (const Piece& piece : pieces) former.erase(piece.name);
  // With the newest numbers: what is no more goes before what comes instead of it.
  for (const std::string& name : former) pieces.push_back({name, {}});
  for (Piece& piece : pieces)
    if (!piece.bytes.empty() || !is_cleared(piece.name))
      keep_one(found->second, whole_group, piece.name, std::move(piece.bytes));
  versions_[whole_group] = version;
  make_room();
}

bool Outbox::holds(const std::string& channel, const std::string& group, std::int64_t version) const {
  const std::lock_guard<std::mutex> lock(mutex_);
  const auto found = versions_.find(channel + "/" + group);
  return version != 0 && found != versions_.end() && found->second == version;
}

void Outbox::forget(const std::string& channel, const std::string& groups) {
  const std::lock_guard<std::mutex> lock(mutex_);
  const auto found = index_.find(channel);
  if (found == index_.end()) return;
  const std::string begin = channel + "/" + groups;
  for (auto group = groups_.lower_bound(begin); group != groups_.end(); ++group) {
    if (group->first.compare(0, begin.size(), begin) != 0) break;
    versions_.erase(group->first);
    for (const std::string& name : group->second)
      if (!kept_.at(name).bytes->empty()) keep_one(found->second, group->first, name, {});
  }
}

/// The broker has been told that nothing is kept under that name.
bool Outbox::is_cleared(const std::string& name) const {
  const auto found = kept_.find(name);
  return found != kept_.end() && found->second.stored && found->second.bytes->empty();
}

/// With a new number: it is newer than all others.
void Outbox::keep_one(std::size_t channel, const std::string& group, const std::string& name, Bytes bytes) {
  const auto known = kept_.find(name);
  if (known != kept_.end()) {
    if (!known->second.stored && !known->second.bytes->empty()) ++counts_.replaced;
    drop(known->second);
  }
  Kept& kept = kept_[name];
  kept = {channel, ++last_number_, group, std::make_shared<const Bytes>(std::move(bytes)), false, {}};
  counts_.kept_bytes += kept.bytes->size() + overhead;
  channels_[channel].waiting[kept.number] = name;
  unstored_.insert(kept.number);
  groups_[group].insert(name);
}

/// The broker lets go of what it has kept for `kept_for`, and shall only when this robot is silent.
void Outbox::renew(Time now) {
  while (!stored_.empty()) {
    const std::string name = stored_.begin()->second;
    const Kept kept = kept_.at(name);
    if (now - kept.stored_at < seconds(limits_.kept_for / 2)) return;
    keep_one(kept.channel, kept.group, name, *kept.bytes);
  }
}

/// From all tables but kept_ and groups_.
void Outbox::drop(const Kept& kept) {
  counts_.kept_bytes -= kept.bytes->size() + overhead;
  channels_[kept.channel].waiting.erase(kept.number);
  unstored_.erase(kept.number);
  stored_.erase(kept.number);
}

/// What the broker has goes first, then the oldest that it has not.
void Outbox::make_room() {
  while (counts_.kept_bytes > limits_.memory && kept_.size() > 1) {
    std::string name;
    if (!stored_.empty()) {
      name = stored_.begin()->second;
      evicted_up_to_ = std::max(evicted_up_to_, stored_.begin()->first);
    } else {
      const auto oldest = std::min_element(kept_.begin(), kept_.end(), [](const auto& a, const auto& b) {
        return a.second.number < b.second.number;
      });
      name = oldest->first;
      lacks_ = true;
    }
    const auto found = kept_.find(name);
    drop(found->second);
    groups_[found->second.group].erase(name);
    versions_.erase(found->second.group);
    kept_.erase(found);
    ++counts_.evicted;
  }
}

bool Outbox::wants(const std::string& channel, Time now) const {
  const std::lock_guard<std::mutex> lock(mutex_);
  const auto found = index_.find(channel);
  if (found == index_.end() || !connected_ || !decided_) return false;
  const Channel& c = channels_[found->second];
  const bool waits = std::any_of(c.slots.begin(), c.slots.end(), [&](const auto& slot) {
    return !slot.second.waiting.empty() || slot.second.due > now;
  });
  return !waits && c.waiting.empty() && c.under_way == 0;
}

void Outbox::connected() {
  const std::lock_guard<std::mutex> lock(mutex_);
  connected_ = true;
  decided_ = false;
  ++connections_;
  window_.reset();
  forget_measurements();
}

/// An order that the robot got half a minute late would be obeyed then.
void Outbox::forget_measurements() {
  for (Channel& channel : channels_)
    for (auto& [sender, slot] : channel.slots) slot.waiting.clear();
}

/// What was under way may have arrived or not. Measurements are out of date by now.
void Outbox::disconnected() {
  const std::lock_guard<std::mutex> lock(mutex_);
  connected_ = decided_ = false;
  for (const auto& [ticket, message] : under_way_) {
    const auto found = kept_.find(message.name);
    if (!message.name.empty() && found != kept_.end() && found->second.number == message.number)
      channels_[found->second.channel].waiting[message.number] = message.name;
  }
  under_way_.clear();
  beside_ = 0;
  window_.reset();
  for (Channel& channel : channels_) channel.under_way = 0;
  forget_measurements();
}

bool Outbox::is_connected() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return connected_;
}

std::int64_t Outbox::connections() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return connections_;
}

void Outbox::broker_keeps(std::uint64_t mark) {
  const std::lock_guard<std::mutex> lock(mutex_);
  decided_ = true;
  for (auto stored = stored_.upper_bound(mark); stored != stored_.end(); stored = stored_.erase(stored)) {
    Kept& kept = kept_.at(stored->second);
    kept.stored = false;
    unstored_.insert(kept.number);
    channels_[kept.channel].waiting[kept.number] = stored->second;
    ++counts_.again;
  }
  if (evicted_up_to_ > mark) {
    lacks_ = true;
    evicted_up_to_ = 0;
  }
}

std::uint64_t Outbox::mark() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return unstored_.empty() ? last_number_ : *unstored_.begin() - 1;
}

bool Outbox::lacks() {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (!connected_ || !decided_ || !lacks_) return false;
  lacks_ = false;
  return true;
}

bool Outbox::affords(std::size_t bytes, Time now) {
  return bucket_.has(static_cast<double>(bytes + overhead), now);
}

std::optional<Outgoing> Outbox::next(Time now) {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (!connected_) return std::nullopt;
  renew(now);
  if (auto out = next_beside(now)) return out;
  std::size_t least = channels_.size();
  for (std::size_t i = 0; i < channels_.size(); ++i) {
    const bool waits =
        due_slot(channels_[i], false, now) != nullptr || (decided_ && !channels_[i].waiting.empty());
    if (waits && (least == channels_.size() || served(i) < served(least))) least = i;
  }
  if (least == channels_.size()) return std::nullopt;
  Channel& channel = channels_[least];
  Slot* slot = due_slot(channel, false, now);
  const std::uint64_t number = slot == nullptr ? next_kept(channel) : 0;
  const std::size_t bytes = slot != nullptr ? slot->waiting.front().bytes->size()
                                            : kept_.at(channel.waiting.at(number)).bytes->size();
  if (!affords(bytes, now) || !window_.admits(bytes + overhead)) return std::nullopt;
  shared_ = served(least);
  channel.served = shared_ + bytes + overhead;
  return slot != nullptr ? send_measurement(least, *slot, now) : send_kept(least, number, now);
}

/// What is small and goes at a rate.
std::optional<Outgoing> Outbox::next_beside(Time now) {
  if (beside_ >= LinkWindow::most_messages) return std::nullopt;
  for (std::size_t i = 0; i < channels_.size(); ++i) {
    Slot* slot = due_slot(channels_[i], true, now);
    if (slot == nullptr) continue;
    if (!affords(slot->waiting.front().bytes->size(), now)) return std::nullopt;
    return send_measurement(i, *slot, now);
  }
  return std::nullopt;
}

Outbox::Slot* Outbox::due_slot(Channel& channel, bool beside, Time now) {
  for (auto& [sender, slot] : channel.slots)
    if (slot.beside == beside && !slot.waiting.empty() && slot.due <= now) return &slot;
  return nullptr;
}

/// Who did not wait for a while has no claim to what others had meanwhile.
std::uint64_t Outbox::served(std::size_t channel) const {
  return std::max(channels_[channel].served, shared_);
}

Outgoing Outbox::send_measurement(std::size_t channel, Slot& slot, Time now) {
  const double wait = period(channels_[channel]);
  const Measurement measurement = slot.waiting.front();
  slot.waiting.pop_front();
  const Outgoing out{++last_ticket_, measurement.name, measurement.bytes,      false,
                     slot.beside,    slot.sent++,      std::max(1.0, 2 * wait)};
  under_way_[out.ticket] = {channel, out.bytes->size() + overhead, {}, 0, measurement.put, now, slot.beside};
  if (slot.waiting.empty()) {
    const bool in_time = now - slot.due < seconds(wait);  // a little late: on average at its rate
    slot.due = (in_time ? slot.due : now) + seconds(wait);
  }
  ++channels_[channel].under_way;
  if (slot.beside)
    ++beside_;
  else
    window_.sent(out.bytes->size() + overhead);
  bucket_.take(static_cast<double>(out.bytes->size() + overhead), now);
  ++counts_.sent;
  return out;
}

/// Of what was begun, else of the newest.
std::uint64_t Outbox::next_kept(const Channel& channel) const {
  std::uint64_t newest = 0;
  if (const auto begun = groups_.find(channel.begun); begun != groups_.end())
    for (const std::string& name : begun->second) {
      const std::uint64_t number = kept_.at(name).number;
      if (channel.waiting.count(number) > 0) newest = std::max(newest, number);
    }
  return newest > 0 ? newest : channel.waiting.rbegin()->first;
}

Outgoing Outbox::send_kept(std::size_t channel, std::uint64_t number, Time now) {
  auto& waiting = channels_[channel].waiting;
  const std::string name = waiting.at(number);
  waiting.erase(number);
  const std::set<std::string>& group = groups_.at(kept_.at(name).group);
  const bool more = std::any_of(group.begin(), group.end(), [&](const std::string& other) {
    return waiting.count(kept_.at(other).number) > 0;
  });
  channels_[channel].begun = more ? kept_.at(name).group : "";
  const Kept& kept = kept_.at(name);
  const Outgoing out{++last_ticket_, name, kept.bytes, true, false, 0, limits_.kept_for};
  under_way_[out.ticket] = {channel, kept.bytes->size() + overhead, name, kept.number, now, now};
  ++channels_[channel].under_way;
  window_.sent(kept.bytes->size() + overhead);
  bucket_.take(static_cast<double>(kept.bytes->size() + overhead), now);
  ++counts_.sent;
  return out;
}

void Outbox::acknowledged(std::uint64_t ticket, Time now) {
  const std::lock_guard<std::mutex> lock(mutex_);
  const auto found = under_way_.find(ticket);
  if (found == under_way_.end()) return;  // of a connection that is no more
  const UnderWay message = found->second;
  under_way_.erase(found);
  ++counts_.acknowledged;
  if (message.beside)
    --beside_;
  else
    window_.acknowledged(message.bytes, message.sent, now);
  --channels_[message.channel].under_way;
  if (message.name.empty()) {
    counts_.age = std::max(counts_.age, std::chrono::duration<double>(now - message.put).count());
    return;
  }
  const auto kept = kept_.find(message.name);
  if (kept == kept_.end() || kept->second.number != message.number) return;  // replaced meanwhile
  kept->second.stored = true;
  kept->second.stored_at = now;
  unstored_.erase(message.number);
  stored_[message.number] = message.name;
}

bool Outbox::idle() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return under_way_.empty() && unstored_.empty();
}

OutboxCounts Outbox::counts() {
  const std::lock_guard<std::mutex> lock(mutex_);
  OutboxCounts counts = counts_;
  counts.kept = kept_.size();
  counts.waiting = unstored_.size();
  counts.window = window_.window();
  counts_.age = 0;
  return counts;
}

}  // namespace lcmslam::bridge
