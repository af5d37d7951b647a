#include <gmock/gmock.h>
#include <fstream>

#include <lcmslam/map_store/file/map_store.hpp>
#include "tests/support/source_folder.hpp"
#include "tests/unit/map_store_file/sample_store.hpp"
#include "tests/unit/tools/command_run.hpp"
#include "tools/commands.hpp"
#include "tools/page/log_page.hpp"
#include "tools/page/offline_page.hpp"

namespace lcmslam {
namespace {

using nlohmann::json;
using ::testing::HasSubstr;
using ::testing::Not;

/// Headers by channel and key.
std::map<std::string, json> headers(const Board& board) {
  std::map<std::string, json> all;
  for (const Board::Message& message : board.messages()) {
    const auto byte = [&](std::size_t i) {
      return static_cast<std::size_t>(static_cast<unsigned char>((*message)[i]));
    };
    const json header = json::parse(message->substr(4, byte(0) | byte(1) << 8 | byte(2) << 16));
    all[header["channel"].get<std::string>() + " " + header["key"].get<std::string>()] = header;
  }
  return all;
}

std::size_t count(const std::map<std::string, json>& items, const std::string& channel) {
  return static_cast<std::size_t>(std::count_if(
      items.begin(), items.end(), [&](const auto& item) { return item.first.rfind(channel + " ", 0) == 0; }));
}

/// A page of three short files.
class OfflinePage : public ::testing::Test {
 protected:
  OfflinePage() {
    write("index.html", R"(<html><head><link rel="icon" href="icon.svg">
<link rel="stylesheet" href="page.css"></head><body><script src="page.js"></script></body></html>)");
    write("page.css", "p {}");
    write("page.js", "run();");
    board_.put({"points", "1", "{}", std::make_shared<const std::string>("abc"), Haste::bulk, 0, {}});
  }
  void write(const std::string& name, const std::string& text) { std::ofstream(folder_ / name) << text; }

  TemporaryFolder folder_;
  Board board_;
};

TEST_F(OfflinePage, HoldsAllThatItNeeds) {
  const std::string page = offline_page(folder_.path(), board_);
  EXPECT_THAT(page, HasSubstr("<style>p {}</style>"));
  EXPECT_THAT(page, HasSubstr("<script>run();</script>"));
  EXPECT_THAT(page, HasSubstr("id=\"lcmslam-items\">"));
  EXPECT_THAT(page, Not(HasSubstr("src=")));
  EXPECT_THAT(page, Not(HasSubstr("href=")));
  const std::size_t begin = page.find("lcmslam-items\">") + 15;
  EXPECT_EQ((page.find('<', begin) - begin) % 4, 0U) << "base64";
}

TEST_F(OfflinePage, AMissingPartIsNamed) {
  write("index.html", "<html></html>");
  EXPECT_THROW(offline_page(folder_.path(), board_), std::runtime_error);
  std::filesystem::remove(folder_ / "page.css");
  try {
    offline_page(folder_.path(), board_);
    FAIL();
  } catch (const std::runtime_error& error) {
    EXPECT_THAT(error.what(), HasSubstr("index.html"));
  }
}

TEST(ExportCommand, WritesAKeptMapAsOnePage) {
  const TemporaryFolder folder;
  const std::filesystem::path map = folder / "kitchen.lcmslam", html = folder / "kitchen.html";
  {
    MapStore store(map);
    Transaction transaction = store.begin();
    SessionChanges dense;
    for (int id = 0; id < 3; ++id) dense.put_keyframe(some_keyframe(id, 50), std::nullopt);
    store.write(store.add_session(store.add_run({"1.2", ""}), session_of("icp")), dense);
    transaction.commit();
  }
  const auto run = [&](std::vector<std::string> arguments) {
    return testing::run_command({"export", export_command}, std::move(arguments));
  };
  const auto first = run({map, "--html", html});
  ASSERT_EQ(first.exit_code, 0) << first.errors;
  std::ifstream stream(html);
  const std::string page((std::istreambuf_iterator<char>(stream)), {});
  EXPECT_THAT(page, HasSubstr("lcmslam-items"));
  EXPECT_EQ(run({map, "--html", html}).exit_code, 1) << "the file exists";
  EXPECT_THAT(run({map, "--html", html, "--force", "--sessions", "icp-session9"}).errors,
              HasSubstr("icp-session1"));
}

class LogPageTest : public ::testing::Test {
 protected:
  /// So many seconds in steps of 0.1 s.
  void play(LogPage& page, double seconds) {
    for (int i = 0; i < static_cast<int>(10 * seconds + 0.5); ++i) page.play(now_ += 0.1);
  }
  /// Until the log's time, in us from its begin, is reached.
  bool reaches(LogPage& page, Utime time) {
    for (int i = 0; i < 600; ++i) {
      page.play(now_ += 0.1);
      const json told = headers(board_)["time "];
      if (told["now"].get<Utime>() - told["begin"].get<Utime>() >= time) return true;
    }
    return false;
  }
  json ask(PageDesk& desk, LogPage& page, const json& request) {
    json answer;
    desk.take(1, request.dump(), [&](const std::string& text) { answer = json::parse(text); });
    for (int i = 0; i < 100 && answer.is_null(); ++i) {
      desk.serve();
      page.play(now_ += 0.001);
    }
    return answer;
  }

  const std::string log_ = source_folder() / "logs/kitchen.lcmlog";
  const ConfigNode config_ = ConfigNode::load(source_folder() / "config/replay.yaml");
  Board board_;
  double now_ = 100;
};

TEST_F(LogPageTest, MapsALogWithRawDataWhileItPlays) {
  LogPage page(log_, config_, board_);
  PageDesk desk;
  page.offer(desk);
  ASSERT_TRUE(reaches(page, 1'500'000));
  const auto early = headers(board_);
  EXPECT_EQ(early.at("about ")["source"], "log");
  EXPECT_GT(count(early, "points"), 0U);
  EXPECT_EQ(early.at("poses ")["icp"]["status"], "TRACKING");
  ASSERT_TRUE(reaches(page, 3'500'000));
  EXPECT_GT(count(headers(board_), "landmarks"), 0U);

  // Back: the map is again as it was then.
  const Utime begin = early.at("time ")["begin"].get<Utime>();
  EXPECT_EQ(ask(desk, page, {{"id", 1}, {"do", "play"}, {"playing", false}})["ok"], true);
  play(page, 5);
  EXPECT_NE(headers(board_).at("poses ")["icp"]["status"], "SILENT")
      << "it stands because somebody stopped it";
  EXPECT_EQ(ask(desk, page, {{"id", 2}, {"do", "play"}, {"at", begin + 200'000}})["ok"], true);
  EXPECT_LT(headers(board_)["time "]["now"].get<Utime>(), begin + 1'000'000);
  EXPECT_EQ(ask(desk, page, {{"id", 3}, {"do", "play"}, {"speed", 1e6}})["ok"], false);
}

TEST_F(LogPageTest, WhatIsNoLogOrShowsNothingIsNamed) {
  const TemporaryFolder folder;
  std::ofstream(folder / "none.lcmlog") << "no log";
  EXPECT_THROW(LogPage((folder / "none.lcmlog").string(), config_, board_), std::runtime_error);
}

}  // namespace
}  // namespace lcmslam
