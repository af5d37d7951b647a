#pragma once
// Messages made of random values from the definition alone, byte by byte: what a sender in another
// language might send.

#include <cstdint>
#include <string>
#include <vector>

#include <lcmslam/geometry/random.hpp>
#include <lcmslam/messages/schema.hpp>

namespace lcmslam::testing {

using Bytes = std::vector<std::uint8_t>;

inline void put_integer(Bytes& bytes, std::uint64_t value, std::size_t size) {
  for (std::size_t i = size; i-- > 0;) bytes.push_back(static_cast<std::uint8_t>(value >> (8 * i)));
}

inline void put_text(Bytes& bytes, const std::string& text) {
  put_integer(bytes, text.size() + 1, 4);
  bytes.insert(bytes.end(), text.begin(), text.end());
  bytes.push_back(0);
}

/// Where a member that holds an array's length stands.
struct LengthAt {
  std::size_t offset = 0, size = 0;
};

struct WireSample {
  Bytes bytes;
  std::vector<LengthAt> lengths;  ///< of arrays and texts
};

class WireSampler {
 public:
  explicit WireSampler(Random& random) : random_(random) {}

  WireSample make(const MessageType& type) {
    sample_ = {};
    put_integer(sample_.bytes, type.fingerprint, 8);
    put(type);
    return sample_;
  }

 private:
  void put(const MessageType& type) {
    std::vector<std::size_t> values(type.fields.size(), 0);
    for (std::size_t i = 0; i < type.fields.size(); ++i) {
      bool is_length = false;
      for (const auto& field : type.fields)
        for (const auto& d : field.dimensions) is_length = is_length || d.length_field == static_cast<int>(i);
      if (is_length) {
        const std::size_t size = value_size(type.fields[i].kind);
        values[i] = 1 + random_.below(3);
        sample_.lengths.push_back({sample_.bytes.size(), size});
        put_integer(sample_.bytes, values[i], size);
      } else {
        put_array(type.fields[i], 0, values);
      }
    }
  }

  void put_array(const MessageField& field, std::size_t dimension, const std::vector<std::size_t>& values) {
    if (dimension == field.dimensions.size()) return put_value(field);
    const auto& d = field.dimensions[dimension];
    const std::size_t n = d.length_field < 0 ? d.fixed : values[static_cast<std::size_t>(d.length_field)];
    for (std::size_t k = 0; k < n; ++k) put_array(field, dimension + 1, values);
  }

  void put_value(const MessageField& field) {
    using Kind = MessageField::Kind;
    if (field.kind == Kind::nested) {
      put(*field.nested);
    } else if (field.kind == Kind::text) {
      sample_.lengths.push_back({sample_.bytes.size(), 4});
      put_text(sample_.bytes, std::string(random_.below(6), 'x'));
    } else {
      const std::uint64_t value = field.kind == Kind::boolean ? random_.below(2) : random_.bits();
      put_integer(sample_.bytes, value, value_size(field.kind));
    }
  }

  Random& random_;
  WireSample sample_;
};

/// Flips bits, overwrites, cuts, inserts or repeats at random.
inline void mutate(Bytes& bytes, Random& random) {
  const std::size_t at = random.below(bytes.size());
  switch (random.below(6)) {
    case 0:
    case 1:
      bytes[at] = static_cast<std::uint8_t>(bytes[at] ^ (1U << random.below(8)));
      break;
    case 2:
      bytes[at] = static_cast<std::uint8_t>(random.bits());
      break;
    case 3:
      for (std::size_t i = at; i < std::min(bytes.size(), at + 4); ++i)
        bytes[i] = static_cast<std::uint8_t>(random.below(2) != 0 ? 0xff : 0);
      break;
    case 4:
      bytes.resize(at + 1);
      break;
    default:
      bytes.insert(bytes.begin() + static_cast<std::ptrdiff_t>(at), static_cast<std::uint8_t>(random.bits()));
  }
}

}  // namespace lcmslam::testing
