// Offset and factor of an accelerometer from gravity in six positions.
#include "six_sides.hpp"

namespace stator::apps::calibration {

namespace {

constexpr float kLeast = 0.85F;  // of gravity, along an axis: about 30 deg

// At rest the specific force points up. The sides in pairs, by the axis that points up and down:
// with the nose up (+x), the tail looks down.
int axis_of(Side side) {
    return static_cast<int>(side) / 2;
}
bool is_positive(Side side) {
    return static_cast<unsigned>(side) % 2 == 0;
}

}  // namespace

std::string_view name_of(Side side) {
    constexpr std::array<std::string_view, kSides> kNames{"back",  "front", "left",
                                                          "right", "up",    "down"};
    return kNames[static_cast<unsigned>(side)];
}

bool SixSides::find(const Vector& force, Side& side) {
    for (unsigned i = 0; i < kSides; ++i) {
        side = static_cast<Side>(i);
        const float along = force[axis_of(side)];
        if ((is_positive(side) ? along : -along) > kLeast * kGravity) return true;
    }
    return false;
}

void SixSides::put(Side side, const Vector& force) {
    force_[static_cast<unsigned>(side)] = force[axis_of(side)];
    done_ = static_cast<uint8_t>(done_ | 1U << static_cast<unsigned>(side));
}

unsigned SixSides::count() const {
    unsigned count = 0;
    for (unsigned i = 0; i < kSides; ++i) count += done_ >> i & 1U;
    return count;
}

SixSides::Result SixSides::result() const {
    Result result{};
    for (unsigned i = 0; i < 3; ++i) {
        const float positive = force_[2 * i];
        const float negative = force_[2 * i + 1];
        result.offset[static_cast<int>(i)] = 0.5F * (positive + negative);
        result.scale[static_cast<int>(i)] = 2.0F * kGravity / (positive - negative);
    }
    return result;
}

}  // namespace stator::apps::calibration
