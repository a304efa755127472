// Which command for each rotor makes a wanted torque and thrust, and what yields when none does.
#pragma once

#include <array>
#include <span>

#include "stator/rotation.hpp"

namespace stator::apps::allocation {

inline constexpr unsigned kMaxRotors = 12;

// A rotor that thrusts along -z of B. Metres from the centre of mass.
struct Rotor {
    float x;
    float y;
    float moment;  // torque per thrust; positive turns counter-clockwise, seen from above
};

// Control allocation by the pseudo-inverse of the effectiveness matrix B (Johansen and Fossen:
// Control allocation, a survey, Automatica 49, 2013):
//
//     (torque, thrust) = B * control     control = B^T * (B * B^T)^-1 * (torque, thrust)
//
// Every row of B is in shares of the most that the rotors make together, so one unit of each
// wanted component is that most. Where commands leave their range, yaw yields first, then thrust,
// and roll and pitch last.
class Rotors {
  public:
    // False if these rotors cannot make all three torques and lift; then allocate() must not be
    // called. At most kMaxRotors.
    [[nodiscard]] bool set_geometry(std::span<const Rotor> rotors);
    // `idle`: least command. `airmode`: thrust may also rise for roll and pitch.
    void set_range(float idle, bool airmode);

    // Finite torque in [-1, 1] and thrust in [0, 1], upwards. Writes one command for each rotor.
    void allocate(const math::Vector3<float>& torque, float thrust, std::span<float> control) const;

  private:
    // What each component adds to control / lift. In these terms a rotor whose pseudo-inverse
    // thrust is `lift` acts like every other, and all share the range [lowest_, highest_].
    struct Share {
        float roll;
        float pitch;
        float yaw;
        float lift;
    };
    void find_range();
    float thrust_for(float thrust, float least, float most) const;
    float yaw_share(std::span<const float> level, float yaw) const;

    std::array<Share, kMaxRotors> share_{};
    unsigned count_ = 0;
    float idle_ = 0.0F;
    bool airmode_ = false;
    float lowest_ = 0.0F;
    float highest_ = 1.0F;
};

}  // namespace stator::apps::allocation
