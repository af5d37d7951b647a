#include <gmock/gmock.h>

#include <lcmslam/messages/schema.hpp>
#include "tests/unit/messages/wire_sample.hpp"

namespace lcmslam {
namespace {

using ::testing::HasSubstr;

std::string error_in(const std::string& text) {
  try {
    parse_definitions({text});
    return {};
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
}

TEST(Definitions, ReadsMembersCommentsConstantsAndArrays) {
  const auto types = parse_definitions({R"(package p;
    /* a comment with ; and } in it */
    struct inner_t { int16_t a, b; }  // and another }
    struct outer_t {
      const int32_t MANY = 3, FEW = 1;
      int32_t n;
      p.inner_t rows[n][2];
      string name;
    })"});
  ASSERT_EQ(types.size(), 2U);
  EXPECT_EQ(types[0]->fixed_size, 4U);
  const MessageType& outer = *types[1];
  EXPECT_EQ(outer.fixed_size, 0U);
  ASSERT_EQ(outer.fields.size(), 3U);
  EXPECT_EQ(outer.fields[1].nested, types[0]);
  ASSERT_EQ(outer.fields[1].dimensions.size(), 2U);
  EXPECT_EQ(outer.fields[1].dimensions[0].length_field, 0);
  EXPECT_EQ(outer.fields[1].dimensions[1].fixed, 2U);
}

TEST(Definitions, FingerprintIsThatOfLcmGen) {
  // bot_core.utime_t and bot_core.raw_t, which lcmslam itself does not use.
  const auto types =
      parse_definitions({"struct utime_t { int64_t utime; }",
                         "struct raw_t { int64_t utime; int32_t length; byte data[length]; }"});
  EXPECT_EQ(types[0]->fingerprint, 0x4d0d41c1f105b12fULL);
  EXPECT_EQ(types[1]->fingerprint, 0x30571b45b804c18eULL);
}

TEST(Definitions, FingerprintDependsOnMembersAndNotOnTheTypesName) {
  const auto types =
      parse_definitions({"struct a_t { int32_t x; double y; }", "struct b_t { int32_t x; double y; }",
                         "struct c_t { int32_t x; double z; }", "struct d_t { int32_t x; float y; }",
                         "struct e_t { double y; int32_t x; }", "struct f_t { int32_t x; double y[1]; }"});
  EXPECT_EQ(types[0]->fingerprint, types[1]->fingerprint);
  for (std::size_t i = 2; i < types.size(); ++i) EXPECT_NE(types[0]->fingerprint, types[i]->fingerprint) << i;
}

TEST(Definitions, SyntaxErrorsAreNamed) {
  EXPECT_THAT(error_in("structure a_t { }"), HasSubstr("got 'structure'"));
  EXPECT_THAT(error_in("struct a_t { int32_t x; "), HasSubstr("ends early"));
  EXPECT_THAT(error_in("struct a_t { int32_t x }"), HasSubstr("expected ';'"));
  EXPECT_THAT(error_in("struct a_t int32_t x;"), HasSubstr("expected '{'"));
  EXPECT_THAT(error_in("package p struct"), HasSubstr("expected ';'"));
  EXPECT_THAT(error_in("struct a_t { const int32_t A = 1"), HasSubstr("ends early"));
  EXPECT_THAT(error_in("struct a_t { byte x[n]; int32_t n; }"), HasSubstr("'n' is not a member before it"));
  EXPECT_THAT(error_in("struct a_t { double n; byte x[n]; }"), HasSubstr("'n' is no integer"));
  EXPECT_THAT(error_in("struct a_t { int8_t n[2]; byte x[n]; }"), HasSubstr("'n' is no integer"));
  EXPECT_THAT(error_in("struct a_t { byte x[3; }"), HasSubstr("expected ']'"));
  EXPECT_THAT(error_in("struct a_t { byte x[0]; }"), HasSubstr("no positive number"));
  EXPECT_THAT(error_in("struct a_t { byte x[3x]; }"), HasSubstr("no positive number"));
  EXPECT_THAT(error_in("struct a_t { byte x[99999999999999999999]; }"), HasSubstr("no positive number"));
  EXPECT_THAT(error_in("struct a_t { b_t x; }"), HasSubstr("unknown type b_t"));
  EXPECT_THAT(error_in("struct a_t { } struct a_t { }"), HasSubstr("a_t is defined twice"));
  EXPECT_THAT(error_in("struct a_t { } /* open"), HasSubstr("comment is not closed"));
  EXPECT_THAT(error_in("/*/ struct a_t { }"), HasSubstr("comment is not closed"));
}

TEST(Definitions, NoCutOfADefinitionCrashes) {
  const std::string text =
      "package p; /* c */ struct a_t { const int8_t C = 1; int32_t n; // n\n double x[n][3]; string s; }";
  std::size_t accepted = 0;
  for (std::size_t size = 0; size <= text.size(); ++size) accepted += error_in(text.substr(0, size)).empty();
  EXPECT_LT(accepted, 25U);  // the whole, and what ends between comment, package and struct
  EXPECT_EQ(error_in(text), "");
}

TEST(Definitions, TypeThatContainsItselfIsWalkedNoDeeperThanItsLimit) {
  const auto types = parse_definitions({"struct tree_t { int8_t n; tree_t children[n]; }"});
  EXPECT_EQ(types[0]->fixed_size, 0U);
  const auto chain = [&](std::size_t depth) {
    testing::Bytes bytes;
    testing::put_integer(bytes, types[0]->fingerprint, 8);
    bytes.insert(bytes.end(), depth, 1);
    bytes.push_back(0);
    return bytes;
  };
  const testing::Bytes shallow = chain(10), deep = chain(100'000);
  EXPECT_NO_THROW(check_layout(*types[0], shallow.data(), shallow.size()));
  EXPECT_THROW(check_layout(*types[0], deep.data(), deep.size()), DecodeError);
}

}  // namespace
}  // namespace lcmslam
