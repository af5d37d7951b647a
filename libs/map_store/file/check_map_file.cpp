#include <lcmslam/map_store/file/check_map_file.hpp>

#include <functional>
#include <set>

#include <lcmslam/map_store/file/map_file.hpp>

namespace lcmslam {
namespace {

class Checker {
 public:
  explicit Checker(const std::filesystem::path& file) : file_(file) {}

  MapFileCheck run() {
    check_pages();
    check_references();
    for (const StoredSession& session : sessions()) check_session(session.id);
    attempt([&] { file_.calibrations(); });
    attempt([&] { file_.cameras(); });
    return result_;
  }

 private:
  void add(const std::string& fault) {
    if (result_.faults.size() < MapFileCheck::most_faults) result_.faults.push_back(fault);
  }

  /// What cannot be read is a fault, and the rest is looked at all the same.
  void attempt(const std::function<void()>& read) {
    try {
      read();
    } catch (const std::exception& error) {
      add(error.what());
    }
  }

  void check_pages() {
    attempt([&] {
      Statement rows(file_.database(), "PRAGMA integrity_check(20)");
      while (rows.step())
        if (rows.text(0) != "ok") add("SQLite: " + rows.text(0));
    });
  }

  void check_references() {
    attempt([&] {
      Statement rows(file_.database(), "PRAGMA foreign_key_check");
      while (rows.step())
        add("a row of " + rows.text(0) + " refers to a " + rows.text(2) + " that is not there");
    });
  }

  std::vector<StoredSession> sessions() {
    std::vector<StoredSession> sessions;
    attempt([&] { sessions = file_.sessions(); });
    result_.sessions = static_cast<std::int64_t>(sessions.size());
    return sessions;
  }

  void check_session(std::int64_t session) {
    std::set<std::int32_t> ids;
    attempt([&] {
      for (const StoredKeyframe& keyframe : file_.keyframes(session)) ids.insert(keyframe.id);
    });
    result_.keyframes += static_cast<std::int64_t>(ids.size());
    for (const std::int32_t id : ids) {
      attempt([&] { result_.clouds += file_.cloud(session, id).has_value(); });
      attempt([&] { result_.features += file_.features(session, id).has_value(); });
      attempt([&] { result_.images += file_.images(session, id).has_value(); });
    }
    attempt([&] {
      for (const StoredEdge& edge : file_.edges(session)) {
        ++result_.edges;
        result_.loose_edges += ids.count(edge.from) == 0 || ids.count(edge.to) == 0;
      }
    });
    attempt([&] { result_.landmarks += static_cast<std::int64_t>(file_.landmarks(session).size()); });
    attempt([&] { result_.poses += static_cast<std::int64_t>(file_.trajectory(session).size()); });
  }

  MapFile file_;
  MapFileCheck result_;
};

}  // namespace

MapFileCheck check_map_file(const std::filesystem::path& file) {
  return Checker(file).run();
}

}  // namespace lcmslam
