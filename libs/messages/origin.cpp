#include <lcmslam/messages/origin.hpp>

#include <optional>

namespace lcmslam {
namespace {

image_metadata_t* find(image_t& image, const std::string& key) {
  for (auto& entry : image.metadata)
    if (entry.key == key) return &entry;
  return nullptr;
}

void set_bytes(image_t& image, const std::string& key, std::vector<std::uint8_t> bytes) {
  image_metadata_t* entry = find(image, key);
  if (entry == nullptr) {
    image.metadata.emplace_back();
    image.nmetadata = static_cast<int32_t>(image.metadata.size());
    entry = &image.metadata.back();
    entry->key = key;
  }
  entry->n = static_cast<int32_t>(bytes.size());
  entry->value = std::move(bytes);
}

void set_integer(image_t& image, const std::string& key, std::int64_t value) {
  std::vector<std::uint8_t> bytes(8);
  for (int i = 0; i < 8; ++i)
    bytes[static_cast<std::size_t>(i)] =
        static_cast<std::uint8_t>(static_cast<std::uint64_t>(value) >> (8 * i));
  set_bytes(image, key, std::move(bytes));
}

std::optional<std::int64_t> get_integer(const image_t& image, const std::string& key) {
  for (const auto& entry : image.metadata) {
    if (entry.key != key || entry.value.size() != 8) continue;
    std::uint64_t value = 0;
    for (int i = 7; i >= 0; --i) value = (value << 8) | entry.value[static_cast<std::size_t>(i)];
    return static_cast<std::int64_t>(value);
  }
  return std::nullopt;
}

}  // namespace

Origin origin(const images_t& message) {
  if (message.images.empty()) return {};
  const image_t& image = message.images.front();
  return {get_integer(image, "seq").value_or(-1), get_integer(image, "sender").value_or(0)};
}

void set_origin(images_t& message, const Origin& origin) {
  if (message.images.empty()) return;
  set_integer(message.images.front(), "seq", origin.seq);
  set_integer(message.images.front(), "sender", origin.sender);
}

std::string get_text(const image_t& image, const std::string& key) {
  for (const auto& entry : image.metadata)
    if (entry.key == key) return {entry.value.begin(), entry.value.end()};
  return {};
}

void set_text(image_t& image, const std::string& key, const std::string& value) {
  set_bytes(image, key, {value.begin(), value.end()});
}

}  // namespace lcmslam
