#include <gmock/gmock.h>
#include <fstream>

#include <lcmslam/log/log_writer.hpp>
#include <lcmslam/map_store/file/map_store.hpp>
#include <lcmslam/messages/decode.hpp>
#include <lcmslam/messages/motion_messages.hpp>
#include "tests/support/source_folder.hpp"
#include "tests/unit/map_store_file/sample_store.hpp"
#include "tests/unit/tools/command_run.hpp"
#include "tools/commands.hpp"
#include "tools/page/kept_page.hpp"
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

TEST(KeptPage, NoLineLeadsFromOneSessionToTheNext) {
  const TemporaryFolder folder;
  const std::filesystem::path map = folder / "kitchen.lcmslam";
  {
    MapStore store(map);
    Transaction transaction = store.begin();
    const auto run = store.add_run({"1.2", ""});
    for (const int sender : {7, 8}) {
      SessionChanges dense;
      dense.put_keyframe(some_keyframe(0, 50), std::nullopt);
      for (int i = 1; i < 4; ++i) {
        StoredPose pose;
        pose.utime = 1000 * i;
        pose.T_map_robot = planar_pose(i, sender, 0);
        dense.append_pose(pose);
      }
      store.write(store.add_session(run, session_of("icp", sender)), dense);
    }
    transaction.commit();
  }
  Board board;
  const KeptPage page(map, {"icp-session1", "icp-session2"}, json::array(), board);
  EXPECT_EQ(board.keys("path"), (std::vector<std::string>{"icp/0", "icp/2"}))
      << "the page joins pieces whose numbers follow each other";
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

TEST_F(LogPageTest, ASeekThatTakesMoreThanOneTurnArrives) {
  LogPage page(log_, config_, board_);
  PageDesk desk;
  page.offer(desk);
  play(page, 0.2);
  const Utime begin = headers(board_)["time "]["begin"].get<Utime>();
  const auto now_after = [&](const json& request) {
    EXPECT_EQ(ask(desk, page, request)["ok"], true);
    return headers(board_)["time "]["now"].get<Utime>() - begin;
  };
  int id = 0;
  for (const Utime goal : {3'000'000, 1'500'000}) {  // forward, then back
    const double asked = now_;
    Utime now = now_after({{"id", ++id}, {"do", "play"}, {"at", begin + goal}});
    while (now < goal && now_ < asked + 1) now = now_after({{"id", ++id}, {"do", "play"}});
    EXPECT_GE(now, goal) << "by playing on it would be reached later";
    EXPECT_LT(now, goal + 500'000);
    EXPECT_EQ(headers(board_)["time "]["playing"], true);
  }
}

/// Poses each 0.1 s, the robot 1 m farther each time; of the last stamp `n_last`.
std::string log_of_poses(const TemporaryFolder& folder, int n, int n_last) {
  const std::string file = (folder / "poses.lcmlog").string();
  LogWriter log(file);
  for (int i = 0; i < n; ++i) {
    const Utime utime = 1'000'000 + 100'000 * std::min(i, n - n_last);
    pose_estimate_t m = make_pose_estimate(utime + i, planar_pose(i, 0, 0), Matrix6d::Identity());
    m.seq = i;
    m.sender = 2;
    m.frame = "map";
    m.status = pose_estimate_t::TRACKING;
    log.write(utime, "ICP_POSE", encode_message(m));
  }
  log.close();
  return file;
}

TEST_F(LogPageTest, ShowsAllUpToTheEndStopsThereAndBeginsAgain) {
  const TemporaryFolder folder;
  LogPage page(log_of_poses(folder, 10, 3), config_, board_);
  PageDesk desk;
  page.offer(desk);
  play(page, 2);
  const auto at_end = headers(board_);
  EXPECT_EQ(at_end.at("time ")["now"], at_end.at("time ")["end"]);
  EXPECT_EQ(at_end.at("time ")["playing"], false);
  EXPECT_EQ(at_end.at("poses ")["icp"]["T"][0], 9) << "the last of three with the last stamp";
  EXPECT_EQ(ask(desk, page, {{"id", 1}, {"do", "play"}, {"playing", true}})["ok"], true);
  const auto again = headers(board_);
  EXPECT_EQ(again.at("time ")["playing"], true);
  EXPECT_LT(again.at("time ")["now"], again.at("time ")["end"]);
}

TEST_F(LogPageTest, WhatIsNoLogOrShowsNothingIsNamed) {
  const TemporaryFolder folder;
  std::ofstream(folder / "none.lcmlog") << "no log";
  EXPECT_THROW(LogPage((folder / "none.lcmlog").string(), config_, board_), std::runtime_error);
}

}  // namespace
}  // namespace lcmslam
