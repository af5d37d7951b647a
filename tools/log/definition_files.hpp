#pragma once
// Types of others, by their definitions in LCM's language: the tools then know their messages by fingerprint.

#include <string>
#include <vector>

#include <lcmslam/messages/schema.hpp>

namespace lcmslam {

/// Of .lcm files, and of all that lie in folders and below. Types that these use must be among them. Throws
/// std::runtime_error naming the file, or --definitions, and what is wrong with it.
std::vector<const MessageType*> read_definitions(const std::vector<std::string>& paths);

/// Those of lcmtypes/ and some more.
class KnownTypes {
 public:
  KnownTypes() = default;
  explicit KnownTypes(std::vector<const MessageType*> more) : more_(std::move(more)) {}

  /// By LCM's fingerprint; nullptr when no definition has it.
  const MessageType* find(std::uint64_t fingerprint) const;
  /// Of a message's first 8 bytes.
  const MessageType* of(const std::uint8_t* data, std::size_t size) const;

 private:
  std::vector<const MessageType*> more_;
};

}  // namespace lcmslam
