// Offset and factor of an accelerometer from gravity in six positions.
#pragma once

#include <array>
#include <string_view>

#include "still.hpp"

namespace stator::apps::calibration {

// The side of the vehicle that looks down, in the words that ground stations know.
enum class Side : uint8_t { kBack, kFront, kLeft, kRight, kUp, kDown };
inline constexpr unsigned kSides = 6;
std::string_view name_of(Side side);

class SixSides {
  public:
    struct Result {
        Vector offset;
        Vector scale;
    };
    static constexpr float kGravity = 9.80665F;

    // The side that looks down while this is the specific force; false: none does.
    static bool find(const Vector& force, Side& side);
    bool has(Side side) const { return (done_ >> static_cast<unsigned>(side) & 1U) != 0; }
    void put(Side side, const Vector& force);
    unsigned count() const;
    // Once all are there: what makes gravity of each pair of sides.
    Result result() const;
    void clear() { done_ = 0; }

  private:
    std::array<float, kSides> force_{};  // along the axis of each side
    uint8_t done_ = 0;
};

}  // namespace stator::apps::calibration
