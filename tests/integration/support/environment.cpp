#include "tests/integration/support/environment.hpp"

#include <gtest/gtest.h>

#include <unistd.h>
#include <cstdlib>
#include <iostream>
#include <thread>

#include <lcmslam/runtime/options.hpp>
#include "tests/support/own_bus.hpp"

namespace lcmslam::integration {

int run_tests(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  setenv("LCM_DEFAULT_URL", own_bus(default_lcm_url).c_str(), 1);
  return RUN_ALL_TESTS();
}

std::filesystem::path program_folder() {
  const char* folder = std::getenv("LCMSLAM_PROGRAMS");
  return folder != nullptr ? folder : LCMSLAM_PROGRAMS;
}

TemporaryFolder::TemporaryFolder() {
  std::string name = std::filesystem::temp_directory_path() / "lcmslam-test-XXXXXX";
  if (mkdtemp(name.data()) == nullptr) throw std::runtime_error(name + ": cannot be made");
  path_ = name;
}

TemporaryFolder::~TemporaryFolder() {
  const auto* unit = testing::UnitTest::GetInstance();
  const bool failed = unit->current_test_info() != nullptr    ? unit->current_test_info()->result()->Failed()
                      : unit->current_test_suite() != nullptr ? unit->current_test_suite()->Failed()
                                                              : false;
  if (failed) {
    std::cerr << "kept for a look: " << path_ << "\n";
    return;
  }
  std::error_code ignored;
  std::filesystem::remove_all(path_, ignored);
}

bool wait_until(const std::function<bool()>& predicate, double seconds) {
  const auto deadline =
      std::chrono::steady_clock::now() + std::chrono::duration<double>(patience_factor * seconds);
  while (!predicate()) {
    if (std::chrono::steady_clock::now() > deadline) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  return true;
}

}  // namespace lcmslam::integration

int main(int argc, char** argv) {
  return lcmslam::integration::run_tests(argc, argv);
}
