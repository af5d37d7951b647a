#include <lcmslam/live_page/show_on_board.hpp>

#include <map>
#include <set>

namespace lcmslam {
namespace {

struct Way {
  Haste haste;
  int urgency;
};

/// What is small and tells most comes first; of points the coarse ones.
Way way_of(const PageItem& item) {
  static const std::map<std::string, Way> ways = {
      {"about", {Haste::live, 0}},    {"time", {Haste::live, 1}},      {"poses", {Haste::live, 2}},
      {"health", {Haste::live, 3}},   {"notices", {Haste::live, 4}},   {"report", {Haste::live, 5}},
      {"sessions", {Haste::live, 6}}, {"log", {Haste::live, 7}},       {"image", {Haste::picture, 0}},
      {"graph", {Haste::bulk, 0}},    {"particles", {Haste::bulk, 1}}, {"path", {Haste::bulk, 2}},
      {"grid", {Haste::bulk, 3}},     {"planes", {Haste::bulk, 4}},    {"objects", {Haste::bulk, 5}}};
  const auto way = ways.find(item.channel);
  if (way != ways.end()) return way->second;
  return {Haste::bulk, item.channel == "points" && item.header.value("level", 0) == 0 ? 6 : 7};
}

}  // namespace

void show_on(Board& board, PageItem item) {
  BoardItem shown;
  const Way way = way_of(item);
  shown.haste = way.haste;
  shown.urgency = way.urgency;
  shown.channel = std::move(item.channel);
  shown.key = std::move(item.key);
  shown.header = item.header.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
  shown.payload = std::make_shared<const std::string>(std::move(item.bytes));
  if (item.place) shown.place = {item.place->x(), item.place->y(), item.place->z()};
  board.put(std::move(shown));
}

void show_all_on(Board& board, const std::string& channel, std::vector<PageItem> items) {
  std::set<std::string> keys;
  for (PageItem& item : items) {
    keys.insert(item.key);
    show_on(board, std::move(item));
  }
  for (const std::string& key : board.keys(channel))
    if (keys.count(key) == 0) board.remove(channel, key);
}

}  // namespace lcmslam
