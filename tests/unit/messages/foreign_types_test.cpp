// bot_core's types that lcmslam itself does not use: known to the tools by their fingerprints.

#include <gtest/gtest.h>

#include <map>
#include <set>

#include <lcmslam/messages/print_message.hpp>

namespace lcmslam {
namespace {

/// lcm-gen 1.3.1 on openhumanoids/bot_core_lcmtypes.
const std::map<std::string, std::uint64_t>& public_fingerprints() {
  static const std::map<std::string, std::uint64_t> fingerprints = {
      {"planar_lidar_t", 0xe3d17423180b5e8d},  {"pointcloud_t", 0x0d89dc76eb295069},
      {"raw_t", 0x30571b45b804c18e},           {"rigid_transform_t", 0xea9ffbf2acc5c5ae},
      {"sensor_status_t", 0x22bd8eb19e834aad}, {"system_status_t", 0x22c7cc36e9099eb6},
      {"utime_t", 0x4d0d41c1f105b12f}};
  return fingerprints;
}

TEST(ForeignTypes, HaveTheirPublicFingerprints) {
  EXPECT_EQ(MessageType::foreign().size(), public_fingerprints().size());
  for (const MessageType* type : MessageType::foreign()) {
    EXPECT_EQ(type->fingerprint, public_fingerprints().at(type->name)) << type->name;
    EXPECT_EQ(display_name(*type), "bot_core." + type->name);
  }
}

TEST(ForeignTypes, AreFoundByFingerprint) {
  for (const auto& [name, fingerprint] : public_fingerprints()) {
    const MessageType* type = MessageType::find(fingerprint);
    ASSERT_NE(type, nullptr) << name;
    EXPECT_EQ(type->name, name);
    EXPECT_EQ(type->package, "bot_core");
  }
}

TEST(ForeignTypes, OursOfTheSameNameIsFoundByNameAndByItsOwnFingerprint) {
  const MessageType* ours = MessageType::find("rigid_transform_t");
  ASSERT_NE(ours, nullptr);
  EXPECT_EQ(ours->package, "lcmslam");
  EXPECT_EQ(display_name(*ours), "rigid_transform_t");
  EXPECT_EQ(MessageType::find(ours->fingerprint), ours);
  EXPECT_NE(ours->fingerprint, public_fingerprints().at("rigid_transform_t"));
  EXPECT_EQ(MessageType::find("utime_t")->package, "bot_core");
}

TEST(ForeignTypes, NoTwoKnownTypesShareAFingerprint) {
  std::set<std::uint64_t> seen;
  for (const auto* types : {&MessageType::all(), &MessageType::foreign()})
    for (const MessageType* type : *types) EXPECT_TRUE(seen.insert(type->fingerprint).second) << type->name;
}

}  // namespace
}  // namespace lcmslam
