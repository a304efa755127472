// One bit pattern for all NaNs: their sign and payload differ between machines, so that they are
// made canonical where a sample is logged, recorded or compared. No node can tell, as none reads
// them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <iterator>
#include <type_traits>
#include <utility>

namespace stator {

// Consecutive numbers of one sample that may be NaN.
struct FloatRun {
    uint16_t offset;
    uint16_t count;
    uint8_t bytes;  // 4 or 8
};

namespace detail {

template <class Bits>
inline constexpr auto kInfinityShifted = static_cast<Bits>(sizeof(Bits) == 4 ? 0xFF000000
                                                                             : 0xFFE0000000000000);
template <class Bits>
inline constexpr auto kCanonicalNan = static_cast<Bits>(sizeof(Bits) == 4 ? 0x7FC00000
                                                                          : 0x7FF8000000000000);

template <class Bits>
[[gnu::always_inline]] inline bool is_other_nan_at(const std::byte* number) {
    Bits bits = 0;
    std::memcpy(&bits, number, sizeof bits);
    return static_cast<Bits>(bits << 1) > kInfinityShifted<Bits> && bits != kCanonicalNan<Bits>;
}
template <class Bits>
void canonicalise(std::byte* numbers, size_t count) {
    for (const std::byte* end = numbers + count * sizeof(Bits); numbers != end;
         numbers += sizeof(Bits)) {
        if (is_other_nan_at<Bits>(numbers)) [[unlikely]] {
            std::memcpy(numbers, &kCanonicalNan<Bits>, sizeof(Bits));
        }
    }
}
template <class Message, size_t run, size_t... number>
[[gnu::always_inline]] inline bool has_other_nan_in_run(const std::byte* message,
                                                        std::index_sequence<number...>) {
    constexpr auto& kRun = Message::kFloatRuns[run];
    using Bits = std::conditional_t<kRun[2] == sizeof(uint32_t), uint32_t, uint64_t>;
    constexpr size_t kMaxUnrolled = 32;
    const std::byte* const numbers = message + kRun[0];
    if constexpr (kRun[1] <= kMaxUnrolled) {
        return (is_other_nan_at<Bits>(numbers + number * sizeof(Bits)) || ...);
    } else {
        for (size_t i = 0; i < kRun[1]; ++i) {
            if (is_other_nan_at<Bits>(numbers + i * sizeof(Bits))) return true;
        }
        return false;
    }
}
template <class Message, size_t... run>
[[gnu::always_inline]] inline bool has_other_nan(const std::byte* message,
                                                 std::index_sequence<run...>) {
    return (has_other_nan_in_run<Message, run>(
                message, std::make_index_sequence<Message::kFloatRuns[run][1]>()) ||
            ...);
}

}  // namespace detail

// Whether one of the message's numbers is a NaN, but not the canonical one. Inlined where the
// message is built: three instructions for each number on Arm.
template <class Message>
[[gnu::always_inline]] inline bool has_other_nan(const Message& message) {
    return detail::has_other_nan<Message>(
        reinterpret_cast<const std::byte*>(&message),
        std::make_index_sequence<std::size(Message::kFloatRuns)>());
}

inline void canonicalise(std::byte* sample, const FloatRun* runs, size_t count) {
    for (const FloatRun* run = runs; run != runs + count; ++run) {
        std::byte* numbers = sample + run->offset;
        if (run->bytes == sizeof(uint32_t)) {
            detail::canonicalise<uint32_t>(numbers, run->count);
        } else {
            detail::canonicalise<uint64_t>(numbers, run->count);
        }
    }
}

}  // namespace stator
