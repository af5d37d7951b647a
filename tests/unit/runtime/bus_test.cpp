#include <lcmslam/runtime/bus.hpp>

#include <gmock/gmock.h>

#include <functional>
#include <stdexcept>

namespace lcmslam {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

std::string error_of(const std::string& url) {
  try {
    LcmBus bus{url};
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "";
}

TEST(Bus, AnUrlOfNoProviderIsNamedWithThoseThatThereAre) {
  for (const char* url : {"upd://239.255.76.67:7667", "239.255.76.67:7667", "udpm:239.255.76.67", "MEMQ://"})
    EXPECT_THAT(error_of(url), AllOf(HasSubstr(url), HasSubstr("udpm://"), HasSubstr("memq://"))) << url;
  EXPECT_THAT(error_of("mpudpm://239.255.76.67:7667"), HasSubstr("take udpm://"));
  EXPECT_EQ(error_of("memq://"), "");
}

TEST(Bus, WhatCannotBeOpenedIsSaidByTheCallerAlone) {
  ::testing::internal::CaptureStderr();
  LcmBus bus("file:///nowhere/run.lcmlog?mode=r");
  const bool usable = bus.usable();
  std::fprintf(stderr, "ours\n");
  EXPECT_EQ(::testing::internal::GetCapturedStderr(), "ours\n");
  EXPECT_FALSE(usable);
}

}  // namespace
}  // namespace lcmslam
