#include <lcmslam/runtime/bus_key.hpp>

#include <gmock/gmock.h>
#include <sys/stat.h>

#include <fstream>

#include "tests/unit/log/sample_log.hpp"

namespace lcmslam {
namespace {

using ::testing::HasSubstr;

class BusKeyFile : public ::testing::Test {
 protected:
  BusKey read(const std::string& text, mode_t mode = 0600) {
    std::ofstream(file_.path()) << text;
    chmod(file_.path().c_str(), mode);
    return read_bus_key(file_.path());
  }
  std::string error_of(const std::string& text, mode_t mode = 0600) {
    try {
      read(text, mode);
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    return "";
  }
  testing::ScratchFile file_;
};

TEST_F(BusKeyFile, HoldsSixtyFourDigits) {
  EXPECT_EQ(read(std::string(62, '0') + "fF\n")[31], 0xff);
}

TEST_F(BusKeyFile, IsRefusedWithWhatWouldBeRight) {
  EXPECT_THAT(error_of(std::string(63, '0')), HasSubstr("64 hexadecimal digits"));
  EXPECT_THAT(error_of(std::string(63, '0') + "g"), HasSubstr("64 hexadecimal digits"));
  EXPECT_THAT(error_of(std::string(66, '0')), HasSubstr("64 hexadecimal digits"));
  EXPECT_THAT(error_of(std::string(64, '0'), 0640), HasSubstr("chmod 600 " + file_.path()));
  EXPECT_THAT(error_of(""), HasSubstr("openssl rand -hex 32"));
  EXPECT_THROW(read_bus_key("/nowhere/key"), std::invalid_argument);
}

}  // namespace
}  // namespace lcmslam
