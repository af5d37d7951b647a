#include <lcmslam/features/dot_product_distance.hpp>

#include <atomic>

#if defined(__x86_64__) && defined(__GNUC__)
#include <immintrin.h>
#define LCMSLAM_DOT_PRODUCTS __attribute__((target("avx2,avx512f,avx512bw,avx512vl,avx512vnni")))
#endif

namespace lcmslam {
namespace {

std::atomic<bool> allowed_{true};

#ifdef LCMSLAM_DOT_PRODUCTS

// The instruction multiplies unsigned bytes by signed ones: t . q = t . (q - 128) + 128 sum(t).
struct Signed {
  __m256i half[2];
};

LCMSLAM_DOT_PRODUCTS inline Signed signed_bytes(const WideDescriptor& descriptor) {
  Signed result;
  for (int h = 0; h < 2; ++h) {
    const auto* wide = reinterpret_cast<const __m256i*>(descriptor.values + 32 * h);
    const __m256i packed = _mm256_packus_epi16(_mm256_load_si256(wide), _mm256_load_si256(wide + 1));
    const __m256i bytes = _mm256_permute4x64_epi64(packed, 0xD8);
    result.half[h] = _mm256_xor_si256(bytes, _mm256_set1_epi8(-128));
  }
  return result;
}

struct Unsigned {
  __m256i half[2], sum128;  // 128 times the bytes, summed in each lane
};

LCMSLAM_DOT_PRODUCTS inline Unsigned unsigned_bytes(const Descriptor& descriptor) {
  const auto* bytes = reinterpret_cast<const __m256i*>(descriptor.data());
  Unsigned result{{_mm256_loadu_si256(bytes), _mm256_loadu_si256(bytes + 1)}, {}};
  const __m256i ones = _mm256_set1_epi8(1);
  const __m256i sum = _mm256_dpbusd_epi32(_mm256_dpbusd_epi32(_mm256_setzero_si256(), result.half[0], ones),
                                          result.half[1], ones);
  result.sum128 = _mm256_slli_epi32(sum, 7);
  return result;
}

LCMSLAM_DOT_PRODUCTS inline __m256i dot(const Unsigned& target, const Signed& query) {
  return _mm256_dpbusd_epi32(_mm256_dpbusd_epi32(target.sum128, target.half[0], query.half[0]),
                             target.half[1], query.half[1]);
}

// Four sums over eight lanes each.
LCMSLAM_DOT_PRODUCTS inline __m128i sums(__m256i a, __m256i b, __m256i c, __m256i d) {
  const __m256i pairs = _mm256_hadd_epi32(_mm256_hadd_epi32(a, b), _mm256_hadd_epi32(c, d));
  return _mm_add_epi32(_mm256_castsi256_si128(pairs), _mm256_extracti128_si256(pairs, 1));
}

LCMSLAM_DOT_PRODUCTS void distances(const WideDescriptor* const queries[4], const Descriptor* targets,
                                    const std::int32_t* norms2, int count, Int4* to) {
  const Signed query[4] = {signed_bytes(*queries[0]), signed_bytes(*queries[1]), signed_bytes(*queries[2]),
                           signed_bytes(*queries[3])};
  const __m128i norms =
      _mm_set_epi32(queries[3]->norm2, queries[2]->norm2, queries[1]->norm2, queries[0]->norm2);
  for (int t = 0; t < count; ++t) {
    const Unsigned target = unsigned_bytes(targets[t]);
    const __m128i dots =
        sums(dot(target, query[0]), dot(target, query[1]), dot(target, query[2]), dot(target, query[3]));
    const __m128i squares = _mm_add_epi32(norms, _mm_set1_epi32(norms2[t]));
    _mm_store_si128(reinterpret_cast<__m128i*>(to + t), _mm_sub_epi32(squares, _mm_add_epi32(dots, dots)));
  }
}

LCMSLAM_DOT_PRODUCTS void lone_distances(const WideDescriptor& lone, const Descriptor* targets,
                                         const std::int32_t* norms2, int count, std::int32_t* to) {
  const Signed query = signed_bytes(lone);
  for (int t = 0; t < count; t += 4) {
    const auto of = [&](int i) { return t + i < count ? t + i : count - 1; };
    const __m128i dots =
        sums(dot(unsigned_bytes(targets[t]), query), dot(unsigned_bytes(targets[of(1)]), query),
             dot(unsigned_bytes(targets[of(2)]), query), dot(unsigned_bytes(targets[of(3)]), query));
    alignas(16) std::int32_t four[4];
    _mm_store_si128(reinterpret_cast<__m128i*>(four), dots);
    for (int i = 0; i < 4 && t + i < count; ++i) to[t + i] = lone.norm2 + norms2[t + i] - 2 * four[i];
  }
}

bool has_dot_products() {
  static const bool has = __builtin_cpu_supports("avx2") && __builtin_cpu_supports("avx512bw") &&
                          __builtin_cpu_supports("avx512vl") && __builtin_cpu_supports("avx512vnni");
  return has && allowed_.load(std::memory_order_relaxed);
}

#endif

}  // namespace

DistanceFunction dot_product_distances() {
#ifdef LCMSLAM_DOT_PRODUCTS
  if (has_dot_products()) return distances;
#endif
  return nullptr;
}

LoneDistanceFunction lone_dot_product_distances() {
#ifdef LCMSLAM_DOT_PRODUCTS
  if (has_dot_products()) return lone_distances;
#endif
  return nullptr;
}

bool allow_dot_products(bool allowed) {
  return allowed_.exchange(allowed);
}

}  // namespace lcmslam
