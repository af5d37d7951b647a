#include "tools/launch/control.hpp"

#include <gmock/gmock.h>

#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>
#include <atomic>
#include <thread>

#include "tests/unit/tools/scratch.hpp"
#include "tools/launch/control_client.hpp"

namespace lcmslam {
namespace {

class Control : public ::testing::Test {
 protected:
  void SetUp() override {
    setenv("XDG_RUNTIME_DIR", scratch_.path().c_str(), 1);
    unsetenv("RUNTIME_DIRECTORY");
  }
  void TearDown() override { unsetenv("XDG_RUNTIME_DIR"); }
  testing::ScratchFolder scratch_;
};

TEST_F(Control, AnswersWhoAsks) {
  ControlSocket socket(control_folder(), "dora");
  std::atomic<bool> stop{false};
  std::thread launch([&] {
    while (!stop) socket.poll([](const std::string& request) { return "you said " + request + "\n"; });
  });
  const auto sockets = running_launches();
  ASSERT_EQ(sockets.size(), 1U);
  EXPECT_EQ(sockets[0].filename().string(), "dora-" + std::to_string(getpid()) + ".sock");
  EXPECT_EQ(ask_launch(sockets[0], "restart icp"), "you said restart icp\n");
  EXPECT_EQ(ask_launch(sockets[0], std::string(1000, 'x')), "you said " + std::string(200, 'x') + "\n")
      << "bounded";
  stop = true;
  launch.join();
}

// Robots' names may begin with one another's.
TEST_F(Control, TheRobotThatIsMeantIsAsked) {
  ControlSocket dora(control_folder(), "dora"), dora_2(control_folder(), "dora-2");
  std::atomic<bool> stop{false};
  std::atomic<int> asked{0}, asked_2{0};
  const auto counting = [](std::atomic<int>& times) {
    return [&times](const std::string& request) {
      if (request == "status") ++times;  // who looks which launches run connects, and asks nothing
      return std::string("fine\n");
    };
  };
  std::thread launches([&] {
    while (!stop) {
      dora.poll(counting(asked));
      dora_2.poll(counting(asked_2));
    }
  });
  EXPECT_EQ(control_launch("status", "dora"), 0);
  EXPECT_EQ(asked, 1);
  EXPECT_EQ(asked_2, 0);
  EXPECT_EQ(control_launch("status", "dora-2"), 0);
  EXPECT_EQ(asked_2, 1);
  EXPECT_EQ(control_launch("status", "dor"), 3);
  stop = true;
  launches.join();
}

TEST_F(Control, IsThisUsersAlone) {
  const ControlSocket socket(control_folder(), "launch");
  struct stat state {};
  ASSERT_EQ(stat((scratch_.path() / "lcmslam").c_str(), &state), 0);
  EXPECT_EQ(state.st_mode & 0777, 0700U);
  const auto path = scratch_.path() / "lcmslam" / ("launch-" + std::to_string(getpid()) + ".sock");
  ASSERT_EQ(stat(path.c_str(), &state), 0);
  EXPECT_EQ(state.st_mode & 0077, 0U);
  chmod((scratch_.path() / "lcmslam").c_str(), 0777);
  EXPECT_THROW(control_folder(), std::runtime_error) << "others may write there";
}

TEST_F(Control, SocketsOfTheDeadAreRemoved) {
  const auto folder = control_folder();
  const pid_t child = fork();
  if (child == 0) {
    new ControlSocket(folder, "dead");  // and never gone by itself
    _exit(0);
  }
  ASSERT_TRUE(testing::wait_for([&] { return !std::filesystem::is_empty(folder); }));
  waitpid(child, nullptr, 0);
  ASSERT_TRUE(testing::wait_for([&] { return running_launches().empty(); }));
  EXPECT_TRUE(std::filesystem::is_empty(folder));
  EXPECT_FALSE(ask_launch(folder / "nobody.sock", "status"));
}

/// Another process's launch that is told to stop, and ends.
pid_t launch_that_ends(const std::filesystem::path& folder, bool cleanly) {
  const pid_t child = fork();
  if (child != 0) return child;
  auto* socket = new ControlSocket(folder, "ends");
  bool asked = false;
  while (!asked)
    socket->poll([&](const std::string& request) {
      asked = request == "stop";
      return "stops\n";
    });
  // Saves its maps until it has been looked for a few times: those who look ask nothing.
  for (int looks = 0; looks < 3;)
    socket->poll([&](const std::string&) {
      ++looks;
      return "";
    });
  if (cleanly) delete socket;
  _exit(0);
}

TEST_F(Control, WhoStopsALaunchWaitsUntilItIsGoneHoweverItEnds) {
  const auto folder = control_folder();
  for (const bool cleanly : {true, false}) {
    const pid_t child = launch_that_ends(folder, cleanly);
    ASSERT_TRUE(testing::wait_for([&] { return running_launches().size() == 1; }));
    EXPECT_EQ(control_launch("stop", ""), cleanly ? 0 : 1);
    EXPECT_TRUE(std::filesystem::is_empty(folder));
    waitpid(child, nullptr, 0);
  }
}

// Who is busy does not come to those who ask.
TEST_F(Control, ALaunchThatHearsNobodyLives) {
  const ControlSocket socket(control_folder(), "busy");
  for (int i = 0; i < 40; ++i) ASSERT_EQ(running_launches().size(), 1U) << i;
}

}  // namespace
}  // namespace lcmslam
