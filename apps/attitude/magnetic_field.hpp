// Whether the magnetic field is the Earth's here, or disturbed by what is near.
#pragma once

#include "attitude_ports.hpp"
#include "low_pass.hpp"
#include "stator/rotation.hpp"

namespace stator::apps::attitude {

// Compares strength and dip of the field with those it had for long. A field that stays constant
// while the vehicle moves about is not the disturbance of one place: after a while it is believed.
class MagneticField {
  public:
    // Of a field sample in a level frame, `dt` after the one before: how much its direction is
    // worth, 0 to 1.
    float trust(const math::Vector3<float>& field_T, bool moving, float dt,
                const AttitudeParams& params);

  private:
    // Horizontal and downward strength, gauss.
    using Strength = Eigen::Vector2f;

    void look_for_another(bool moving, float dt, const AttitudeParams& params);

    Strength now_ = Strength::Zero();
    Strength usual_ = Strength::Zero();
    Strength candidate_ = Strength::Zero();
    FollowGain smoothing_;
    float undisturbed_s_ = 0.0F;
    float candidate_s_ = 0.0F;
    float rejected_s_ = 0.0F;
};

}  // namespace stator::apps::attitude
