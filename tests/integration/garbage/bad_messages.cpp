#include "tests/integration/garbage/bad_messages.hpp"

#include <algorithm>
#include <functional>
#include <limits>

#include <lcmslam/images_t.hpp>

namespace lcmslam::integration {
namespace {

constexpr std::size_t fingerprint_bytes = 8;

Bytes random_bytes(std::size_t size, Random& random) {
  Bytes bytes(size);
  for (auto& byte : bytes) byte = static_cast<std::uint8_t>(random.below(256));
  return bytes;
}

/// Big-endian.
void put(Bytes& bytes, std::size_t at, std::uint64_t value, std::size_t size) {
  for (std::size_t i = 0; i < size && at + i < bytes.size(); ++i)
    bytes[at + i] = static_cast<std::uint8_t>(value >> (8 * (size - 1 - i)));
}

std::uint64_t get(const Bytes& bytes, std::size_t at, std::size_t size) {
  std::uint64_t value = 0;
  for (std::size_t i = 0; i < size; ++i) value = (value << 8) | bytes.at(at + i);
  return value;
}

/// Where the array lengths stand that come before the first array.
std::vector<std::size_t> length_offsets(const Bytes& valid) {
  const MessageType* type = MessageType::find(get(valid, 0, fingerprint_bytes));
  if (type == nullptr) throw std::invalid_argument("the sample is no message of lcmtypes/");
  std::vector<std::size_t> starts;
  std::vector<std::size_t> lengths;
  std::size_t at = fingerprint_bytes;
  for (const MessageField& field : type->fields) {
    starts.push_back(at);
    std::size_t size =
        field.kind == MessageField::Kind::nested ? field.nested->fixed_size : value_size(field.kind);
    if (field.kind == MessageField::Kind::text) size = 4 + get(valid, at, 4);
    for (const auto& dimension : field.dimensions) {
      if (dimension.length_field >= 0) {
        lengths.push_back(starts[static_cast<std::size_t>(dimension.length_field)]);
        return lengths;
      }
      size *= dimension.fixed;
    }
    if (size == 0) return lengths;  // a nested message of variable size: its lengths are further on
    at += size;
  }
  return lengths;
}

Bytes with_image(const images_t& valid, std::size_t index, const std::function<void(image_t&)>& change) {
  images_t message = valid;
  change(message.images.at(index));
  message.images[index].size = static_cast<int32_t>(message.images[index].data.size());
  return encode_message(message);
}

Bytes with_images_only(const images_t& valid, const std::vector<std::size_t>& kept) {
  images_t message = valid;
  message.image_types.clear();
  message.images.clear();
  for (const std::size_t i : kept) {
    message.image_types.push_back(valid.image_types.at(i));
    message.images.push_back(valid.images.at(i));
  }
  message.n_images = static_cast<int32_t>(message.images.size());
  return encode_message(message);
}

}  // namespace

std::vector<Bytes> impossible_messages(const Bytes& valid, Random& random) {
  std::vector<Bytes> messages;
  for (const std::size_t size :
       {0, 1, 3, 7, 8, 9, 15, 16, 17, 31, 64, 255, 1400, 1500, 9000, 65535, 65536, 70000})
    messages.push_back(random_bytes(size, random));
  for (int i = 0; i < 12; ++i) messages.push_back(random_bytes(random.below(70001), random));

  const Bytes fingerprint(valid.begin(), valid.begin() + fingerprint_bytes);
  for (const std::size_t size : {0, 1, 8, 24, 40, 100, 500, 5000, 70000}) {
    Bytes message = fingerprint;
    // Never the valid size: a message without arrays would be right in its form.
    const Bytes body = random_bytes(size + fingerprint_bytes == valid.size() ? size + 1 : size, random);
    message.insert(message.end(), body.begin(), body.end());
    messages.push_back(message);
  }
  for (int i = 0; i < 20; ++i)
    messages.emplace_back(valid.begin(),
                          valid.begin() + static_cast<std::ptrdiff_t>(random.below(valid.size())));
  for (const std::size_t size : {1, 2, 8, 100, 10000}) {
    Bytes message = valid;
    const Bytes rest = random_bytes(size, random);
    message.insert(message.end(), rest.begin(), rest.end());
    messages.push_back(message);
  }
  for (int bit = 0; bit < 64; bit += 7) {
    Bytes message = valid;
    message[static_cast<std::size_t>(bit / 8)] ^= static_cast<std::uint8_t>(1 << (bit % 8));
    messages.push_back(message);
  }
  for (const std::size_t at : length_offsets(valid))
    for (const std::uint64_t length : {0xffffffffU, 0x80000000U, 0x7fffffffU, 0x40000000U, 10'000'000U}) {
      Bytes message = valid;
      put(message, at, length, 4);
      messages.push_back(message);
    }
  return messages;
}

std::vector<Bytes> absurd_messages(const Bytes& valid, Random& random) {
  const std::uint64_t values[] = {0x7ff8000000000000, 0x7ff0000000000000, 0xfff0000000000000,
                                  0x7fefffffffffffff, 0xffefffffffffffff, 0x7fc000007fc00000,
                                  0x7f8000007f800000, 0x7f7fffffff7fffff, 0x7fffffffffffffff,
                                  0x8000000000000000, 0xffffffffffffffff, 0};
  std::vector<Bytes> messages;
  for (const std::int64_t utime :
       {std::numeric_limits<std::int64_t>::max(), std::numeric_limits<std::int64_t>::min(), std::int64_t{-1},
        std::int64_t{1} << 62, -(std::int64_t{1} << 62)}) {
    Bytes message = valid;
    put(message, fingerprint_bytes, static_cast<std::uint64_t>(utime), 8);
    messages.push_back(message);
  }
  const std::size_t body = valid.size() - fingerprint_bytes;
  // The first bytes hold the header's values, the rest mostly arrays: both get their share.
  for (const std::size_t reach : {std::min<std::size_t>(body, 400), body})
    for (const std::uint64_t value : values)
      for (int i = 0; i < 4; ++i) {
        Bytes message = valid;
        put(message, fingerprint_bytes + 4 * random.below(reach / 4 + 1), value, 8);
        messages.push_back(message);
      }
  for (int i = 0; i < 20; ++i) {  // a handful of random bytes anywhere
    Bytes message = valid;
    for (int k = 0; k < 8; ++k)
      message[fingerprint_bytes + random.below(body)] = static_cast<std::uint8_t>(random.below(256));
    messages.push_back(message);
  }
  return messages;
}

std::vector<Bytes> bad_images(const Bytes& valid_bytes, Random& random) {
  const auto valid = decode_message<images_t>(valid_bytes.data(), valid_bytes.size());
  std::vector<Bytes> messages;
  for (std::size_t i = 0; i < 2; ++i) {  // colour, depth
    const auto change = [&](const std::function<void(image_t&)>& f) {
      messages.push_back(with_image(valid, i, f));
    };
    change([&](image_t& image) { image.data = random_bytes(image.data.size(), random); });
    change([&](image_t& image) { image.data.clear(); });
    change([&](image_t& image) { image.data.resize(1); });
    change([&](image_t& image) { image.data.resize(image.data.size() / 16); });
    change([&](image_t& image) { image.data.assign(60'000, 0); });
    for (const auto& [width, height] :
         {std::pair(0, 0), std::pair(-1, -1), std::pair(1, 1), std::pair(8192, 8192),
          std::pair(30'000, 30'000), std::pair(2'147'483'647, 2'147'483'647), std::pair(-2'147'483'647, 480),
          std::pair(641, 480)})
      change([w = width, h = height](image_t& image) {
        image.width = w;
        image.height = h;
      });
  }
  for (const int format : {0, -1, -2, static_cast<int>(image_t::PIXEL_FORMAT_BGR),
                           static_cast<int>(image_t::PIXEL_FORMAT_GRAY), 12345})
    messages.push_back(with_image(valid, 0, [format](image_t& image) { image.pixelformat = format; }));

  messages.push_back(with_images_only(valid, {}));
  messages.push_back(with_images_only(valid, {0}));
  messages.push_back(with_images_only(valid, {1}));
  return messages;
}

}  // namespace lcmslam::integration
