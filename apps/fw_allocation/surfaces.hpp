// Which command for each control surface makes a wanted torque.
#pragma once

#include <array>
#include <span>

#include "stator/rotation.hpp"

namespace stator::apps::fw_allocation {

inline constexpr unsigned kMaxSurfaces = 8;

// By the pseudo-inverse of the effectiveness matrix B, a column for each surface (Johansen and
// Fossen: Control allocation, a survey, Automatica 49, 2013):
//
//     torque = B * control     control = B^T * (B * B^T)^-1 * torque
//
// Every row of B is in shares of the most that all surfaces make together about that axis, so that
// a torque of 1 is that most. An axis that no surface turns gets none. Where a surface would leave
// its range, it stays at its end.
class Surfaces {
  public:
    // Torque of each surface at a command of 1, in any common unit.
    void set_effectiveness(std::span<const math::Vector3<float>> effectiveness);
    // Writes a command in [-1, 1] for each surface.
    void allocate(const math::Vector3<float>& torque, std::span<float> control) const;

  private:
    std::array<math::Vector3<float>, kMaxSurfaces> share_{};  // rows of the pseudo-inverse
    unsigned count_ = 0;
};

}  // namespace stator::apps::fw_allocation
