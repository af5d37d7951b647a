#include "tools/farm/run_key.hpp"

#include <fmt/format.h>
#include <sodium.h>
#include <fstream>
#include <stdexcept>

#include <lcmslam/configuration/config_json.hpp>

namespace lcmslam {
namespace {

namespace fs = std::filesystem;

class Hash {
 public:
  Hash() { crypto_generichash_init(&state_, nullptr, 0, size); }

  void add(const std::string& bytes) {
    const std::uint64_t length = bytes.size();  // so that "ab" + "c" is not "a" + "bc"
    update(&length, sizeof length);
    update(bytes.data(), bytes.size());
  }
  void add_file(const fs::path& file) {
    std::ifstream in(file, std::ios::binary);
    std::vector<char> piece(1 << 20);
    std::uint64_t length = 0;
    while (in.read(piece.data(), static_cast<std::streamsize>(piece.size())) || in.gcount() > 0) {
      update(piece.data(), static_cast<std::size_t>(in.gcount()));
      length += static_cast<std::uint64_t>(in.gcount());
    }
    if (!in.eof()) throw std::runtime_error(file.string() + ": cannot be read");
    update(&length, sizeof length);
  }
  std::string digits() {
    unsigned char bytes[size];
    crypto_generichash_final(&state_, bytes, size);
    std::string text;
    for (const unsigned char byte : bytes) text += fmt::format("{:02x}", byte);
    return text;
  }

 private:
  void update(const void* bytes, std::size_t length) {
    crypto_generichash_update(&state_, static_cast<const unsigned char*>(bytes), length);
  }

  static constexpr std::size_t size = 16;  // bytes
  crypto_generichash_state state_;
};

/// This build: the program's own bytes.
const std::string& build_digits() {
  static const std::string digits = [] {
    Hash hash;
    hash.add_file("/proc/self/exe");
    return hash.digits();
  }();
  return digits;
}

}  // namespace

std::string run_key(const RunInputs& inputs) {
  Hash hash;
  hash.add(build_digits());
  hash.add(config_json(inputs.config));
  hash.add(fmt::format("{} overrides, from {} to {}{}", inputs.overrides.size(), inputs.from, inputs.to,
                       inputs.kitti ? ", kitti" : ""));
  for (const std::string& text : inputs.overrides) hash.add(text);
  if (!inputs.calibration.empty()) hash.add_file(inputs.calibration);
  hash.add_file(inputs.log);
  return hash.digits();
}

}  // namespace lcmslam
