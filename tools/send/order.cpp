#include "tools/send/order.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <algorithm>
#include <stdexcept>

#include <lcmslam/messages/print_message.hpp>
#include <lcmslam/runtime/confirmation.hpp>
#include <lcmslam/runtime/options.hpp>

namespace lcmslam {
namespace {

double value(const status_t& status, const std::string& name) {
  for (const value_t& v : status.values)
    if (v.name == name) return v.value;
  return 0;
}

std::int64_t sent_on(const status_t& status, const std::string& channel) {
  for (const output_status_t& output : status.outputs)
    if (output.channel == channel) return output.sent;
  return 0;
}

bool contains(const std::vector<std::string>& names, const std::string& name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

bool is_leaving(const status_t& status) {
  return status.state == status_t::STOPPING;
}

/// What a process says of itself, to be put behind a sentence.
std::string in_its_words(const status_t& status) {
  return status.detail.empty() ? "" : ": " + printable(status.detail);
}

}  // namespace

const std::vector<OrderWord>& order_words() {
  static const std::vector<OrderWord> words = {
      {"save", {"map-server"}, "write the maps into the run's folder now"},
      {"smooth", {"fastslam"}, "smooth the path so far and send it as FASTSLAM_SMOOTHED"},
      {"reset", {"fastslam", "icp"}, "begin new maps beside those that there are"},
      {"stop", process_names(), "finish what is under way, save, and end"},
      {"export", {"map-server"}, "write the maps into a folder below the run's"}};
  return words;
}

Order::Order(const std::string& word, const std::vector<std::string>& to, std::int64_t sender)
    : to_(to), sender_(sender) {
  const auto found = std::find_if(order_words().begin(), order_words().end(),
                                  [&](const OrderWord& w) { return w.name == word; });
  if (found == order_words().end())
    throw std::invalid_argument(fmt::format("there is no order '{}'", printable(word)));
  word_ = &*found;
  for (const std::string& process : to)
    if (!contains(word_->processes, process))
      throw std::invalid_argument(fmt::format("{} does nothing at '{}'; {} does", printable(process), word,
                                              fmt::join(word_->processes, ", ")));
  processes_ = to.empty() ? word_->processes : to;
}

void Order::hear(const status_t& status) {
  if (!sent_) {
    if (is_leaving(status))
      members_.erase(status.sender);
    else
      members_[status.sender] = {status.process, contains(processes_, status.process), status, status, {}};
    return;
  }
  const auto found = members_.find(status.sender);
  if (found == members_.end() || !found->second.asked || found->second.answer) return;
  found->second.now = status;
  found->second.answer = judge(found->second);
}

void Order::hear(const map_reply_t& reply) {
  if (!sent_ || !is_request() || reply.request_id != sender_) return;
  const auto found = members_.find(reply.sender);
  if (found == members_.end() || found->second.answer) return;
  const bool done = reply.status == 0;
  found->second.answer = Answer{found->second.process, done, (done ? "wrote\n" : "") + reply.message};
}

bool Order::complete() const {
  return std::all_of(processes_.begin(), processes_.end(), [&](const std::string& process) {
    return std::any_of(members_.begin(), members_.end(),
                       [&](const auto& m) { return m.second.process == process; });
  });
}

std::string Order::nobody() const {
  std::vector<std::string> there;
  for (const auto& [sender, member] : members_) {
    if (member.asked) return "";
    there.push_back(printable(member.process));
  }
  if (there.empty()) return "no process sends STATUS";
  return fmt::format("{} is not there; there are {}", fmt::join(processes_, ", "), fmt::join(there, ", "));
}

// Who is not meant by an order must not count it as one that was wrongly confirmed: all that hear it are
// confirmed, or it goes to one alone.
command_t Order::command(const std::string& target) const {
  command_t command;
  command.utime = 0;
  command.target = target;
  command.name = word_->name;
  if (needs_confirmation(command))
    for (const auto& [sender, member] : members_)
      if (target.empty() || member.process == target) {
        command.keys.push_back(member.process);
        command.values.push_back(std::to_string(sender));
      }
  command.n = static_cast<std::int32_t>(command.keys.size());
  return command;
}

bool Order::is_to_all() const {
  return processes_.size() > 1 && to_.empty();
}

bool Order::concerns_all() const {
  command_t command;
  command.name = word_->name;
  return is_to_all() && needs_confirmation(command);
}

std::vector<command_t> Order::commands() const {
  if (is_to_all()) return {command("")};
  std::vector<command_t> all;
  for (const std::string& process : processes_) all.push_back(command(process));
  return all;
}

map_request_t Order::request(const std::string& folder, const std::string& formats) const {
  map_request_t request;
  request.utime = 0;
  request.request_id = sender_;
  request.kind = map_request_t::EXPORT;
  request.argument = folder;
  request.format = formats;
  request.n_numbers = 0;
  return request;
}

void Order::sent() {
  sent_ = true;
}

/// A STATUS counts what its process received from each sender: ours stands there once it was heard.
bool Order::heard(const status_t& status) const {
  return std::any_of(status.inputs.begin(), status.inputs.end(), [&](const input_status_t& input) {
    return input.sender == sender_ && input.received > 0 &&
           input.channel == (is_request() ? "MAP_REQUEST" : "COMMAND");
  });
}

std::optional<Order::Answer> Order::judge(const Member& m) const {
  const auto answer = [&](bool good, const std::string& text) { return Answer{m.process, good, text}; };
  if (!heard(m.now) || is_request()) return std::nullopt;
  if (value(m.now, "commands_refused") > value(m.before, "commands_refused"))
    return answer(false, "refused it");
  if (word_->name == "stop") {
    if (m.now.state == status_t::FAILED) return answer(false, "stops, and has failed" + in_its_words(m.now));
    if (is_leaving(m.now)) return answer(true, "stops");
  } else if (word_->name == "reset") {
    return answer(true, "begins a new map");
  } else if (word_->name == "smooth") {
    const std::int64_t poses = sent_on(m.now, "FASTSLAM_SMOOTHED") - sent_on(m.before, "FASTSLAM_SMOOTHED");
    if (poses > 0) return answer(true, fmt::format("sent a smoothed path of {} poses", poses));
  } else if (word_->name == "save") {
    const bool has_map = value(m.now, "landmarks") > 0 || value(m.now, "keyframes") > 0;
    if (value(m.now, "saved") > value(m.before, "saved")) return answer(true, "the maps are saved");
    if (value(m.now, "unsaved") == 0 && has_map)
      return answer(true, "nothing has changed since the maps were saved last");
    if (value(m.now, "unsaved") == 0) return answer(false, "has no map yet: nothing is saved");
  }
  return std::nullopt;
}

bool Order::all_answered() const {
  return std::all_of(members_.begin(), members_.end(),
                     [](const auto& m) { return !m.second.asked || m.second.answer.has_value(); });
}

std::vector<Order::Answer> Order::answers(double seconds) const {
  std::vector<Answer> all;
  for (const auto& [sender, m] : members_) {
    if (!m.asked) continue;
    const std::string outcome =
        heard(m.now) ? "has heard it, but nothing came of it" + in_its_words(m.now) : "does not answer";
    all.push_back(m.answer.value_or(Answer{m.process, false, fmt::format("{} ({} s)", outcome, seconds)}));
  }
  for (const std::string& process : to_) {
    const bool there =
        std::any_of(all.begin(), all.end(), [&](const Answer& a) { return a.process == process; });
    if (!there) all.push_back({process, false, "is not there"});
  }
  return all;
}

}  // namespace lcmslam
