#include "tools/launch/supervisor.hpp"

#include <gmock/gmock.h>

#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <csignal>

#include "tests/support/full_disk.hpp"
#include "tests/unit/tools/scratch.hpp"
#include "tools/launch/log_files.hpp"

namespace lcmslam {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::StartsWith;
using testing::wait_for;

class SupervisorTest : public ::testing::Test {
 protected:
  ProcessSpec shell(const std::string& script, bool restart = false) {
    return {"worker", {"/bin/sh", "-c", script}, scratch_.path() / "worker.txt", restart};
  }
  std::string output() const { return scratch_.read("worker.txt"); }

  /// Polls until this many things happened.
  std::vector<std::string> events(Supervisor& supervisor, std::size_t count) {
    std::vector<std::string> all;
    EXPECT_TRUE(wait_for([&] {
      for (auto& event : supervisor.poll()) all.push_back(event);
      return all.size() >= count;
    }));
    return all;
  }

  testing::ScratchFolder scratch_;
};

TEST_F(SupervisorTest, ReportsTheExitStatusAndKeepsTheOutput) {
  Supervisor supervisor;
  supervisor.start(shell("echo to stdout; echo to stderr >&2; exit 3"));
  EXPECT_THAT(events(supervisor, 1), ElementsAre("worker ended: exit 3"));
  EXPECT_EQ(supervisor.processes()[0].last_exit, "exit 3");
  EXPECT_EQ(supervisor.processes()[0].pid, 0);
  EXPECT_EQ(output(), "to stdout\nto stderr\n");
  EXPECT_THAT(supervisor.poll(), IsEmpty());  // and is not started again
}

TEST_F(SupervisorTest, ReportsTheSignalThatEndedAProcess) {
  Supervisor supervisor;
  supervisor.start(shell("kill -SEGV $$"));
  EXPECT_THAT(events(supervisor, 1),
              ElementsAre(AllOf(HasSubstr("signal 11"), HasSubstr("Segmentation fault"))));
}

TEST_F(SupervisorTest, OutputOfEveryStartIsAppended) {
  scratch_.write("worker.txt", "before\n");
  Supervisor supervisor;
  supervisor.start(shell("echo after"));
  events(supervisor, 1);
  EXPECT_EQ(output(), "before\nafter\n");
}

TEST_F(SupervisorTest, ProgramThatCannotBeStartedIsAnErrorThatNamesIt) {
  Supervisor supervisor;
  ProcessSpec spec = shell("");
  spec.arguments = {"/no/such/program"};
  try {
    supervisor.start(spec);
    FAIL() << "it was started";
  } catch (const std::runtime_error& error) {
    EXPECT_THAT(error.what(), AllOf(HasSubstr("/no/such/program"), HasSubstr("No such file")));
  }
  spec = shell("true");
  spec.log = scratch_.path() / "no-such-folder" / "log.txt";
  EXPECT_THROW(Supervisor().start(spec), std::runtime_error);
}

TEST_F(SupervisorTest, ProcessIsToldThatItIsNotTheFirst) {
  ProcessSpec spec = shell("echo \"start $*\"; exit 1", true);
  spec.arguments.emplace_back("worker");  // $0
  spec.on_restart = "--set=worker.map_frame=map-restart-";
  Supervisor supervisor;
  supervisor.start(spec);
  EXPECT_TRUE(wait_for([&] {
    supervisor.poll();
    return output().find("restart-1") != std::string::npos;
  }));
  EXPECT_THAT(output(), ::testing::StartsWith("start \nstart --set=worker.map_frame=map-restart-1\n"));
}

// Who is killed once is back at once, who is killed again soon after; who fails each time waits longer and
// longer.
TEST_F(SupervisorTest, RestartsWithGrowingPauses) {
  Supervisor supervisor;
  const auto begin = Supervisor::Clock::now();
  supervisor.start(shell("exit 1", true));
  const auto happened = events(supervisor, 9);
  EXPECT_THAT(happened, ElementsAre("worker ended: exit 1, restarts at once", "worker restarted",
                                    "worker ended: exit 1, restarts in 0.2 s", "worker restarted",
                                    "worker ended: exit 1, restarts in 0.4 s", "worker restarted",
                                    "worker ended: exit 1, restarts in 0.8 s", "worker restarted",
                                    "worker ended: exit 1, restarts in 1.6 s"));
  EXPECT_GE(Supervisor::Clock::now() - begin, std::chrono::milliseconds(1400));
  EXPECT_EQ(supervisor.processes()[0].starts, 5);
}

TEST_F(SupervisorTest, WhoRanLongComesBackAtOnceAndBeginsANewRow) {
  Supervisor supervisor;
  const std::string runs = (scratch_.path() / "runs").string();
  // The third run is a long one.
  ProcessSpec spec =
      shell("echo >> " + runs + "; test $(wc -l < " + runs + ") = 3 && sleep 0.6; exit 1", true);
  spec.long_run = std::chrono::milliseconds(500);
  supervisor.start(spec);
  EXPECT_THAT(events(supervisor, 7),
              ElementsAre("worker ended: exit 1, restarts at once", "worker restarted",
                          "worker ended: exit 1, restarts in 0.2 s", "worker restarted",
                          "worker ended: exit 1, restarts at once", "worker restarted",
                          "worker ended: exit 1, restarts in 0.2 s"));
}

TEST_F(SupervisorTest, WrongConfigurationIsNotTriedAgain) {
  Supervisor supervisor;
  supervisor.start(shell("echo 'surf: unknown key'; exit 2", true));
  EXPECT_THAT(events(supervisor, 1), ElementsAre("worker ended: exit 2: surf: unknown key"));
  EXPECT_TRUE(supervisor.refused());
  EXPECT_THAT(supervisor.poll(), IsEmpty());
}

TEST_F(SupervisorTest, WhoRanBeforeComesBackWhenItIsRefusedSomething) {
  Supervisor supervisor;
  const std::string runs = (scratch_.path() / "runs").string();
  // The second run finds a file that is being edited.
  supervisor.start(shell("echo >> " + runs + "; test $(wc -l < " + runs +
                             ") = 2 && echo 'icp: unknown key' && exit 2; echo ready; exec sleep 1000",
                         true));
  ASSERT_TRUE(wait_for([&] { return output() == "ready\n"; }));
  supervisor.note_ready("worker");
  EXPECT_EQ(supervisor.restart("worker"), "");
  EXPECT_THAT(events(supervisor, 4),
              ElementsAre(HasSubstr("worker ended: signal 2"), "worker restarted",
                          "worker ended: exit 2, restarts at once: icp: unknown key", "worker restarted"));
  EXPECT_FALSE(supervisor.refused());
}

TEST_F(SupervisorTest, WhatCannotBeStartedNowIsTriedAgainAndTheOthersGoOn) {
  Supervisor supervisor;
  ProcessSpec spec = shell("rm -r " + (scratch_.path() / "logs").string() + "; exit 1", true);
  spec.log = scratch_.path() / "logs" / "worker.txt";
  std::filesystem::create_directories(spec.log.parent_path());
  supervisor.start(spec);
  EXPECT_THAT(events(supervisor, 2),
              ElementsAre("worker ended: exit 1, restarts at once",
                          AllOf(HasSubstr("worker cannot be started: "),
                                HasSubstr("worker.txt: No such file"), HasSubstr(", restarts in 0.2 s"))));
  std::filesystem::create_directories(spec.log.parent_path());
  EXPECT_THAT(events(supervisor, 1), ElementsAre("worker restarted"));
}

TEST_F(SupervisorTest, StopsWithInterruptAlone) {
  Supervisor supervisor;
  supervisor.start(shell("trap 'echo bye; exit 0' INT; echo ready; while :; do sleep 0.02; done", true));
  ASSERT_TRUE(wait_for([&] { return output() == "ready\n"; }));
  EXPECT_THAT(supervisor.stop(), IsEmpty());
  EXPECT_EQ(supervisor.processes()[0].last_exit, "exit 0");
  EXPECT_EQ(output(), "ready\nbye\n");
}

TEST_F(SupervisorTest, StopInsistsUntilTheKernelEndsTheProcess) {
  Supervisor supervisor;
  supervisor.start(shell("trap '' INT TERM; echo ready; while :; do sleep 0.02; done", true));
  ASSERT_TRUE(wait_for([&] { return output() == "ready\n"; }));
  EXPECT_THAT(supervisor.stop(std::chrono::seconds(1)),
              ElementsAre("worker did not stop within 2 s and was killed: what it had not yet told is lost"));
  EXPECT_EQ(supervisor.processes()[0].pid, 0);
  EXPECT_THAT(supervisor.processes()[0].last_exit, HasSubstr("signal 9"));
}

TEST_F(SupervisorTest, AProcessThatFailsAtItsEndIsTheCauseWithItsLastWords) {
  Supervisor supervisor;
  supervisor.start(shell(
      "trap 'echo \"[now] [w] [error] no space\"; exit 1' INT; echo ready; while :; do sleep 0.02; done"));
  ASSERT_TRUE(wait_for([&] { return output() == "ready\n"; }));
  EXPECT_THAT(supervisor.stop(), ElementsAre("worker failed: exit 1: no space"));
  EXPECT_THAT(supervisor.stop(), IsEmpty()) << "told once";
}

// Ctrl-C reaches a graph that only just starts: nothing is lost, nothing failed.
TEST_F(SupervisorTest, WhoIsToldToStopBeforeItListensHasStoppedAsAsked) {
  Supervisor supervisor;
  supervisor.start(shell("echo ready; exec sleep 1000"));
  ProcessSpec crashing = shell("trap 'kill -SEGV $$' INT; echo ready; while :; do sleep 0.02; done");
  crashing.name = "crashing";
  crashing.log = scratch_.path() / "crashing.txt";
  supervisor.start(crashing);
  ASSERT_TRUE(wait_for([&] { return output() == "ready\n" && scratch_.read("crashing.txt") == "ready\n"; }));
  EXPECT_THAT(supervisor.stop(), ElementsAre(StartsWith("crashing failed: signal 11")));
  EXPECT_THAT(supervisor.processes()[0].last_exit, HasSubstr("signal 2"));
}

TEST_F(SupervisorTest, AProcessThatDiedBeforeTheStopIsACauseToo) {
  Supervisor supervisor;
  supervisor.start(shell("echo 'its last words'; exit 3"));
  events(supervisor, 1);
  EXPECT_THAT(supervisor.stop(), ElementsAre("worker was not running any more: exit 3: its last words"));
}

TEST_F(SupervisorTest, AProcessThatStoppedAsAskedDoesNotComeBack) {
  Supervisor supervisor;
  supervisor.start(shell("exit 0", true));
  EXPECT_FALSE(supervisor.all_stopped());
  EXPECT_THAT(events(supervisor, 1), ElementsAre("worker ended: exit 0"));
  EXPECT_TRUE(supervisor.all_stopped());
  EXPECT_THAT(supervisor.stop(), IsEmpty());
}

TEST_F(SupervisorTest, WhoLetsTheStopWaitIsNamedMeanwhile) {
  Supervisor supervisor;
  supervisor.start(shell("trap '' INT TERM; echo ready; while :; do sleep 0.02; done", true));
  ASSERT_TRUE(wait_for([&] { return output() == "ready\n"; }));
  std::vector<std::string> told;
  supervisor.stop(std::chrono::seconds(3), [&](const std::string& text) { told.push_back(text); });
  ASSERT_GE(told.size(), 2U);
  EXPECT_EQ(told[0], "waits for worker");
  EXPECT_EQ(told[1], "worker has not stopped for 3 s and is told again");
}

TEST_F(SupervisorTest, ItsEndStopsWhatItStarted) {
  pid_t pid = 0;
  {
    Supervisor supervisor;
    supervisor.start(shell("echo ready; exec sleep 1000"));
    ASSERT_TRUE(wait_for([&] { return output() == "ready\n"; }));
    pid = supervisor.processes()[0].pid;
    EXPECT_EQ(kill(pid, 0), 0);
  }
  EXPECT_EQ(kill(pid, 0), -1);
  EXPECT_EQ(errno, ESRCH);
}

TEST_F(SupervisorTest, NoProcessOutlivesASupervisorThatIsKilled) {
  ASSERT_EQ(prctl(PR_SET_CHILD_SUBREAPER, 1), 0);  // orphans become ours, so that their end is seen
  const pid_t supervising = fork();
  ASSERT_GE(supervising, 0);
  if (supervising == 0) {
    Supervisor supervisor;
    supervisor.start(shell("echo $$; exec sleep 1000"));
    while (true) pause();
  }
  ASSERT_TRUE(wait_for([&] { return !output().empty() && output().back() == '\n'; }));
  const pid_t worker = std::stoi(output());
  EXPECT_EQ(kill(worker, 0), 0);
  kill(supervising, SIGKILL);
  int status = 0;
  EXPECT_EQ(waitpid(supervising, &status, 0), supervising);
  EXPECT_TRUE(wait_for([&] { return waitpid(worker, &status, WNOHANG) == worker; })) << "the worker lives on";
  EXPECT_TRUE(WIFSIGNALED(status));
  EXPECT_EQ(WTERMSIG(status), SIGTERM);
}

TEST_F(SupervisorTest, StartsWhenThoseThatItNeedsAreReady) {
  ProcessSpec second = shell("echo second; exec sleep 1000");
  second.name = "second";
  second.log = scratch_.path() / "second.txt";
  second.after = {"worker", "on-another-host"};
  Supervisor supervisor;
  supervisor.start(second);
  supervisor.start(shell("echo first; exec sleep 1000"));
  EXPECT_TRUE(supervisor.processes()[0].waits);
  supervisor.note_ready("worker");
  EXPECT_THAT(supervisor.poll(), IsEmpty());
  EXPECT_THAT(supervisor.lacking(supervisor.processes()[0]), ElementsAre("on-another-host"));
  EXPECT_EQ(supervisor.processes()[0].pid, 0);
  EXPECT_FALSE(supervisor.all_stopped());
  supervisor.note_ready("on-another-host");
  EXPECT_THAT(supervisor.poll(), ElementsAre("second starts"));
  EXPECT_TRUE(wait_for([&] { return scratch_.read("second.txt") == "second\n"; }));
}

TEST_F(SupervisorTest, WhatWaitsWhenAllStopsIsNoProblem) {
  ProcessSpec waiting = shell("true");
  waiting.after = {"nobody"};
  Supervisor supervisor;
  supervisor.start(waiting);
  EXPECT_THAT(supervisor.stop(), IsEmpty());
  EXPECT_TRUE(supervisor.all_stopped());
}

TEST_F(SupervisorTest, GivesUpAfterTooManyRestartsInARow) {
  ProcessSpec spec = shell("echo 'no camera'; exit 1", true);
  spec.restart_limit = 1;
  Supervisor supervisor;
  supervisor.start(spec);
  EXPECT_THAT(events(supervisor, 3),
              ElementsAre("worker ended: exit 1, restarts at once", "worker restarted",
                          "worker ended: exit 1, stays away after 1 restarts in a row: no camera"));
  EXPECT_TRUE(supervisor.all_stopped());
  EXPECT_THAT(supervisor.stop(), ElementsAre("worker was not running any more: exit 1: no camera"));
}

TEST_F(SupervisorTest, RestartsWhatItIsAskedToAndWhatItHadGivenUp) {
  Supervisor supervisor;
  supervisor.start(shell("trap 'echo bye; exit 0' INT; echo ready; while :; do sleep 0.02; done", true));
  ASSERT_TRUE(wait_for([&] { return output() == "ready\n"; }));
  EXPECT_EQ(supervisor.restart("worker"), "");
  EXPECT_EQ(supervisor.restart("nobody"), "'nobody' is none of the processes here: worker");
  EXPECT_THAT(events(supervisor, 2), ElementsAre("worker ended: exit 0", "worker restarted"));
  EXPECT_TRUE(wait_for([&] { return output() == "ready\nbye\nready\n"; }));

  ProcessSpec once = shell("exit 1", true);
  once.name = "once";
  once.log = scratch_.path() / "once.txt";
  once.restart = false;
  supervisor.start(once);
  events(supervisor, 1);
  EXPECT_EQ(supervisor.restart("once"), "");
  EXPECT_EQ(supervisor.processes()[1].starts, 2);
}

TEST_F(SupervisorTest, WhatCannotStartNowIsNotSaidToStartAgain) {
  Supervisor supervisor;
  ProcessSpec waiting = shell("exec sleep 1000");
  waiting.after = {"surf", "camera"};
  supervisor.start(waiting);
  EXPECT_EQ(supervisor.restart("worker"), "worker waits for surf camera");
  EXPECT_EQ(supervisor.processes()[0].starts, 0);

  ProcessSpec ended = shell("exit 0");
  ended.name = "ended";
  ended.log = scratch_.path() / "logs" / "ended.txt";
  std::filesystem::create_directories(ended.log.parent_path());
  supervisor.start(ended);
  events(supervisor, 1);
  std::filesystem::remove_all(ended.log.parent_path());
  EXPECT_THAT(supervisor.restart("ended"),
              AllOf(StartsWith("ended cannot be started: "), HasSubstr("No such file")));
}

TEST_F(SupervisorTest, GivesAProcessItsLimitsAndItsEnvironment) {
  ProcessSpec spec = shell(
      "nice; ulimit -d; grep Cpus_allowed_list /proc/self/status | tr -d '[:alpha:]_:[:blank:]'; echo "
      "$GREETING $HOME");
  spec.limits.nice = 7;
  spec.limits.memory = 300'000'000;
  spec.limits.cpus = {0};
  spec.environment = {"GREETING=hello", "HOME=/nowhere"};
  Supervisor supervisor;
  supervisor.start(spec);
  events(supervisor, 1);
  const int before = getpriority(PRIO_PROCESS, 0);
  EXPECT_EQ(output(), std::to_string(std::max(7, std::min(before, 19))) + "\n292968\n0\nhello /nowhere\n");
}

TEST_F(SupervisorTest, LimitsThatTheMachineRefusesAreWrongConfiguration) {
  ProcessSpec spec = shell("true", true);
  spec.limits.cpus = {1000};
  Supervisor supervisor;
  supervisor.start(spec);
  EXPECT_THAT(events(supervisor, 1),
              ElementsAre("worker ended: exit 2: cpus: the machine has none of these cores"));
  EXPECT_TRUE(supervisor.refused());
}

TEST_F(SupervisorTest, LogsBeginAnewAndTheOldOnesAreKept) {
  ProcessSpec spec = shell("for i in $(seq 1000); do echo line $i; done; exec sleep 1000");
  spec.log_bytes = 1000;
  spec.log_files = 2;
  Supervisor supervisor;
  supervisor.start(spec);
  ASSERT_TRUE(wait_for([&] { return output().find("line 1000\n") != std::string::npos; }));
  ASSERT_TRUE(wait_for([&] {
    supervisor.poll();
    return output().empty();
  }));
  EXPECT_THAT(scratch_.read("worker.1.txt"), HasSubstr("line 1\nline 2\n"));
  EXPECT_THAT(scratch_.read("worker.1.txt"), HasSubstr("line 1000\n"));
  EXPECT_EQ(last_words(spec.log), "line 1000");
  scratch_.write("worker.txt", std::string(2000, 'x'));
  EXPECT_TRUE(rotate_log(spec.log, 1000, 2));
  EXPECT_EQ(scratch_.read("worker.1.txt"), std::string(2000, 'x'));
  EXPECT_FALSE(std::filesystem::exists(scratch_.path() / "worker.2.txt"));
  EXPECT_FALSE(rotate_log(spec.log, 0, 2));
}

TEST_F(SupervisorTest, LogsThatADiskHasNoRoomForStayAsTheyAre) {
  const std::string log(100'000, 'x'), older(10, 'o'), oldest(10, 'p');
  scratch_.write("worker.txt", log);
  scratch_.write("worker.1.txt", older);
  scratch_.write("worker.2.txt", oldest);
  {
    const testing::FullDisk full(60'000);
    EXPECT_FALSE(rotate_log(scratch_.path() / "worker.txt", 1000, 4));
    EXPECT_FALSE(rotate_log(scratch_.path() / "worker.txt", 1000, 4));
  }
  EXPECT_EQ(scratch_.read("worker.txt"), log);
  EXPECT_EQ(scratch_.read("worker.1.txt"), older);
  EXPECT_EQ(scratch_.read("worker.2.txt"), oldest);
  EXPECT_FALSE(std::filesystem::exists(scratch_.path() / "worker.1.txt.part"));
  EXPECT_TRUE(rotate_log(scratch_.path() / "worker.txt", 1000, 4));
  EXPECT_EQ(scratch_.read("worker.1.txt"), log);
  EXPECT_EQ(scratch_.read("worker.3.txt"), oldest);
}

}  // namespace
}  // namespace lcmslam
