// No bytes, however wrong, get past check_layout to LCM's trusting decoders.

#include <gmock/gmock.h>

#include <algorithm>

#include <lcmslam/messages/decode.hpp>
#include "tests/unit/messages/all_types.hpp"
#include "tests/unit/messages/allocation_watch.hpp"
#include "tests/unit/messages/wire_sample.hpp"

namespace lcmslam {
namespace {

using ::testing::AnyOf;
using testing::Bytes;
using ::testing::HasSubstr;
using testing::WireSample;
using testing::WireSampler;

template <class M>
class Layout : public ::testing::Test {
 protected:
  WireSample sample() { return WireSampler(random_).make(type_); }

  /// Decodes; what was wrong, or nothing.
  std::string error_of(const Bytes& bytes) {
    try {
      decode_message<M>(bytes.data(), bytes.size());
      return {};
    } catch (const DecodeError& error) {
      return error.what();
    }
  }

  const MessageType& type_ = *MessageType::find(std::string(M::getTypeName()));
  Random random_{1};
};
TYPED_TEST_SUITE(Layout, testing::AllTypes);

TYPED_TEST(Layout, ValidBytesDecodeAndEncodeToThemselves) {
  for (int i = 0; i < 20; ++i) {
    const Bytes bytes = this->sample().bytes;
    const auto message = decode_message<TypeParam>(bytes.data(), bytes.size());
    EXPECT_EQ(encode_message(message), bytes);
  }
}

TYPED_TEST(Layout, EveryTruncationIsRefused) {
  const Bytes bytes = this->sample().bytes;
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    // A copy of exactly this size: a sanitizer sees whoever reads on.
    const Bytes part(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(size));
    EXPECT_NE(this->error_of(part), "") << size << " of " << bytes.size() << " bytes";
  }
}

TYPED_TEST(Layout, OneByteTooManyIsRefused) {
  for (const int surplus : {0x00, 0x01, 0xff}) {
    Bytes bytes = this->sample().bytes;
    bytes.push_back(static_cast<std::uint8_t>(surplus));
    EXPECT_THAT(this->error_of(bytes), HasSubstr("bytes too many"));
  }
}

TYPED_TEST(Layout, AnotherFingerprintIsRefused) {
  for (const MessageType* other : MessageType::all()) {
    if (other->name == TypeParam::getTypeName()) continue;
    const Bytes bytes = WireSampler(this->random_).make(*other).bytes;
    EXPECT_THAT(this->error_of(bytes), HasSubstr("a " + other->name));
  }
  Bytes bytes = this->sample().bytes;
  bytes[0] = static_cast<std::uint8_t>(bytes[0] ^ 1);
  EXPECT_THAT(this->error_of(bytes), HasSubstr("unknown fingerprint"));
}

TYPED_TEST(Layout, LyingLengthsAreRefusedBeforeTheyTakeMemory) {
  const WireSample sample = this->sample();
  for (const auto& length : sample.lengths)
    for (const std::uint64_t lie :
         {0x7fffffffULL, 0x7ffffffffffffff0ULL, 0x80000000ULL, 0xffffffffffffffffULL}) {
      Bytes bytes = sample.bytes;
      Bytes lie_bytes;
      testing::put_integer(lie_bytes, lie, length.size);
      std::copy(lie_bytes.begin(), lie_bytes.end(),
                bytes.begin() + static_cast<std::ptrdiff_t>(length.offset));
      testing::forget_allocations();
      const std::string error = this->error_of(bytes);
      EXPECT_THAT(error, AnyOf(HasSubstr("exceeds the message"), HasSubstr("is negative"),
                               HasSubstr("does not fit")));
      EXPECT_LT(testing::largest_allocation(), 10'000U) << error;
    }
}

// A std::string may hold one, but LCM's encoders stop there: sent on, the message would be another.
TEST(LayoutOfText, WithANulInItIsRefused) {
  command_t command{};
  command.target = "icp";
  Bytes bytes = encode_message(command);
  EXPECT_EQ(decode_message<command_t>(bytes.data(), bytes.size()).target, "icp");
  const std::string text = "icp";
  *std::search(bytes.begin(), bytes.end(), text.begin(), text.end()) = 0;
  try {
    decode_message<command_t>(bytes.data(), bytes.size());
    FAIL() << "no error";
  } catch (const DecodeError& error) {
    EXPECT_THAT(error.what(), HasSubstr("target: text with a NUL in it"));
  }
}

TYPED_TEST(Layout, MutationsNeverCrashNorTakeMuchMemory) {
  for (int i = 0; i < 4000; ++i) {
    Bytes bytes = this->sample().bytes;
    const std::uint64_t times = 1 + this->random_.below(4);
    for (std::uint64_t k = 0; k < times; ++k) testing::mutate(bytes, this->random_);
    bytes.shrink_to_fit();
    testing::forget_allocations();
    const std::string error = this->error_of(bytes);
    // A text of one byte on the wire is a std::string of 32.
    ASSERT_LT(testing::largest_allocation(), 40 * bytes.size() + 4096) << error;
  }
}

}  // namespace
}  // namespace lcmslam
