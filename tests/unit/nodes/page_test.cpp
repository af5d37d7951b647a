#include <gtest/gtest.h>
#include <chrono>
#include <nlohmann/json.hpp>
#include <thread>

#include <lcmslam/associations_t.hpp>
#include <lcmslam/messages/camera_messages.hpp>
#include <lcmslam/messages/geometry_messages.hpp>
#include <lcmslam/messages/map_messages.hpp>
#include <lcmslam/messages/motion_messages.hpp>
#include <lcmslam/pose_t.hpp>
#include <lcmslam/runtime/confirmation.hpp>
#include <lcmslam/twist_t.hpp>
#include "procs/map-server/page/page_node.hpp"
#include "tests/support/simulated_kitchen.hpp"
#include "tests/support/test_bus.hpp"
#include "tests/support/web_client.hpp"
#include "tests/unit/messages/samples.hpp"
#include "tests/unit/tools/scratch.hpp"

namespace lcmslam {
namespace {

using nlohmann::json;

/// A map server with its page, and a browser.
class LivePage : public ::testing::Test {
 protected:
  LivePage() {
    const std::string text = "folder: " + (scratch_.path() / "maps").string() +
                             "\npage:\n  map_period: 0.1\n  go_to_channel: GOAL\n  drive_channel: TELEOP\n"
                             "  top_speed: 0.5\n  web: {port: 0}\n";
    node_ = &bus_.add<PageNode>(ConfigNode::parse(text), 5);
    const std::string address = node_->address();
    port_ = address.empty() ? 0 : std::stoi(address.substr(address.rfind(':') + 1));
    live_ = std::make_unique<testing::WebClient>(port_);
    command_ = std::make_unique<testing::WebClient>(port_);
    EXPECT_TRUE(live_->open_socket("/live"));
    EXPECT_TRUE(command_->open_socket("/command"));
    live_->patience = command_->patience = 20;
  }

  void keyframe(std::int32_t id, const std::string& frame = "map") {
    DenseKeyframe k = testing::some_keyframe(random_, 500);
    k.id = id;
    for (keyframe_t& tile : make_keyframe_tiles(k, Eigen::Isometry3d::Identity(), id + 1)) {
      tile.seq = seq_++;
      tile.sender = 2;
      tile.frame = frame;
      bus_.deliver("ICP_KEYFRAME", tile);
    }
  }
  void pose(const char* channel, double x, const std::string& frame = "map",
            std::int8_t status = pose_estimate_t::TRACKING) {
    pose_estimate_t m = make_pose_estimate(time_ += 100'000, planar_pose(x, 0, 0), Matrix6d::Identity());
    m.seq = seq_++;
    m.sender = 2;
    m.frame = frame;
    m.status = status;
    bus_.deliver(channel, m);
  }

  /// Headers of what the browser is shown, until `enough` is.
  template <class Enough>
  bool shown(const Enough& enough) {
    const auto until = std::chrono::steady_clock::now() + std::chrono::seconds(10);
    while (std::chrono::steady_clock::now() < until) {
      bus_.work();
      while (const auto message = live_->hear()) {
        bytes_ += message->size();
        live_->say(R"({"got":)" + std::to_string(bytes_) + "}");
        const auto size =
            static_cast<unsigned char>((*message)[0]) | static_cast<unsigned char>((*message)[1]) << 8;
        const json header = json::parse(message->substr(4, static_cast<std::size_t>(size)));
        const std::string name =
            header["channel"].get<std::string>() + " " + header["key"].get<std::string>();
        if (header.contains("gone"))
          board_.erase(name);
        else
          board_[name] = header;
      }
      if (enough()) return true;
    }
    return false;
  }
  bool has(const std::string& name) const { return board_.count(name) > 0; }

  json answer(const json& request) {
    command_->say(request.dump());
    const auto until = std::chrono::steady_clock::now() + std::chrono::seconds(10);
    while (std::chrono::steady_clock::now() < until) {
      bus_.work();
      if (const auto text = command_->hear()) return json::parse(*text);
    }
    return {{"error", "no answer came"}};
  }

  Random random_{1};
  testing::ScratchFolder scratch_;
  testing::TestBus bus_;
  PageNode* node_ = nullptr;
  int port_ = 0;
  std::unique_ptr<testing::WebClient> live_, command_;
  std::map<std::string, json> board_;
  std::size_t bytes_ = 0;
  std::int64_t seq_ = 0;
  Utime time_ = 0;
};

TEST_F(LivePage, ShowsBothMapsAndWhereTheRobotIs) {
  pose("ICP_POSE", 1.5);
  pose("FASTSLAM_POSE", 1.6);
  keyframe(0);
  for (landmarks_t& tile : make_landmark_tiles(1, 1, 0, {testing::some_landmark(random_, 3)}, {})) {
    tile.sender = 2;
    tile.frame = "map";
    bus_.deliver("FASTSLAM_LANDMARKS", tile);
  }
  ASSERT_TRUE(
      shown([&] { return has("points 0/2") && has("poses ") && has("path fastslam/0") && has("health "); }));
  EXPECT_EQ(board_["about "]["source"], "live");
  EXPECT_EQ(board_["poses "]["icp"]["T"][0], 1.5);
  EXPECT_EQ(board_["poses "]["fastslam"]["status"], "TRACKING");
  EXPECT_TRUE(shown([&] {
    return std::any_of(board_.begin(), board_.end(),
                       [](const auto& item) { return item.first.rfind("landmarks", 0) == 0; });
  }));
  keyframe(1);
  EXPECT_TRUE(shown([&] { return has("points 1/0"); }));
}

TEST_F(LivePage, ShowsTheNewestImageOfWhichFastSlamToldSomething) {
  testing::SimulatedKitchen& kitchen = testing::SimulatedKitchen::instance();
  bus_.deliver("CAMERA_CALIBRATION", kitchen.calibration());
  const auto colour_time = [&](int k) { return from_message(kitchen.frame(k)).colour.utime; };
  const auto associations = [&](int k) {
    associations_t m{};
    m.utime = colour_time(k);
    m.sender = 2;
    m.seq = seq_++;
    m.n_associations = 1;
    m.associations.resize(1);
    m.associations[0].landmark = k;
    bus_.deliver("FASTSLAM_ASSOCIATIONS", m);
  };
  bus_.deliver("CAMERA", kitchen.frame(0));
  associations(0);
  associations(1);  // of an image that is lost on the bus
  ASSERT_TRUE(shown([&] { return has("image "); }));
  EXPECT_EQ(board_["image "]["utime"], colour_time(0));
  EXPECT_EQ(board_["image "]["tracks"][0][2], 0);

  bus_.deliver("CAMERA", kitchen.frame(2));
  associations(2);
  ASSERT_TRUE(shown([&] { return board_["image "]["utime"] == colour_time(2); }));
  bus_.deliver("CAMERA", kitchen.frame(20));  // fastslam has ended
  ASSERT_TRUE(shown([&] { return board_["image "]["utime"] == colour_time(20); }));
  EXPECT_TRUE(board_["image "]["tracks"].empty());
  associations(2);
  associations(3);
  bus_.deliver("CAMERA", kitchen.frame(21));
  ASSERT_TRUE(shown([&] { return board_["image "]["utime"] == colour_time(21); }))
      << "not back to the old one";
}

TEST_F(LivePage, ShowsARawPictureAsAJpeg) {
  images_t picture = testing::SimulatedKitchen::instance().frame(3);
  picture.n_images = 1;
  picture.image_types.resize(1);
  picture.images.resize(1);
  image_t& raw = picture.images[0];
  raw.pixelformat = image_t::PIXEL_FORMAT_BGR;
  raw.row_stride = 3 * raw.width;
  raw.data.assign(static_cast<std::size_t>(raw.row_stride * raw.height), 128);
  raw.size = static_cast<std::int32_t>(raw.data.size());
  bus_.deliver("CAMERA", picture);
  ASSERT_TRUE(shown([&] { return has("image "); }));
  EXPECT_EQ(board_["image "]["utime"], raw.utime);
  EXPECT_EQ(board_["image "]["width"], raw.width);
}

TEST_F(LivePage, EveryBrowserIsToldWhichLogIsWritten) {
  if (std::system("command -v lcm-logger > /dev/null") != 0) GTEST_SKIP() << "no lcm-logger on this machine";
  ASSERT_TRUE(shown([&] { return has("log "); }));
  EXPECT_EQ(board_["log "]["on"], false);
  const json begun = answer({{"id", 1}, {"do", "log"}, {"on", true}});
  ASSERT_EQ(begun["ok"], true) << begun;
  board_.clear();
  bytes_ = 0;
  live_ = std::make_unique<testing::WebClient>(port_);  // the page is opened anew
  ASSERT_TRUE(live_->open_socket("/live"));
  ASSERT_TRUE(shown([&] { return has("log ") && board_["log "]["on"] == true; }));
  EXPECT_EQ(board_["log "]["file"], begun["file"]);
  EXPECT_EQ(answer({{"id", 2}, {"do", "log"}, {"on", false}})["ok"], true);
  EXPECT_TRUE(shown([&] { return board_["log "]["on"] == false; }));
}

TEST_F(LivePage, ShowsAPictureThatCameWithoutDepthAndCalibration) {
  images_t picture = testing::SimulatedKitchen::instance().frame(3);
  picture.n_images = 1;
  ASSERT_EQ(picture.image_types[0], images_t::LEFT);
  picture.image_types.resize(1);
  picture.images.resize(1);
  bus_.deliver("CAMERA", picture);
  ASSERT_TRUE(shown([&] { return has("image "); }));
  EXPECT_EQ(board_["image "]["utime"], picture.images[0].utime);
}

TEST_F(LivePage, ANewMapTakesThePlaceOfTheOldOne) {
  pose("ICP_POSE", 0);
  keyframe(0);
  keyframe(1);
  ASSERT_TRUE(shown([&] { return has("points 1/0"); }));
  pose("ICP_POSE", 0, "map-2");
  keyframe(0, "map-2");
  ASSERT_TRUE(shown([&] { return !has("points 1/0") && has("points 0/0"); }));
  EXPECT_EQ(board_["notices "]["notices"][0]["words"], "a new map begins: map-2");
}

TEST_F(LivePage, SaysInWordsWhenAMapperIsLost) {
  pose("ICP_POSE", 0, "map", pose_estimate_t::LOST);
  ASSERT_TRUE(shown([&] { return has("health ") && board_["health "]["level"] == "bad"; }));
  EXPECT_NE(board_["health "]["words"].get<std::string>().find("icp is lost"), std::string::npos);
}

TEST_F(LivePage, SaysThatAPoseIsOldAndThatNothingIsWell) {
  pose("ICP_POSE", 0);
  pose("FASTSLAM_POSE", 0);
  ASSERT_TRUE(shown([&] { return has("poses ") && has("health "); }));
  EXPECT_EQ(board_["health "]["level"], "good");
  ASSERT_TRUE(shown([&] {
    pose("FASTSLAM_POSE", 0.1);
    return board_["poses "]["icp"]["status"] == "SILENT" && board_["health "]["level"] == "bad";
  }));
  EXPECT_EQ(board_["poses "]["fastslam"]["status"], "TRACKING");
  EXPECT_EQ(board_["health "]["words"], "icp tells no position any more");
  pose("ICP_POSE", 0.2);
  EXPECT_TRUE(shown([&] {
    pose("FASTSLAM_POSE", 0.2);
    return board_["poses "]["icp"]["status"] == "TRACKING" && board_["health "]["level"] == "good";
  }));
}

TEST_F(LivePage, DrivesAndStopsOnSilence) {
  EXPECT_EQ(answer({{"id", 1}, {"do", "drive"}, {"linear", 0.5}, {"angular", 0}})["ok"], true);
  ASSERT_EQ(bus_.count("TELEOP"), 1u);
  EXPECT_EQ(bus_.on<twist_t>("TELEOP")[0].linear[0], 0.25);
  const auto begin = std::chrono::steady_clock::now();
  while (bus_.count("TELEOP") < 2 && std::chrono::steady_clock::now() - begin < std::chrono::seconds(5))
    bus_.work();
  ASSERT_EQ(bus_.count("TELEOP"), 2u);
  EXPECT_EQ(bus_.on<twist_t>("TELEOP")[1].linear[0], 0);
  EXPECT_GE(std::chrono::steady_clock::now() - begin, std::chrono::milliseconds(150));
}

TEST_F(LivePage, StopsTheRobotWhenTheDriverIsGone) {
  answer({{"id", 1}, {"do", "drive"}, {"linear", 1}, {"angular", 1}});
  command_.reset();
  const auto begin = std::chrono::steady_clock::now();
  while (bus_.count("TELEOP") < 2 && std::chrono::steady_clock::now() - begin < std::chrono::seconds(5))
    bus_.work();
  ASSERT_EQ(bus_.count("TELEOP"), 2u);
  EXPECT_EQ(bus_.on<twist_t>("TELEOP")[1].angular[2], 0);
}

TEST_F(LivePage, StopsTheRobotWhenTheMapServerEnds) {
  answer({{"id", 1}, {"do", "drive"}, {"linear", 1}, {"angular", 1}});
  ASSERT_EQ(bus_.count("TELEOP"), 1u);
  node_->finish();
  bus_.work();
  ASSERT_EQ(bus_.count("TELEOP"), 2u);
  EXPECT_EQ(bus_.on<twist_t>("TELEOP")[1].linear[0], 0);
}

TEST_F(LivePage, SendsAGoal) {
  const json reply = answer({{"id", "a"}, {"do", "go_to"}, {"x", 1}, {"y", 2}, {"yaw", M_PI / 2}});
  EXPECT_EQ(reply["id"], "a");
  ASSERT_EQ(bus_.count("GOAL"), 1u);
  const pose_t goal = bus_.on<pose_t>("GOAL")[0];
  EXPECT_EQ(goal.pos[1], 2);
  EXPECT_NEAR(goal.orientation[3], std::sqrt(0.5), 1e-12);
}

TEST_F(LivePage, ResetsTheMappersThatAreAlive) {
  EXPECT_EQ(answer({{"id", 1}, {"do", "reset"}})["ok"], false) << "none has told anything";
  pose("ICP_POSE", 0);
  answer({{"id", 1}, {"do", "reset"}});
  const auto commands = bus_.on<command_t>("COMMAND");
  ASSERT_EQ(commands.size(), 1u);
  EXPECT_TRUE(is_confirmed(commands[0], "icp", 2));
}

TEST_F(LivePage, AnswersQuestionsAndRefusesInWords) {
  const json found = answer({{"id", 1}, {"do", "query"}, {"question", {{"ask", "landmarks"}}}});
  EXPECT_EQ(found["answer"]["landmarks"], json::array());
  const json none = answer({{"id", 2}, {"do", "query"}, {"question", {{"ask", "planes"}}}});
  EXPECT_EQ(none["ok"], false);
  EXPECT_EQ(none["error"], "no frame has a place in the map yet");
  for (const char* text : {"garbage", "[]", "{}", R"({"do":"dance"})", R"({"do":"drive","linear":"fast"})",
                           R"({"do":"go_to","x":1})", R"({"do":"export","name":"../../etc"})",
                           R"({"do":"query","question":7})"}) {
    command_->say(text);
    std::optional<std::string> reply;
    for (int i = 0; i < 100 && !reply; ++i) {
      bus_.work();
      reply = command_->hear();
    }
    ASSERT_TRUE(reply) << text;
    EXPECT_EQ(json::parse(*reply)["ok"], false) << *reply;
    EXPECT_NE(json::parse(*reply)["error"], "") << *reply;
  }
  EXPECT_EQ(bus_.count("TELEOP") + bus_.count("GOAL"), 0u);
  EXPECT_EQ(testing::value_of(*node_, "page_commands_refused"), 9);
  EXPECT_EQ(node_->report().refused, 9) << "STATUS tells it soon";
}

TEST_F(LivePage, ExportsAndSaysWhatWasWritten) {
  keyframe(0);
  const json reply = answer({{"id", 7}, {"do", "export"}, {"name", "evening"}});
  EXPECT_EQ(reply["id"], 7);
  EXPECT_EQ(reply["ok"], true) << reply.dump();
  EXPECT_TRUE(std::filesystem::exists(scratch_.path() / "maps/evening/icp_map.ply"));
  EXPECT_EQ(testing::value_of(*node_, "page_commands"), 1);
}

TEST_F(LivePage, CountsForeignSitesAmongWhatWasRefused) {
  testing::WebClient foreign(port_);
  EXPECT_FALSE(foreign.open_socket("/live", "Origin: http://evil.example\r\n"));
  EXPECT_TRUE(testing::wait_for([&] { return node_->report().refused == 1; }));
  EXPECT_EQ(testing::value_of(*node_, "page_refused"), 1);
}

TEST_F(LivePage, MappingGoesOnWhereThePortIsTaken) {
  const std::string text = "folder: " + (scratch_.path() / "other").string() +
                           "\npage: {web: {port: " + std::to_string(port_) + "}}\n";
  testing::TestBus bus;
  const auto& node = bus.add<PageNode>(ConfigNode::parse(text));
  EXPECT_EQ(node.address(), "");
  EXPECT_NE(node.report().detail.find("no live page"), std::string::npos) << node.report().detail;
}

}  // namespace
}  // namespace lcmslam
