#pragma once
// What the page asks and does (docs/LIVE_PAGE.md, "/command"). Requests come in the web server's thread and
// are done in that of whoever calls serve(); questions are answered by a thread of their own.

#include <functional>
#include <map>
#include <mutex>
#include <nlohmann/json.hpp>
#include <vector>

#include "procs/map-server/question_desk.hpp"

namespace lcmslam {

class PageDesk {
 public:
  using Client = std::uint64_t;
  using Reply = std::function<void(std::string)>;
  /// The answer's members. Throws in words for who asked.
  using Action = std::function<nlohmann::json(const nlohmann::json& request, Client who)>;

  /// What can be done, before the first request.
  void offer(const std::string& name, Action action) { actions_[name] = std::move(action); }
  /// How something that takes its time ended; `error` is empty where it was done.
  using Done = std::function<void(const nlohmann::json& members, const std::string& error)>;
  /// Begins what takes its time. Throws in words for who asked.
  using SlowAction = std::function<void(const nlohmann::json& request, const Done& done)>;
  void offer_slow(const std::string& name, SlowAction action) { slow_actions_[name] = std::move(action); }
  /// "query": asked_map() gives what a question looks at, and throws in words for who asked.
  void offer_questions(std::function<AskedMap(const Question&)> asked_map) {
    asked_map_ = std::move(asked_map);
  }
  /// Called for a client that is gone.
  void on_gone(std::function<void(Client)> gone) { on_gone_ = std::move(gone); }
  /// What `about.can` names.
  nlohmann::json can() const;

  // Any thread.
  void take(Client who, const std::string& request, Reply reply);
  void gone(Client who);

  // One thread.
  void serve();

  struct Counts {
    std::int64_t done = 0, refused = 0;
  };
  Counts counts() const { return counts_; }

 private:
  struct Request {
    Client who;
    std::string text;
    Reply reply;
  };
  void serve(const Request& request);
  void end(const nlohmann::json& id, const Reply& reply, const nlohmann::json& members,
           const std::string& error);
  void ask(const nlohmann::json& wanted, const Reply& reply);
  void reply_answers();

  std::map<std::string, Action> actions_;
  std::map<std::string, SlowAction> slow_actions_;
  std::function<AskedMap(const Question&)> asked_map_;
  std::function<void(Client)> on_gone_;
  QuestionDesk questions_{true};
  struct Waiting {
    nlohmann::json id;
    Reply reply;
  };
  std::map<std::int64_t, Waiting> waiting_;  // by request_id
  std::int64_t asked_ = 0;
  Counts counts_;

  std::mutex mutex_;  // guards what follows
  std::vector<Request> requests_;
  std::vector<Client> gone_;
};

/// Members of a request. Throw std::invalid_argument that names the member and what it must be.
double page_number(const nlohmann::json& request, const char* name);
std::string page_text(const nlohmann::json& request, const char* name);

}  // namespace lcmslam
