// Inclination from the low-passed specific force.
#include "inclination.hpp"

namespace stator::apps::attitude {

Eigen::Vector2f Inclination::correct(float dt, float time_constant) {
    const Vector up(0.0F, 0.0F, -1.0F);
    force_I_.update(felt_I_.take(), dt, time_constant);
    const Vector force_T = math::normalized(Vector(q_TI_ * force_I_.value()), up);
    if (force_T.z() > -0.9F) {
        q_TI_ = math::normalized(math::from_two_vectors(force_T, up) * q_TI_);
        return Eigen::Vector2f::Zero();
    }
    // The shortest turn that takes force_T up, as from_two_vectors, for small angles.
    const float cos_half = math::sqrt(0.5F - 0.5F * force_T.z());
    const float scale = 0.5F / cos_half;
    const Quaternion turn(cos_half, -force_T.y() * scale, force_T.x() * scale, 0.0F);
    q_TI_ = math::normalized(turn * q_TI_);
    return {force_T.y(), -force_T.x()};
}

}  // namespace stator::apps::attitude
