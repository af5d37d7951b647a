#pragma once
// Who sent a message and its number: fields seq and sender, or for CAMERA (wire-compatible with
// bot_core, which has neither) metadata of the first image.

#include <string>
#include <type_traits>

#include <lcmslam/images_t.hpp>

namespace lcmslam {

struct Origin {
  std::int64_t seq = -1;    ///< -1: the sender does not number its messages
  std::int64_t sender = 0;  ///< 0: unknown
};

namespace detail {
template <class M, class = void>
struct IsNumbered : std::false_type {};
template <class M>
struct IsNumbered<M, std::void_t<decltype(M::seq), decltype(M::sender)>> : std::true_type {};
}  // namespace detail

/// Other people's types have neither field: their origin is unknown.
template <class M>
Origin origin(const M& message) {
  if constexpr (detail::IsNumbered<M>::value)
    return {message.seq, message.sender};
  else
    return {};
}
template <class M>
void set_origin(M& message, const Origin& origin) {
  if constexpr (detail::IsNumbered<M>::value) {
    message.seq = origin.seq;
    message.sender = origin.sender;
  }
}

Origin origin(const images_t& message);
void set_origin(images_t& message, const Origin& origin);

/// Metadata of an image; empty when absent.
std::string get_text(const image_t& image, const std::string& key);
void set_text(image_t& image, const std::string& key, const std::string& value);

}  // namespace lcmslam
