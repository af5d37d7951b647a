#include "procs/map-server/page/page_desk.hpp"

#include <fmt/format.h>
#include <sodium.h>
#include <cmath>

namespace lcmslam {
namespace {

using nlohmann::json;

constexpr std::size_t most_requests = 256;  // that wait

std::string base64(const std::string& bytes) {
  std::string text(sodium_base64_encoded_len(bytes.size(), sodium_base64_VARIANT_ORIGINAL), '\0');
  sodium_bin2base64(text.data(), text.size(), reinterpret_cast<const unsigned char*>(bytes.data()),
                    bytes.size(), sodium_base64_VARIANT_ORIGINAL);
  text.pop_back();  // its final zero
  return text;
}

std::string refusal(const json& id, const std::string& why) {
  return json{{"id", id}, {"ok", false}, {"error", why}}.dump(-1, ' ', false, json::error_handler_t::replace);
}

std::string answered(const json& id, json members) {
  members["id"] = id;
  members["ok"] = true;
  return members.dump(-1, ' ', false, json::error_handler_t::replace);
}

json id_of(const json& request) {
  return request.is_object() ? request.value("id", json()) : json();
}

}  // namespace

double page_number(const json& request, const char* name) {
  const auto found = request.find(name);
  if (found == request.end() || !found->is_number() || !std::isfinite(found->get<double>()))
    throw std::invalid_argument(fmt::format("'{}' must be a number", name));
  return found->get<double>();
}

std::string page_text(const json& request, const char* name) {
  const auto found = request.find(name);
  if (found == request.end() || !found->is_string())
    throw std::invalid_argument(fmt::format("'{}' must be a text", name));
  return found->get<std::string>();
}

json PageDesk::can() const {
  json can = json::array();
  if (asked_map_) can.push_back("query");
  for (const auto& action : actions_) can.push_back(action.first);
  for (const auto& action : slow_actions_) can.push_back(action.first);
  return can;
}

void PageDesk::take(Client who, const std::string& request, Reply reply) {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (requests_.size() < most_requests) {
      requests_.push_back({who, request, std::move(reply)});
      return;
    }
  }
  reply(refusal(nullptr, "too many requests wait"));
}

void PageDesk::gone(Client who) {
  const std::lock_guard<std::mutex> lock(mutex_);
  gone_.push_back(who);
}

void PageDesk::serve() {
  std::vector<Request> requests;
  std::vector<Client> gone;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    requests.swap(requests_);
    gone.swap(gone_);
  }
  for (const Request& request : requests) serve(request);
  if (on_gone_)
    for (const Client who : gone) on_gone_(who);
  reply_answers();
}

void PageDesk::serve(const Request& request) {
  json wanted;
  try {
    wanted = json::parse(request.text);
    if (!wanted.is_object()) throw std::invalid_argument("a request is a JSON object");
    const std::string what = page_text(wanted, "do");
    if (what == "query" && asked_map_) return ask(wanted, request.reply);
    if (const auto slow = slow_actions_.find(what); slow != slow_actions_.end())
      return slow->second(
          wanted, [this, id = id_of(wanted), reply = request.reply](
                      const json& members, const std::string& error) { end(id, reply, members, error); });
    const auto action = actions_.find(what);
    if (what != "ping" && action == actions_.end())
      throw std::invalid_argument(fmt::format("'{}' cannot be done here", what));
    end(id_of(wanted), request.reply, what == "ping" ? json::object() : action->second(wanted, request.who),
        "");
  } catch (const std::exception& error) {
    end(id_of(wanted), request.reply, {}, error.what());
  }
}

void PageDesk::end(const json& id, const Reply& reply, const json& members, const std::string& error) {
  ++(error.empty() ? counts_.done : counts_.refused);
  reply(error.empty() ? answered(id, members) : refusal(id, error));
}

void PageDesk::ask(const json& wanted, const Reply& reply) {
  Question question = parse_question(wanted.value("question", json()).dump());
  AskedMap map = asked_map_(question);
  map_request_t asked{};
  asked.request_id = ++asked_;
  if (!questions_.ask({asked, std::move(question), std::move(map)}))
    throw std::runtime_error("too many questions wait for an answer");
  waiting_[asked.request_id] = {id_of(wanted), reply};
}

void PageDesk::reply_answers() {
  for (const QuestionDesk::Answered& answer : questions_.take()) {
    const auto waiting = waiting_.find(answer.request.request_id);
    if (waiting == waiting_.end()) continue;
    const auto& [id, reply] = waiting->second;
    json members;
    if (answer.error.empty()) {
      const auto& [content, bytes] = answer.answer;
      const json told = content == "application/json" ? json::parse(bytes) : json(base64(bytes));
      members = {{"content", content}, {"answer", told}};
    }
    end(id, reply, members, answer.error);
    waiting_.erase(waiting);
  }
}

}  // namespace lcmslam
