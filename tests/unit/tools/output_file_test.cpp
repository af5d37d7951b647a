#include "tools/output_file.hpp"

#include <gmock/gmock.h>

#include <csignal>
#include <iostream>

#include <lcmslam/runtime/stop_signal.hpp>
#include "tests/unit/tools/log_samples.hpp"
#include "tools/log/log_edit.hpp"
#include "tools/run_folder.hpp"

namespace lcmslam {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using testing::ScratchFolder;

template <class Action>
std::string error_of(Action action) {
  try {
    action();
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  return "";
}

TEST(OutputFile, WhatIsThereIsReplacedOnlyByForceAndOnlyIfItIsAFile) {
  const ScratchFolder scratch;
  const auto old = scratch.write("old.lcmlog", "precious");
  EXPECT_EQ(error_of([&] { check_output_file(scratch.path() / "new.lcmlog", false); }), "");
  EXPECT_THAT(error_of([&] { check_output_file(old, false); }),
              AllOf(HasSubstr(old.string()), HasSubstr("--force")));
  EXPECT_EQ(error_of([&] { check_output_file(old, true); }), "");
  EXPECT_THAT(error_of([&] { check_output_file(scratch.path(), true); }), HasSubstr("is no file"));
}

TEST(RunFolder, AnotherRunsResultsAreReplacedOnlyByForce) {
  for (const char* name : {"batch.lcmlog", "summary.json", "icp_map.ply", "fastslam_map.pcd"}) {
    const ScratchFolder scratch;
    scratch.write("notes.txt", "mine");
    EXPECT_EQ(error_of([&] { check_run_folder(scratch.path(), false); }), "");
    scratch.write(name, "precious");
    EXPECT_THAT(error_of([&] { check_run_folder(scratch.path(), false); }),
                AllOf(HasSubstr(scratch.path().string()), HasSubstr(name), HasSubstr("--force")));
    EXPECT_EQ(error_of([&] { check_run_folder(scratch.path(), true); }), "");
  }
  EXPECT_EQ(error_of([] { check_run_folder("/nowhere", false); }), "");
}

/// In a process of its own, for a stop cannot be taken back.
TEST(StoppedWriters, LeaveNothingAndTheOldFileAsItWas) {
  const ScratchFolder scratch;
  const std::string log = testing::sample_log(scratch, 2);
  const std::string old = scratch.write("old.lcmlog", "precious");
  EXPECT_EXIT(
      {
        install_stop_signals(0);
        std::raise(SIGINT);
        const std::string repaired = error_of([&] { repair_log(log, {old, true}); });
        const std::string cut = error_of([&] { cut_log(log, {old, true}, {}); });
        const std::string calibrated = error_of([&] { calibrate_log(log, {old, true}, {}); });
        std::cerr << repaired << cut << calibrated;
        std::_Exit(repaired == cut && cut == calibrated ? 0 : 1);
      },
      ::testing::ExitedWithCode(0), "stopped by a signal: nothing is written");
  EXPECT_EQ(scratch.read("old.lcmlog"), "precious");
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(scratch.path()), {}), 2) << "a part file stays";
}

}  // namespace
}  // namespace lcmslam
