// The 16-bit floating point of IEEE 754, in integer arithmetic.
#include "stator/dronecan/float16.hpp"

#include <bit>

namespace stator::dronecan {

namespace {

constexpr uint32_t kLargest = 0x477FE000;   // 65504 as binary32
constexpr uint32_t kInfinity = 0x7F800000;  // of binary32
constexpr unsigned kDropped = 13;           // bits of the fraction that binary16 lacks
constexpr unsigned kRebias = 127 - 15;      // between the exponents' offsets

}  // namespace

uint16_t to_float16(float value) {
    const uint32_t bits = std::bit_cast<uint32_t>(value);
    const uint32_t magnitude = bits & 0x7FFFFFFF;
    if (magnitude > kInfinity) return 0x7FFF;
    const auto sign = static_cast<uint16_t>((bits >> 16) & 0x8000);
    if (magnitude >= kLargest) return static_cast<uint16_t>(sign | 0x7BFF);
    const unsigned exponent = magnitude >> 23;
    if (exponent > kRebias) {
        const uint32_t rounded = magnitude - (kRebias << 23) + (1U << (kDropped - 1));
        return static_cast<uint16_t>(sign | (rounded >> kDropped));
    }
    // Below binary16's normal numbers, in units of 2^-24; half a unit and more rounds up.
    const unsigned shift = kRebias + 1 - exponent + kDropped;
    if (exponent == 0 || shift > 24) return sign;
    const uint32_t fraction = (magnitude & 0x7FFFFF) | 0x800000;
    return static_cast<uint16_t>(sign | ((fraction + (1U << (shift - 1))) >> shift));
}

float from_float16(uint16_t bits) {
    const uint32_t sign = static_cast<uint32_t>(bits & 0x8000) << 16;
    const uint32_t exponent = (bits >> 10) & 0x1F;
    const uint32_t fraction = bits & 0x3FF;
    if (exponent == 31) return std::bit_cast<float>(sign | kInfinity | (fraction << kDropped));
    if (exponent != 0) {
        return std::bit_cast<float>(sign | ((exponent + kRebias) << 23) | (fraction << kDropped));
    }
    const float magnitude = static_cast<float>(fraction) * 0x1p-24F;
    return std::bit_cast<float>(sign | std::bit_cast<uint32_t>(magnitude));
}

}  // namespace stator::dronecan
