#include <lcmslam/features/descriptor_distance.hpp>

#include <cstddef>
#include <stdexcept>

#include <lcmslam/features/dot_product_distance.hpp>

#if defined(__x86_64__)
#include <immintrin.h>
#endif

namespace lcmslam {
namespace {

void distances_portable(const WideDescriptor* const queries[4], const Descriptor* targets,
                        const std::int32_t* norms2, int count, Int4* distances) {
  for (int t = 0; t < count; ++t)
    for (int q = 0; q < 4; ++q) {
      std::int32_t dot = 0;
      for (std::size_t k = 0; k < 64; ++k) dot += queries[q]->values[k] * targets[t][k];
      distances[t][q] = queries[q]->norm2 + norms2[t] - 2 * dot;
    }
}

void lone_distances_portable(const WideDescriptor& query, const Descriptor* targets,
                             const std::int32_t* norms2, int count, std::int32_t* distances) {
  for (int t = 0; t < count; ++t) {
    std::int32_t dot = 0;
    for (std::size_t k = 0; k < 64; ++k) dot += query.values[k] * targets[t][k];
    distances[t] = query.norm2 + norms2[t] - 2 * dot;
  }
}

#if defined(__x86_64__)

Int4 query_norms(const WideDescriptor* const queries[4]) {
  return Int4{queries[0]->norm2, queries[1]->norm2, queries[2]->norm2, queries[3]->norm2};
}

// The sums of a, b, c, d over their own four lanes.
inline __m128i sums(__m128i a, __m128i b, __m128i c, __m128i d) {
  const __m128i ab = _mm_add_epi32(_mm_unpacklo_epi32(a, b), _mm_unpackhi_epi32(a, b));
  const __m128i cd = _mm_add_epi32(_mm_unpacklo_epi32(c, d), _mm_unpackhi_epi32(c, d));
  return _mm_add_epi32(_mm_unpacklo_epi64(ab, cd), _mm_unpackhi_epi64(ab, cd));
}

void distances_sse2(const WideDescriptor* const queries[4], const Descriptor* targets,
                    const std::int32_t* norms2, int count, Int4* distances) {
  const Int4 norms = query_norms(queries);
  const __m128i zero = _mm_setzero_si128();
  for (int t = 0; t < count; ++t) {
    __m128i dot[4] = {zero, zero, zero, zero};
    for (int k = 0; k < 4; ++k) {
      const __m128i bytes = _mm_loadu_si128(reinterpret_cast<const __m128i*>(targets[t].data() + 16 * k));
      const __m128i low = _mm_unpacklo_epi8(bytes, zero), high = _mm_unpackhi_epi8(bytes, zero);
      for (int q = 0; q < 4; ++q) {
        const auto* query = reinterpret_cast<const __m128i*>(queries[q]->values + 16 * k);
        dot[q] = _mm_add_epi32(dot[q], _mm_add_epi32(_mm_madd_epi16(low, _mm_load_si128(query)),
                                                     _mm_madd_epi16(high, _mm_load_si128(query + 1))));
      }
    }
    distances[t] = norms + norms2[t] - 2 * (Int4)sums(dot[0], dot[1], dot[2], dot[3]);
  }
}

// Four sums over eight lanes each.
__attribute__((target("avx2"))) inline __m128i sums(const __m256i dot[4]) {
  const __m256i pairs =
      _mm256_hadd_epi32(_mm256_hadd_epi32(dot[0], dot[1]), _mm256_hadd_epi32(dot[2], dot[3]));
  return _mm_add_epi32(_mm256_castsi256_si128(pairs), _mm256_extracti128_si256(pairs, 1));
}

__attribute__((target("avx2"))) void distances_avx2(const WideDescriptor* const queries[4],
                                                    const Descriptor* targets, const std::int32_t* norms2,
                                                    int count, Int4* distances) {
  const __m128i norms =
      _mm_set_epi32(queries[3]->norm2, queries[2]->norm2, queries[1]->norm2, queries[0]->norm2);
  for (int t = 0; t < count; ++t) {
    const auto* bytes = reinterpret_cast<const __m128i*>(targets[t].data());
    const __m256i target[4] = {
        _mm256_cvtepu8_epi16(_mm_loadu_si128(bytes)), _mm256_cvtepu8_epi16(_mm_loadu_si128(bytes + 1)),
        _mm256_cvtepu8_epi16(_mm_loadu_si128(bytes + 2)), _mm256_cvtepu8_epi16(_mm_loadu_si128(bytes + 3))};
    __m256i dot[4];
    for (int q = 0; q < 4; ++q) {
      const auto* query = reinterpret_cast<const __m256i*>(queries[q]->values);
      const __m256i first = _mm256_add_epi32(_mm256_madd_epi16(target[0], _mm256_load_si256(query)),
                                             _mm256_madd_epi16(target[1], _mm256_load_si256(query + 1)));
      const __m256i last = _mm256_add_epi32(_mm256_madd_epi16(target[2], _mm256_load_si256(query + 2)),
                                            _mm256_madd_epi16(target[3], _mm256_load_si256(query + 3)));
      dot[q] = _mm256_add_epi32(first, last);
    }
    const __m128i dots = sums(dot);
    const __m128i squares = _mm_add_epi32(norms, _mm_set1_epi32(norms2[t]));
    _mm_store_si128(reinterpret_cast<__m128i*>(distances + t),
                    _mm_sub_epi32(squares, _mm_add_epi32(dots, dots)));
  }
}

__attribute__((target("avx2"))) inline __m256i dot_lanes(const __m256i query[4], const Descriptor& target) {
  const auto* bytes = reinterpret_cast<const __m128i*>(target.data());
  __m256i part[4];
  for (int k = 0; k < 4; ++k)
    part[k] = _mm256_madd_epi16(_mm256_cvtepu8_epi16(_mm_loadu_si128(bytes + k)), query[k]);
  return _mm256_add_epi32(_mm256_add_epi32(part[0], part[1]), _mm256_add_epi32(part[2], part[3]));
}

__attribute__((target("avx2"))) void lone_distances_avx2(const WideDescriptor& query,
                                                         const Descriptor* targets,
                                                         const std::int32_t* norms2, int count,
                                                         std::int32_t* distances) {
  __m256i values[4];
  for (int k = 0; k < 4; ++k)
    values[k] = _mm256_load_si256(reinterpret_cast<const __m256i*>(query.values + 16 * k));
  const __m128i norm = _mm_set1_epi32(query.norm2);
  int t = 0;
  for (; t + 4 <= count; t += 4) {
    __m256i dot[4];
    for (int i = 0; i < 4; ++i) dot[i] = dot_lanes(values, targets[t + i]);
    const __m128i dots = sums(dot);
    const __m128i squares =
        _mm_add_epi32(norm, _mm_loadu_si128(reinterpret_cast<const __m128i*>(norms2 + t)));
    _mm_storeu_si128(reinterpret_cast<__m128i*>(distances + t),
                     _mm_sub_epi32(squares, _mm_add_epi32(dots, dots)));
  }
  for (; t < count; ++t) {
    const __m256i dot = dot_lanes(values, targets[t]), lanes[4] = {dot, dot, dot, dot};
    distances[t] = query.norm2 + norms2[t] - 2 * _mm_cvtsi128_si32(sums(lanes));
  }
}

#endif

}  // namespace

void WideDescriptor::assign(const Descriptor& descriptor) {
  for (std::size_t k = 0; k < 64; ++k) values[k] = descriptor[k];
  norm2 = squared_norm(descriptor);
}

std::int32_t squared_norm(const Descriptor& descriptor) {
  std::int32_t sum = 0;
  for (const std::uint8_t byte : descriptor) sum += byte * byte;
  return sum;
}

DistanceFunction distance_function(InstructionSet set) {
  if (!has(set)) throw std::invalid_argument("matching: this processor lacks the instruction set asked for");
#if defined(__x86_64__)
  if (const auto faster = dot_product_distances(); faster && set == InstructionSet::avx2) return faster;
  if (set == InstructionSet::avx2) return distances_avx2;
  if (set == InstructionSet::sse2) return distances_sse2;
#endif
  return distances_portable;
}

LoneDistanceFunction lone_distance_function(InstructionSet set) {
  if (!has(set)) throw std::invalid_argument("matching: this processor lacks the instruction set asked for");
#if defined(__x86_64__)
  if (const auto faster = lone_dot_product_distances(); faster && set == InstructionSet::avx2) return faster;
  if (set == InstructionSet::avx2) return lone_distances_avx2;
#endif
  return lone_distances_portable;
}

}  // namespace lcmslam
