// The bridge and a real broker (Debian's mosquitto): a robot's bridge, an operator's bridge, and between them
// what happens to networks. The robot is the test itself, which publishes what mappers do.

#include <gmock/gmock.h>

#include <algorithm>
#include <csignal>
#include <fstream>
#include <set>
#include <thread>

#include <opencv2/core.hpp>

#include <lcmslam/command_t.hpp>
#include <lcmslam/images_t.hpp>
#include <lcmslam/imaging/io/codec.hpp>
#include <lcmslam/keyframe_t.hpp>
#include <lcmslam/landmarks_t.hpp>
#include <lcmslam/messages/camera_messages.hpp>
#include <lcmslam/messages/decode.hpp>
#include <lcmslam/pose_estimate_t.hpp>
#include <lcmslam/runtime/lcm_bus.hpp>
#include "tests/integration/support/bridge_ends.hpp"
#include "tests/integration/support/bus.hpp"
#include "tests/integration/support/environment.hpp"
#include "tests/integration/support/program.hpp"
#include "tests/integration/support/slow_link.hpp"

namespace lcmslam::integration {
namespace {

constexpr double patience = 30;  // s

class Bridge : public testing::Test {
 protected:
  void SetUp() override {
    if (BrokerProgram::find().empty())
      GTEST_SKIP() << "no mosquitto on this machine: apt-get install mosquitto";
    if (!std::filesystem::exists(find_program("lcmslam-bridge")))
      GTEST_SKIP() << "no bridge was built: libmosquitto-dev is not installed";
    operator_.emplace();
    ASSERT_TRUE(wait_until([&] { return operator_->ready_.load(); }, patience));
  }

  std::unique_ptr<Program> bridge(const std::string& name, int port, const std::string& settings) {
    const auto file = folder_ / (name + ".yaml");
    std::ofstream(file) << "bridge:\n  host: 127.0.0.1\n  port: " << port
                        << "\n  robot: dora\n  longest_pause: 1\n"
                        << settings;
    return std::make_unique<Program>(std::vector<std::string>{"lcmslam", "bridge", file});
  }
  std::unique_ptr<Program> robot_bridge(int port, const std::string& more = "") {
    return bridge("robot", port, more + "  receive: [COMMAND]\n");
  }
  /// Hands what comes to the bus as the robot `mirror`'s.
  std::unique_ptr<Program> operator_bridge(int port, const std::string& more = "") {
    setenv("LCMSLAM_ROBOT", "mirror", 1);
    auto program = bridge(
        "operator", port,
        more +
            "  side: operator\n  send: [COMMAND]\n"
            "  receive: [FASTSLAM_POSE, ICP_POSE, ICP_KEYFRAME, FASTSLAM_LANDMARKS, ICP_GRAPH, CAMERA, "
            "STATUS]\n");
    unsetenv("LCMSLAM_ROBOT");
    return program;
  }
  bool connected(const Bus& bus) {
    return bus.wait_for_status(
        "bridge", [](const status_t& s) { return value_of(s, "connected") == 1; }, patience);
  }

  TemporaryFolder folder_;
  Bus bus_;
  Mapper mapper_{bus_};
  std::optional<Operator> operator_;
};

TEST_F(Bridge, ASlowLinkKeepsTheOperatorLiveAndTheRobotUndisturbed) {
  BrokerProgram broker(folder_);
  SlowLink link(broker.port, {});
  const auto far = operator_bridge(broker.port);
  const auto near = robot_bridge(link.port());
  ASSERT_TRUE(connected(bus_)) << near->output();
  ASSERT_TRUE(wait_until(
      [&] {
        mapper_.pose();
        return operator_->newest() > 0;
      },
      patience))
      << near->output() << far->output() << broker.output();

  // What six processes say of themselves, colour and depth 10 times, poses of two mappers 20 times and 2
  // keyframes of 40 kB a second for 20 s, of which the first 3 do not count: more than the link carries.
  constexpr double warm = 3, whole = 20;  // s
  double slowest_publish = 0;             // s
  const Utime first = wall_clock();
  const auto begin = std::chrono::steady_clock::now();
  const auto elapsed = [&] {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  };
  for (int i = 0; i < 20 * static_cast<int>(whole); ++i) {
    const auto before = elapsed();
    mapper_.pose();
    if (i % 10 == 0) mapper_.keyframe();
    if (i % 20 == 0) mapper_.states();
    if (i % 2 == 0) mapper_.picture();
    slowest_publish = std::max(slowest_publish, elapsed() - before);
    std::this_thread::sleep_until(begin + std::chrono::milliseconds(50 * (i + 1)));
  }
  const auto status = bus_.status("bridge");
  const Utime from = first + static_cast<Utime>(warm * 1e6), to = wall_clock();
  const double seconds = 1e-6 * static_cast<double>(to - from);
  ASSERT_TRUE(wait_until(
      [&] {
        mapper_.pose();
        return operator_->newest() > to;
      },
      patience));
  ASSERT_TRUE(status);
  for (const auto& input : status->inputs) {
    EXPECT_EQ(input.lost, 0) << input.channel;
    EXPECT_TRUE(input.queue_drops == 0 || input.channel == "CAMERA")
        << input.channel;  // the newest is enough
  }
  for (const std::string channel : {"FASTSLAM_POSE", "ICP_POSE"}) {
    const auto ages = operator_->ages(channel, from, to);
    ASSERT_FALSE(ages.empty());
    const double rate = static_cast<double>(ages.size()) / seconds;
    const double median = ages[ages.size() / 2], p95 = ages[ages.size() * 95 / 100];
    std::cout << channel << " at " << rate << " Hz, age median " << median << " s, p95 " << p95
              << " s, largest " << ages.back() << " s\n";
    EXPECT_GT(rate, 4.9) << channel;
    EXPECT_LT(median, 0.4) << channel;
    EXPECT_LT(p95, 0.7) << channel << ": does it wait for what the map lost?";
  }
  std::cout << link.forwarded() << " bytes over the link, " << link.lost() << " packets lost, window "
            << value_of(*status, "window") << ", publishing took " << slowest_publish << " s at most\n";
  EXPECT_LT(slowest_publish, 0.05);
  EXPECT_GT(value_of(*status, "kept_waiting"), 0) << "the link was fast enough for all: nothing is shown";

  // What the link could not carry follows when it is calmer.
  EXPECT_TRUE(wait_until([&] { return operator_->keyframes() == mapper_.keyframes; }, 120))
      << operator_->keyframes().size() << " of " << mapper_.keyframes.size();

  // Pictures are behind the map, small, and without depth.
  EXPECT_TRUE(wait_until(
      [&] {
        mapper_.picture();
        return !operator_->pictures().empty();
      },
      patience));
  for (const images_t& picture : operator_->pictures()) {
    std::size_t bytes = 0;
    for (const auto& image : picture.images) {
      bytes += static_cast<std::size_t>(image.size);
      EXPECT_TRUE(image.size == 0 || image.pixelformat == image_t::PIXEL_FORMAT_MJPEG);
    }
    EXPECT_LT(bytes, 25'000U) << "0.1 s of the link";
  }
}

class BridgeAndBroker : public Bridge, public testing::WithParamInterface<const char*> {};

// Also where it comes back with an old state from its disk.
TEST_P(BridgeAndBroker, ABrokerThatDiesAndReturnsLosesNoKeyframe) {
  std::string more = GetParam();
  if (more.find("persistence true") != std::string::npos)
    more += "persistence_location " + folder_.path().string() +
            "/\nautosave_on_changes true\nautosave_interval 20\n";
  BrokerProgram broker(folder_, more);
  const auto far = operator_bridge(broker.port);
  const auto near = robot_bridge(broker.port);
  ASSERT_TRUE(connected(bus_)) << near->output();
  const auto publish = [&](int count) {
    for (int i = 0; i < count; ++i) {
      mapper_.keyframe(1000);
      mapper_.pose();
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
  };
  publish(40);
  ASSERT_TRUE(wait_until([&] { return operator_->keyframes().size() > 20; }, patience))
      << near->output() << far->output();
  for (int deaths = 0; deaths < 2; ++deaths) {
    broker.kill_hard();
    ASSERT_TRUE(bus_.wait_for_status(
        "bridge", [](const status_t& s) { return value_of(s, "connected") == 0; }, patience));
    publish(20);
    broker.start();
    publish(20);
  }
  EXPECT_TRUE(wait_until([&] { return operator_->keyframes() == mapper_.keyframes; }, patience))
      << operator_->keyframes().size() << " of " << mapper_.keyframes.size() << near->output();
  ASSERT_TRUE(bus_.wait_for_status(
      "bridge", [](const status_t& s) { return value_of(s, "kept_waiting") == 0; }, patience));

  // Whoever comes late is told all of it by the broker.
  far->send(SIGINT);
  far->wait(patience);
  operator_.emplace();
  ASSERT_TRUE(wait_until([&] { return operator_->ready_.load(); }, patience));
  const auto late = operator_bridge(broker.port);
  EXPECT_TRUE(wait_until([&] { return operator_->keyframes() == mapper_.keyframes; }, patience))
      << operator_->keyframes().size() << " of " << mapper_.keyframes.size() << late->output();
}

INSTANTIATE_TEST_SUITE_P(States, BridgeAndBroker,
                         testing::Values("allow_anonymous true\n",
                                         "allow_anonymous true\npersistence true\n"));

TEST_F(Bridge, OrdersComeInAndNothingElseDoes) {
  BrokerProgram broker(folder_);
  const auto far = operator_bridge(broker.port);
  const auto near = robot_bridge(broker.port);
  ASSERT_TRUE(connected(bus_)) << near->output();
  // The operator's COMMAND below its robot's name reaches the robot's own channel.
  command_t command{};
  command.name = "smooth";
  const std::size_t before = bus_.count("COMMAND");
  ASSERT_TRUE(wait_until(
      [&] {
        bus_.publish("mirror/COMMAND", command);
        std::this_thread::sleep_for(std::chrono::milliseconds(100));
        const auto newest = bus_.newest<command_t>("COMMAND");
        return bus_.count("COMMAND") > before && newest && newest->name == "smooth";
      },
      patience))
      << near->output() << far->output();
  if (std::filesystem::exists("/usr/bin/mosquitto_pub")) {
    const auto send = [&](const std::string& topic, const std::string& text) {
      EXPECT_EQ(
          run({"/usr/bin/mosquitto_pub", "-p", std::to_string(broker.port), "-t", topic, "-m", text}, 10)
              .exit_code,
          0);
    };
    send("lcmslam/dora/to/COMMAND", "garbage");
    send("lcmslam/dora/to/CAMERA", "garbage");
    EXPECT_TRUE(bus_.wait_for_status(
        "bridge", [](const status_t& s) { return value_of(s, "refused") >= 1; }, patience));
    EXPECT_EQ(bus_.count("CAMERA"), 0U);
  }
  near->send(SIGINT);
  EXPECT_EQ(near->wait(patience).exit_code, 0) << near->output();
}

TEST_F(Bridge, SpeaksEncryptedAndByName) {
  const auto shell = [&](const std::string& script) {
    return run({"/bin/sh", "-c", "cd " + folder_.path().string() + " && " + script}, 60);
  };
  const auto made = shell(
      "openssl req -x509 -newkey rsa:2048 -nodes -days 2 -subj /CN=test -keyout ca.key -out ca.crt && "
      "openssl req -newkey rsa:2048 -nodes -subj /CN=localhost -keyout server.key -out server.csr && "
      "openssl x509 -req -in server.csr -CA ca.crt -CAkey ca.key -CAcreateserial -days 2 -out server.crt && "
      "chmod 644 server.key && touch users && mosquitto_passwd -b users dora secret && chmod 644 users && "
      "printf 'secret\\n' > password && printf 'wrong\\n' > wrong && chmod 600 password wrong && chmod 755 "
      ".");
  if (made.exit_code != 0) GTEST_SKIP() << "no openssl or mosquitto_passwd here: " << made.output;
  const std::string here = folder_.path().string() + "/";
  BrokerProgram broker(folder_, "certfile " + here + "server.crt\nkeyfile " + here +
                                    "server.key\nallow_anonymous false\npassword_file " + here + "users\n");
  const auto with = [&](const std::string& password, const std::string& authority) {
    const auto file = folder_ / "tls.yaml";
    std::ofstream(file) << "bridge:\n  host: localhost\n  port: " << broker.port
                        << "\n  robot: dora\n  user: dora\n  password_file: " << here << password
                        << "\n  tls: {certificates: " << here << authority << "}\n  longest_pause: 1\n";
    return std::make_unique<Program>(std::vector<std::string>{"lcmslam", "bridge", file});
  };
  const auto says = [&](const std::string& words) {
    return bus_.wait_for_status(
        "bridge", [&](const status_t& s) { return s.detail.find(words) != std::string::npos; }, patience);
  };
  {
    const auto wrong = with("wrong", "ca.crt");
    EXPECT_TRUE(says("refuses")) << bus_.status("bridge")->detail;
  }
  {
    const auto stranger = with("password", "server.crt");  // which did not sign it
    EXPECT_TRUE(says("TLS") || says("tls")) << bus_.status("bridge")->detail << broker.output();
  }
  const auto right = with("password", "ca.crt");
  EXPECT_TRUE(connected(bus_)) << right->output() << broker.output();
}

TEST_F(Bridge, NamesTheSubscriptionThatTheBrokerRefuses) {
  std::string plugin;  // other access lists of mosquitto refuse no subscription
  for (const char* folder : {"/usr/lib/x86_64-linux-gnu/", "/usr/lib/aarch64-linux-gnu/", "/usr/lib/"})
    if (const std::string file = std::string(folder) + "mosquitto_dynamic_security.so";
        plugin.empty() && std::filesystem::exists(file))
      plugin = file;
  if (plugin.empty()) GTEST_SKIP() << "this mosquitto has no dynamic security";
  const auto rules = folder_ / "rules.json";
  std::ofstream(rules) << R"({"clients": [], "anonymousGroup": "all",
    "defaultACLAccess": {"publishClientSend": true, "publishClientReceive": true, "subscribe": true},
    "groups": [{"groupname": "all", "roles": [{"rolename": "no orders"}]}],
    "roles": [{"rolename": "no orders", "acls": [{"acltype": "subscribeLiteral", "priority": 1,
               "topic": "lcmslam/dora/to/COMMAND/#", "allow": false}]}]})";
  std::filesystem::permissions(folder_.path(), std::filesystem::perms(0755));  // for the broker's own user
  BrokerProgram broker(folder_, "allow_anonymous true\nplugin " + plugin + "\nplugin_opt_config_file " +
                                    rules.string() + "\n");
  const auto near = robot_bridge(broker.port);
  EXPECT_TRUE(bus_.wait_for_status(
      "bridge",
      [](const status_t& s) {
        return s.detail.find("refuses the subscription to lcmslam/dora/to/COMMAND/#") != std::string::npos &&
               value_of(s, "connected") == 1;
      },
      patience))
      << near->output() << broker.output();
}

TEST_F(Bridge, RefusesToSpeakOpenlyToAnotherMachine) {
  const auto file = folder_ / "open.yaml";
  std::ofstream(file) << "bridge: {host: broker.example}\n";
  const Result result = run({"lcmslam", "bridge", file.string()}, patience);
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_THAT(result.output, testing::HasSubstr("readable and forgeable"));
}

}  // namespace
}  // namespace lcmslam::integration
