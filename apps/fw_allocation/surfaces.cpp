// Control surfaces by the pseudo-inverse.
#include "surfaces.hpp"

#include <algorithm>

namespace stator::apps::fw_allocation {

using math::Vector3;

void Surfaces::set_effectiveness(std::span<const Vector3<float>> effectiveness) {
    count_ = static_cast<unsigned>(std::min<std::size_t>(effectiveness.size(), kMaxSurfaces));
    const auto surfaces = effectiveness.first(count_);
    Vector3<float> most = Vector3<float>::Zero();
    for (const Vector3<float>& surface : surfaces) most += surface.cwiseAbs();
    const auto normalized = [&](const Vector3<float>& surface) {
        Vector3<float> column = Vector3<float>::Zero();
        for (int axis = 0; axis < 3; ++axis) {
            if (most[axis] > 0.0F) column[axis] = surface[axis] / most[axis];
        }
        return column;
    };
    math::Matrix3<float> gram = math::Matrix3<float>::Zero();  // B * B^T
    for (const Vector3<float>& surface : surfaces) {
        const Vector3<float> column = normalized(surface);
        gram += column * column.transpose();
    }
    for (int axis = 0; axis < 3; ++axis) {
        if (!(most[axis] > 0.0F)) gram(axis, axis) = 1.0F;
    }
    const math::Matrix3<float> inverse = gram.inverse();
    for (unsigned i = 0; i < count_; ++i) share_[i] = inverse * normalized(surfaces[i]);
}

void Surfaces::allocate(const Vector3<float>& torque, std::span<float> control) const {
    for (unsigned i = 0; i < count_; ++i) {
        control[i] = math::clamp(share_[i].dot(torque), -1.0F, 1.0F);
    }
}

}  // namespace stator::apps::fw_allocation
