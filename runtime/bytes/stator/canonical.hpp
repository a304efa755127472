// One bit pattern for all NaNs: their sign and payload differ between machines, so that they are
// made canonical where a sample is logged, recorded or compared. No node can tell, as none reads
// them.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <utility>

namespace stator {

// Consecutive numbers of one sample that may be NaN.
struct FloatRun {
    uint16_t offset;
    uint16_t count;
    uint8_t bytes;  // 4 or 8
};

// Of a message: each generated one that has such numbers says where they lie.
template <class Message>
inline constexpr std::array<FloatRun, 0> kFloats{};

namespace detail {

// `exponent` has the bits that are all ones in infinities and NaNs.
template <class Bits>
[[gnu::always_inline]] inline void canonicalise_one(std::byte* number, Bits exponent,
                                                    Bits canonical) {
    Bits bits = 0;
    std::memcpy(&bits, number, sizeof bits);
    if (static_cast<Bits>(bits << 1) > static_cast<Bits>(exponent << 1)) {
        std::memcpy(number, &canonical, sizeof canonical);
    }
}
template <class Bits>
void canonicalise(std::byte* numbers, size_t count, Bits exponent, Bits canonical) {
    for (const std::byte* end = numbers + count * sizeof(Bits); numbers != end;) {
        canonicalise_one(numbers, exponent, canonical);
        numbers += sizeof(Bits);
    }
}
inline void canonicalise(std::byte* numbers, size_t count, uint8_t bytes) {
    if (bytes == sizeof(uint32_t)) {
        canonicalise<uint32_t>(numbers, count, 0x7F800000, 0x7FC00000);
    } else {
        canonicalise<uint64_t>(numbers, count, 0x7FF0000000000000, 0x7FF8000000000000);
    }
}

template <FloatRun kRun>
[[gnu::always_inline]] inline float sum_of_run(const std::byte* sample) {
    float sum = -0.0F;  // to which a number may be added without a change
    for (size_t i = 0; i < kRun.count; ++i) {
        float number = 0.0F;
        std::memcpy(&number, sample + kRun.offset + i * sizeof number, sizeof number);
        sum += number;
    }
    return sum;
}

// Without a loop, if there are not many.
template <FloatRun kRun>
[[gnu::always_inline]] inline void canonicalise_run(std::byte* sample) {
    constexpr size_t kMany = 16;
    if constexpr (kRun.count > kMany) {
        canonicalise(sample + kRun.offset, kRun.count, kRun.bytes);
    } else {
        [sample]<size_t... i>(std::index_sequence<i...>) {
            (canonicalise(sample + kRun.offset + i * kRun.bytes, 1, kRun.bytes), ...);
        }
        (std::make_index_sequence<kRun.count>());
    }
}

}  // namespace detail

inline void canonicalise(std::byte* sample, const FloatRun* runs, size_t count) {
    for (const FloatRun* run = runs; run != runs + count; ++run) {
        detail::canonicalise(sample + run->offset, run->count, run->bytes);
    }
}

template <class Message>
[[gnu::always_inline]] inline void canonicalise(Message& message) {
    auto* const sample = reinterpret_cast<std::byte*>(&message);
    [sample]<size_t... i>(std::index_sequence<i...>) {
        (detail::canonicalise_run<kFloats<Message>[i]>(sample), ...);
    }
    (std::make_index_sequence<kFloats<Message>.size()>());
}

// Whether a message has numbers that may be NaN, but only a few of 4 bytes: then their sum says
// quickly whether one is.
template <class Message>
constexpr bool has_few_floats() {
    constexpr size_t kFew = 4;
    size_t count = 0;
    for (const FloatRun& run : kFloats<Message>) {
        count += run.bytes == sizeof(float) ? run.count : kFew + 1;
    }
    return count != 0 && count <= kFew;
}

// True if one of a few is NaN, and perhaps if some are infinite.
template <class Message>
[[gnu::always_inline]] inline bool may_have_nan(const Message& message) {
    static_assert(has_few_floats<Message>());
    const auto* const sample = reinterpret_cast<const std::byte*>(&message);
    return [sample]<size_t... i>(std::index_sequence<i...>) {
        return __builtin_isnan((detail::sum_of_run<kFloats<Message>[i]>(sample) + ...));
    }
    (std::make_index_sequence<kFloats<Message>.size()>());
}

}  // namespace stator
