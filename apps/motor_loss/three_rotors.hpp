// Flight on three of four rotors.
#pragma once

#include "rotors.hpp"

namespace stator::apps::motor_loss {

// Yaw is given up: the vehicle spins, as fast as its drag lets it, and the direction of its thrust
// is what is controlled (M. W. Mueller, R. D'Andrea, "Stability and control of a quadrocopter
// despite the complete loss of one, two, or three propellers", ICRA 2014). The rotors beside the
// lost one carry most; the one opposite to it gives a constant torque in B, under which a body
// that spins at r turns about an axis m that leans in B:
//
//     (m x gyration^2 m) r^2 = torque / mass        m = (m_x, m_y, 1)
//
// That axis is pointed along the wanted thrust. Slow spin leaves no room for the opposite rotor.
class ThreeRotors {
  public:
    struct Gains {
        float tilt_p;     // 1/s
        float rate_p;     // 1/s
        float rotor_lag;  // s
    };

    void configure(const Quad& quad, unsigned lost);
    // `down_B`: where the thrust should push away from, in B, of unit length. `thrust`: of all four
    // rotors together, 0 to 1. `force_per_command`: of a rotor, m/s^2. The lost one stops.
    Commands update(const Quad& quad, const Gains& gains, const Vector3& down_B,
                    const Vector3& rate_B, float thrust, float force_per_command) const;

  private:
    Vector2 axis(const Quad& quad, float spin, float sum, float force_per_command) const;
    Commands allocate(const Quad& quad, const Vector2& torque, float sum) const;

    unsigned lost_ = 0;
    unsigned opposite_ = 0;
    unsigned side_ = 0;
    unsigned other_side_ = 0;
};

}  // namespace stator::apps::motor_loss
