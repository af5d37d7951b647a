// Any sequence of pieces: whole messages have the size that their pieces claimed, nothing else comes out.

#include <cstdlib>

#include <lcmslam/messages/parts.hpp>
#include <lcmslam/messages/schema.hpp>

namespace lcmslam {
namespace {

class Input {
 public:
  Input(const std::uint8_t* data, std::size_t size) : data_(data), left_(size) {}
  bool empty() const { return left_ == 0; }
  int next() { return left_ == 0 ? 0 : (--left_, *data_++); }
  /// Small numbers mostly, sometimes extreme ones.
  std::int32_t number() {
    const int byte = next();
    if (byte < 240) return byte % 8;
    if (byte < 245) return byte - 243;
    return static_cast<std::int32_t>(0x7fffffff >> (byte - 245) * 3);
  }

 private:
  const std::uint8_t* data_;
  std::size_t left_;
};

part_t piece(Input& input) {
  part_t part;
  part.utime = input.next();
  part.seq = 0;
  part.sender = input.next() % 3;
  const char* const channels[] = {"CAMERA", "ICP_KEYFRAME", "", "A_PART"};
  part.channel = channels[input.next() % 16 < 13 ? 0 : input.next() % 4];
  part.message = input.number();
  part.part = input.number();
  part.n_parts = input.number();
  part.total_size = input.number();
  part.size = input.number();
  part.data.assign(static_cast<std::size_t>(input.next() % 9), 'x');
  if (input.next() % 8 != 0) part.size = static_cast<std::int32_t>(part.data.size());
  return part;
}

}  // namespace
}  // namespace lcmslam

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace lcmslam;
  Input input(data, size);
  PartAssembler assembler;
  while (!input.empty()) {
    const part_t part = piece(input);
    try {
      const auto whole = assembler.add(part);
      if (whole && (whole->bytes.size() != static_cast<std::size_t>(part.total_size) ||
                    whole->channel != part.channel))
        std::abort();
    } catch (const DecodeError&) {
    }
    if (assembler.incomplete() < 0) std::abort();
  }
  return 0;
}
